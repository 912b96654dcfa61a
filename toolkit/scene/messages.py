"""What solvers say, with the units of a scene: they know lengths, times and damping as bare numbers."""

import re

from toolkit.scene.scale import PREFIXED, Scale, written

# words before a number of a solver's message, by what it is
_OF_LENGTH = (
    "X_T = ",
    " X = ",
    "end the path before ",
    "a slider with mass goes on by ",
    "the slider goes by ",
)
_OF_TIME = "lasts some ", " t = ", "to a time of some "
_OF_DAMPING = (
    "falls with the speed by ",
    "damping is ",
    "slider that sticks is ",
    "mass and spring is ",
)
# words before a number of mean thresholds that is a length; others are forces
_OF_WAY = "goes on for |hold for up to |are followed for "
_NUMBER = r"(-?\d+(?:\.\d+)?(?:e[+-]?\d+)?)"


def with_units_of(scale: Scale, message: str, mean: float | None = None) -> str:
    """A solver's message with its positions, times and damping in SI units, where the scale has metres; and with what
    it tells in mean thresholds, if one is given as `mean`, a length."""
    if scale.length_unit != "m":
        return message
    units = dict.fromkeys(_OF_DAMPING, (scale.spring, scale.damping_unit))
    if scale.spring_unit == "N/m":
        units |= {"mass = ": (scale.spring, "kg")}
    units |= dict.fromkeys(_OF_LENGTH, (1.0, "m")) | dict.fromkeys(_OF_TIME, (1.0, scale.time_unit))
    for before, (factor, unit) in units.items():

        def told(found: re.Match[str], factor: float = factor, unit: str = unit) -> str:
            """The number to the digits that it has, three at least."""
            digits = len(re.sub(r"e.*|\D", "", found[2]).lstrip("0"))
            if unit == "kg":  # a number as it was given
                return f"{found[1]}{factor * float(found[2]):.6g} {unit}"
            return found[1] + written(factor * float(found[2]), unit, digits=max(digits, 3))

        message = re.sub(f"({re.escape(before)}){_NUMBER}", told, message)

    def in_thresholds(found: re.Match[str]) -> str:
        """A length, or a force."""
        is_length = found[1] is not None
        if mean is None or not (is_length or scale.force_unit in PREFIXED):
            return found[0]
        factor, unit = (1.0, "m") if is_length else (scale.force, scale.force_unit)
        return f"{found[1] or ''}{written(factor * mean * float(found[2]), unit, digits=2)}"

    return re.sub(f"({_OF_WAY})?{_NUMBER} mean thresholds(?: of force)?", in_thresholds, message)
