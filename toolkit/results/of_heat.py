"""What heat changes in F_k, in words."""

from toolkit.scene.scale import Scale, written

# whose F_k it is, where a slider on a spring is told of, too
OF_RIGID = " of a rigid slider as fast as the drive"
# part of F_k from which on a change is written in per cent
IN_PER_CENT = 1e-5


def raised(warm: float, cold: float, scale: Scale, at: str = OF_RIGID) -> str:
    """By how much heat raises or lowers F_k, in words: from `cold` to `warm`, F_k/(N_c <k>) without and with heat
    (lengths). `at` : whose F_k it is."""
    change = warm - cold
    share = abs(change) / cold
    size = written(abs(change) * scale.force, scale.force_unit, digits=2)
    part = f"{100.0 * share:.2g}%" if share >= IN_PER_CENT else f"{share:.2g}"
    without = written(cold * scale.force, scale.force_unit, digits=3)
    return f"{'raises' if change > 0.0 else 'lowers'} F_k{at} by {size}, {part} of the {without} without it"
