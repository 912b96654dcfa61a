"""Whether slips hang on heat that is left out, by a bound on what it changes and by rigid sliders in heat."""

import numpy as np

from master.soft.cold_contacts import ColdContacts
from master.soft.curve import SlipBegin
from master.soft.first_fall import slips_alike
from master.soft.moves import BEHIND_BEGIN, OF_TRAVEL, Move
from origins import Contacts, Drive

# Parts of a panel at which the slope of the load is looked at; and by how many times it has to exceed the slope that
# counts as none for the load to go on rising.
LOOKED_AT, RISES_AGAIN = np.linspace(0.0, 1.0, 9), 2.0


class LeftOut:
    """Heat that is left out of these contacts, `cold.unknown` being what it changes in the force at most (a length)."""

    def __init__(self, cold: ColdContacts, drive: Drive, in_heat: Contacts | None) -> None:
        """`in_heat` : the contacts with it, if rigid sliders may be asked."""
        self._cold, self._drive, self._in_heat = cold, drive, in_heat
        # whether new contacts in heat first slip as those without it, by the travel that was asked about
        self._alike = dict[float, bool]()

    def decides(self, move: Move, slip: SlipBegin, after: float, renews: bool) -> bool:
        """Whether it may take this slip away, or bring one about between the travel `after` and this one. `renews` :
        whether the slip renews all contacts: else what it leaves hangs on heat, too, although it begins alike."""
        if not self._may_decide(move, slip, after):
            return False
        return not (renews and self._slips_alike(move, slip, after))

    def _may_decide(self, move: Move, slip: SlipBegin, after: float) -> bool:
        """The same by the bound alone.

        Heat takes the slip away where the load falls by less, behind its begin, than twice what heat changes the force
        by. It shifts breaks by a small part of a threshold, which changes the load's slope by that part of the largest
        slope, `steep`. So a slip may come before where the slope is below `steep` and rises again. That matters where a
        slip renews contacts; under "instant" it changes next to nothing.
        """
        missed = 2.0 * slip.error
        steep, curve = missed / self._cold.break_length, slip.curve
        if self._drive.slip != "instant":
            y = (curve.from_travel[:, None] + curve.width[:, None] * LOOKED_AT).ravel()
            slope = curve.load_slope(y[(y > after) & (y < slip.travel)])
            flat = np.flatnonzero(slope < steep)
            if flat.size and (slope[flat[0] :] > RISES_AGAIN * steep).any():
                return True
        if not np.isfinite(slip.load):
            return False
        falling = min(BEHIND_BEGIN * slip.begin_error, OF_TRAVEL * curve.to_travel)
        begin, to = slip.travel + falling, slip.travel
        while True:
            curve = move.curve_to(to, after)
            rises = curve.rises(begin)
            last = min(rises, curve.to_travel)
            if slip.load - float(curve.force(last)) - curve.spring * last >= missed:
                return False
            if np.isfinite(rises):
                return True
            to = curve.to_travel + self._cold.life.resolution_length

    def _slips_alike(self, move: Move, slip: SlipBegin, after: float) -> bool:
        """Whether new contacts are known to slip first, or not to slip, in heat as without it."""
        new = move.loaded.march is None and move.loaded.start.span == (0.0, 0.0) and not after
        if self._in_heat is None or not new or self._drive.time is not None:
            return False
        if slip.travel not in self._alike:
            slips, effect = bool(np.isfinite(slip.load)), self._cold.unknown
            asked = slip.travel, slips, effect, self._cold.until
            self._alike[slip.travel] = slips_alike(self._in_heat, self._drive, *asked)
        return self._alike[slip.travel]
