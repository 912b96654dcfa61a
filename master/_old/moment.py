"""Q(x;X) at one moment of a path in time: of contacts born at s, the slider moving at v, E(t, s) j(s)/|v| a length."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from master._old.collocation import Course
from master._old.generations import Generations, between, grades
from master._old.panels import Panel
from master._old.pot import Pot
from master._old.replay import lived
from master._old.timeline import Piece
from origins import Contacts, InputError

Array = npt.NDArray[np.float64]

_FEW = 1e-9  # births around a jump of their number, which are not such as jump
_CHUNK = 1_000_000


@dataclass(frozen=True)
class MomentDistribution:
    """Density of stretches at one moment, and the exact single values beside it.

    Attributes
    ----------
    delta_positions, delta_weights : arrays of shape (n,)
        Stretches (lengths) shared by a finite fraction of the contacts, and that fraction: of what started from one
        stretch, broke at one, or was born in one hold.
    """

    delta_positions: Array
    delta_weights: Array
    _contacts: Contacts
    _course: Course
    _pieces: list[Piece]
    _time: float
    _place: float

    def density(self, x: npt.ArrayLike) -> Array:
        """Q(x;X) per length at stretches x (lengths), delta parts left out; same shape as x."""
        at = np.asarray(x, dtype=float)
        flat = at.ravel()
        out = np.zeros(flat.size) if self._contacts.start.is_single else self._starting(flat)
        for panel in _before(self._course.panels, self._time):
            if panel.travel == 0.0 or _at_once(panel, self._course):
                continue
            birth = self._place - flat + self._lives.again[0][0]
            share = (birth - panel.before) / panel.travel
            time = panel.begin + panel.duration * share
            born = np.flatnonzero((share > 0.0) & (share <= 1.0) & (time <= self._time))
            rate = self._course.breaks.rate(time[born]) * (panel.duration / abs(panel.travel))
            out[born] += rate * self._born(time[born], birth[born])
        return out.reshape(at.shape)[()]

    def _starting(self, x: Array) -> Array:
        """Contacts that hold since t = 0."""
        start, law = self._contacts.start, self._contacts.thresholds
        origin = x - self._place
        first, here = np.abs(origin), np.flatnonzero(start.pdf(origin) > 0.0)
        here = here[law.sf(first[here]) > 0.0]
        out = np.zeros(x.size)
        share = start.pdf(origin[here]) / law.sf(first[here]) / (1.0 - self._contacts.cut_weight)
        out[here] = share * self._left(origin[here], np.zeros(here.size), np.zeros(here.size))
        return out

    @property
    def _lives(self) -> Generations:
        # contacts that age are refused before
        lives = self._course.lives
        assert isinstance(lives, Generations)
        return lives

    def _born(self, time: Array, place: Array) -> Array:
        stretch, share = self._lives.again
        return self._left(np.full(time.size, stretch[0]), time, place) * share[0]

    def _left(self, stretch: Array, time: Array, place: Array) -> Array:
        """What is left of contacts that formed at these, times S(|r|)."""
        wear, out = self._lives.wear, np.empty(time.size)
        for some in np.array_split(np.arange(time.size), 1 + time.size * wear.width // _CHUNK):
            now, there = np.full(some.size, self._time), np.full(some.size, self._place)
            worn, birth = wear.fresh(stretch[some]), (time[some], place[some])
            out[some] = lived(wear, self._pieces, worn, stretch[some], *birth, now, there)[0].held
        return out

    def _from_one(self) -> tuple[Array, Array]:
        """Stretches and weights of what started from one stretch, or was born at one jump or in one hold."""
        zero, again = np.zeros(1), self._lives.again[0]
        stretch, weight = [], []
        if self._contacts.start.is_single:
            origin = np.array([self._contacts.start.mean()])
            stretch.append(origin + self._place)
            weight.append(self._left(origin, zero, zero) / self._contacts.thresholds.sf(np.abs(origin)))
        hold: list[Panel] = []
        for panel in [*_before(self._course.panels, self._time), None]:
            if panel is not None and panel.travel == 0.0:
                hold.append(panel)
                continue
            if hold:
                stretch.append(self._place - hold[-1].after + again)
                weight.append(self._since(hold))
                hold = []
            if panel is not None and _at_once(panel, self._course):
                place = panel.births(panel.nodes)
                stretch.append(self._place - place + again)
                weight.append(_births(panel, self._course) * self._born(panel.nodes, place))
        return np.concatenate([[], *stretch]), np.concatenate([[], *weight])

    def _since(self, hold: list[Panel]) -> Array:
        """What is left of contacts born in a hold, on panels the last of which may be going on."""
        lives, end = self._lives, min(hold[-1].end, self._time)
        keeper = lives.wear.keeper()
        pot = None if keeper is None else Pot(keeper, lives.again)
        left = np.zeros(1)
        for panel in hold:
            until = min(panel.end, self._time)
            part = Panel(panel.begin, until, panel.before, panel.after, panel.count)
            time, share = between(part, np.unique(grades(part, 0.0, lives.wear.time)), lives.nodes)
            births = share * self._course.breaks.rate(time)
            if pot is None:
                left += births @ self._born(time, np.full(time.size, panel.after))
            else:
                pot.add(part.duration, until - time, births)
        if pot is None or keeper is None:
            return left
        if end == self._time:
            return pot.left(np.zeros(1))[0]
        total, worn = pot.merged()
        if total <= 0.0:
            return np.zeros(1)
        stretch, share = lives.again
        at, now, there = (np.array([x]) for x in (hold[-1].after, self._time, self._place))
        kept, _ = lived(keeper, self._pieces, worn, stretch, np.array([end]), at, now, there)
        return total * share * kept.held


def distribution_at(
    contacts: Contacts, course: Course, pieces: list[Piece], time: float, place: float
) -> MomentDistribution:
    """Q(x;X) at a time, when the slider is at X = place."""
    again = contacts.reforming
    if again is not None and not again.law.is_single:
        raise InputError("contacts.reforming: Q(x;X) is not known yet where contacts form again at many stretches")
    # around a jump all that breaks is broken
    around = [panel.end for panel in course.panels if panel.count == 1 and panel.begin < time <= panel.end]
    time = max(time, *around) if around else time
    bare = MomentDistribution(np.empty(0), np.empty(0), contacts, course, pieces, time, place)
    positions, weights = bare._from_one()
    keep = weights > 0.0
    return MomentDistribution(positions[keep], weights[keep], contacts, course, pieces, time, place)


def _before(panels: list[Panel], time: float) -> list[Panel]:
    return [panel for panel in panels if panel.begin < time]


def _births(panel: Panel, course: Course) -> float:
    """Births on a panel of one node."""
    return float(course.breaks.rate(panel.nodes)[0]) * panel.duration


def _at_once(panel: Panel, course: Course) -> bool:
    """Whether a finite share was born there at one X."""
    return panel.count == 1 and _births(panel, course) > _FEW
