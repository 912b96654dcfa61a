"""What sliders of finitely many contacts do that were followed along a way, beside infinitely many."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from origins.drive import RISE
from origins.errors import InputError
from origins.thresholds.law import Array
from toolkit.results.sliding import has_slid, late_force, may_go_on, mean_forces, scatter_of
from toolkit.results.slips import (
    are_fading,
    are_lasting,
    large_slips,
    main_slips,
    slips_after,
    slips_beyond,
    swing_beyond_slips,
    with_main_slips,
)
from toolkit.results.traces import trace_of
from toolkit.scene.scale import in_three_digits, told_contacts
from toolkit.verdict.sliders.by_contacts import RINGS
from toolkit.verdict.sliders.ensemble import NOT_SLID
from toolkit.verdict.sliders.late import SLIDERS, if_it_recurs, in_the_end, with_late_slips
from toolkit.verdict.sliders.plans import BEYOND, Asked
from toolkit.verdict.sliders.records import Finite
from toolkit.verdict.sliders.slips_in_time import slips_in_time
from toolkit.verdict.sliders.steady import settling_distance

# A force that rises by this part of a drop above what it was before any slip swings in falls that are no slips; and the
# part of the drop of infinitely many contacts by which it has to swing for this to be said.
UNSEEN, SWING_OF_DROP = 0.08, 0.5
# mean thresholds that each slider has moved by once it slides, and does not only stretch its contacts: between two
# slips on a soft spring the force rises with the drive
FAR = 100.0
# last part of BEYOND, on which the force is taken as that of steady sliding
SETTLED = 0.5


class Way(NamedTuple):
    """The points of the drive, X_T (n,); `steady`, the distance from the first of them behind which the force is taken
    as that of steady sliding; and `settling`, the part of the way that a transient takes at least (lengths)."""

    path: Array
    steady: float
    settling: float


class _Told(NamedTuple):
    """Sliders with the slips that are told of them; how many of these each has beside those of a transient (replicas,);
    and how many slips there are, of which main ones are told."""

    found: Any
    more: NDArray[np.intp]
    seen: int


def judged(asked: Asked, found: Any, way: Way) -> Finite:
    """What sliders do that were followed along a way: stick-slip if all slip beyond a transient, now and then if some
    do, else smooth. Raises InputError where this is not known."""
    machine, infinite, mean = asked.machine, asked.infinite, asked.contacts.mean_threshold
    drive, force = trace_of(found, 0, machine.velocity)
    seen = found.slips.drive.size
    if asked.settles:
        found = replace(found, slips=large_slips(found.slips, RISE * mean))
    found = with_main_slips(found) if asked.sticks else found
    in_time, slipped = slips_in_time(main_slips(found.slips)), bool(found.slips.drive.size)
    _check_swing(asked, found)
    found, more, seen = _slips_told(asked, found, way, seen)
    kind = "stick-slip" if more.min() >= 1 else "now and then" if (more > 0).any() else "smooth"
    followed = found.contacts // SLIDERS
    message = _of_fewer(asked, followed, kind) if followed < asked.present else ""
    finite = Finite(
        infinite.rule, followed, kind, message=message, drive=drive, force=force, in_time=in_time
    )
    if slipped:
        main = found.slips if asked.settles else main_slips(found.slips)
        smaller = 0 if asked.settles else seen - main.drive.size
        finite = with_late_slips(replace(finite, smaller=smaller), main)
        if kind == "stick-slip" and infinite.kind == "smooth":  # by chance
            spring = machine.spring if asked.settles else 0.0
            finite = if_it_recurs(finite, main, float(way.path[-1]), spring)
        if not asked.settles and (kind != "smooth" or infinite.kind != "undecided"):
            lasting = kind == "stick-slip" and asked.heavy and not message
            of_main = replace(found, slips=main)
            return in_the_end(finite, of_main, machine, asked.contacts) if lasting else finite
    return _sliding(asked, found, way, finite)


def slips_of_transient(asked: Asked) -> int:
    """How many slips finitely many contacts have beside those that go on: infinitely many that slide may have slipped
    before, and contacts that re-form at once forget their start in many slips, as F falls from static to kinetic."""
    return asked.infinite.slips if asked.flowing else 0


def _check_swing(asked: Asked, found: Any) -> None:
    """InputError for sliders that have not moved, and for those whose force swings in many small falls."""
    mean, infinite, slipped = asked.contacts.mean_threshold, asked.infinite, found.slips.drive.size
    if not slipped and not has_slid(found, mean):
        raise InputError(NOT_SLID)
    if asked.sticks:
        drop = infinite.before - infinite.after
        own_drop = float(found.slips.drop.mean()) if slipped else drop
        swing = swing_beyond_slips(found, UNSEEN * own_drop)
        if swing > SWING_OF_DROP * drop > 0.0:
            why = f"their force swings by {swing / mean:.2g} <x_s>, in falls of few of them each"
            raise InputError(why)


def _slips_told(asked: Asked, found: Any, way: Way, seen: int) -> _Told:
    """Which slips of sliders that have so many are told. Raises InputError where it is not known whether they go on."""
    infinite, sticks = asked.infinite, asked.sticks
    more = np.bincount(found.slips.replica, minlength=SLIDERS)
    # nobody knows how many of the slips that were seen of infinitely many are followed by others
    if (asked.flowing or infinite.slips) and infinite.kind == "undecided":
        sticks = _last_beside_undecided(asked, found, way)
        found = replace(found, slips=main_slips(found.slips)) if sticks else found
    if sticks:
        return _Told(found, more, seen)
    fewest = int(more.min())
    # where infinitely many slide, they may have slipped before, as F fell from static to kinetic
    more = more - infinite.slips
    if not _slips_late(asked, found, way):
        more[:] = 0  # chance has given them some more, and they are over
    elif (more > 0).any() and are_fading(found.slips):
        who, mean = told_contacts(found.contacts // SLIDERS), asked.contacts.mean_threshold
        last = found.slips.drop[found.slips.number == fewest - 1].mean() / mean
        raise InputError(
            f"{who} slip ever less, by {last:.2g} <x_s> at the end of the way, as infinitely many do"
        )
    elif not asked.settles and more.min() < 1:
        # some slip once more than others; those of a transient are over by the middle of the way
        late = slips_beyond(found.slips, float(way.path[[0, -1]].mean()))
        more = np.minimum(more, np.bincount(late.replica, minlength=SLIDERS))
        found = replace(found, slips=late) if (more > 0).any() else found
    elif (more > 0).any():  # those that infinitely many have, too, are not told
        found = replace(found, slips=slips_after(found.slips, infinite.slips))
    return _Told(found, more, found.slips.drive.size)


def _last_beside_undecided(asked: Asked, found: Any, way: Way) -> bool:
    """Whether sliders stick and slip on where nobody knows what infinitely many do. Raises InputError where their slips
    neither last nor are over."""
    infinite, number = asked.infinite, found.contacts // SLIDERS
    last = are_lasting(main_slips(found.slips), SLIDERS)
    settling = settling_distance(asked.machine, asked.contacts.mean_threshold)
    rings = asked.heavy and settling > np.ptp(way.path)
    if rings and not (last and infinite.slips):
        # falls may be those of a swing, but for those that last as they were seen of infinitely many
        raise InputError(
            "a swing of the mass takes longer to die away than their way: give a larger damping"
        )
    # those of all contacts are over where these have slid on since
    over = number >= asked.present and not _slips_late(asked, found, way)
    slipped = found.slips.drive.size
    if not (last or over) and (slipped or infinite.slips):
        why = f"{in_three_digits(number)} slip, perhaps only until they slide: what infinitely many do is not known"
        raise InputError(why if slipped else NOT_SLID)
    return last


def _slips_late(asked: Asked, found: Any, way: Way) -> bool:
    """Whether sliders whose slips are not known to last may slip beyond the way, see `may_go_on`; of contacts that
    re-form at once, whether they slip on the part that counts as steady sliding."""
    if asked.settles:
        return bool((found.slips.drive > way.path[0] + way.steady).any())
    return may_go_on(found, asked.machine.spring, way.settling, slips_of_transient(asked))


def _of_fewer(asked: Asked, followed: int, kind: str) -> str:
    """What fewer contacts than the area holds tell of these. Raises InputError where they tell nothing."""
    infinite, present = asked.infinite, in_three_digits(asked.present)
    if kind != infinite.kind:
        other = "do something else than infinitely many"
        if infinite.kind == "undecided":
            other = "do what is not known of infinitely many"
        raise InputError(
            f"{present} take too long, and {in_three_digits(followed)} {other}: {kind}"
        )
    if infinite.contacts is not None:  # few contacts told of it
        return f"the {present} of the area break too often to be followed"
    return f"as infinitely many do, and so the {present} of the area, which lie between"


def _sliding(asked: Asked, found: Any, way: Way, finite: Finite) -> Finite:
    """With the force on the part of the way along which it is taken as that of steady sliding."""
    settled, mean = way.path >= way.path[0] + way.steady, asked.contacts.mean_threshold
    forces = found.forces[:, settled]
    finite = replace(finite, fluctuation=scatter_of(forces))
    if asked.heavy:
        undecided = asked.infinite.kind == "undecided"
        return _sliding_with_mass(finite, found, settled, mean) if undecided else finite
    late = late_force(forces, way.path[settled], asked.machine.spring, lives=SETTLED * BEYOND)
    moved = float((found.positions[:, -1] - found.positions[:, 0]).min())
    rises = late.rises and moved < FAR * mean
    return replace(finite, late=late.mean, late_error=late.error, rises=rises)


def _sliding_with_mass(finite: Finite, found: Any, settled: Array, unit: float) -> Finite:
    """With the force of sliders with mass at these last points of their way, of which damping bears a part; "unknown"
    where it still swings there. `unit`: the mean threshold."""
    swing = float(np.ptp(found.forces[:, settled], axis=1).max()) / unit
    if swing > RINGS:
        why = f"their force still swings at the end of the way, by {swing:.2g} <x_s>"
        return replace(finite, kind="unknown", message=why)
    each = mean_forces(found, settled)
    error = float(each.std(ddof=1)) / SLIDERS**0.5
    return replace(finite, late=float(each.mean()), late_error=error)
