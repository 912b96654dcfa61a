"""March: number conservation solved panel after panel, along any motion of a rigid slider.

With B(t) the breaks per contact since t = 0, at every t

    1 = G_0(t) + integral over s of N(t, s) dB(s),      F(t) = M_0(t) + integral of K(t, s + delay) dB(s),

where contacts that broke at s count as N = 1 until s + delay, while they are out, and as E(t, s + delay) after, when
they are born again; K is 0 while they are out (births.py). G_0 and M_0 are sums over lumps: the
contacts that hold at t = 0, and sets of contacts that break at one instant because they reach one exact threshold
together, and are born again together one delay later. On a panel B is a polynomial; its values at the Radau nodes
follow from conservation there, given all panels before. A panel that does not resolve B is narrowed.
"""

from collections.abc import Iterator

import numpy as np

from master.outcome import FaultError, StoppedError, stop_after
from master.renewal.births import MOST_WORK, Births, Jump, Lump, panel_at
from master.renewal.panel_width import PanelWidth
from master.renewal.past import Past
from master.renewal.present import TARGETS, Batch, Present, solve_batch
from master.renewal.solved import SolvedPanels
from master.survival.life import NO_SURVIVAL
from origins.start import Start
from origins.thresholds.law import Array

# Breaks count as steady where their rates agree over CYCLES longest cycles, a tenth more than one against the rounding
# of times, to AGREE of the tolerance: the changes that may follow are added to the error, and panels keep most of the
# tolerance. A march ends early only where CYCLES_AHEAD longest cycles lie ahead: to test it costs a few panels.
CYCLES, AGREE, CYCLES_AHEAD = 1.1, 0.25, 8.0
# About the work of solving a panel, in pieces of integrals over births.
WORK_OF_PANEL = 100
# Width of the last panel without births, in that of the first guess.
SHORT_LAST = 1e-6
# Part of a panel's width by which rounding may put its beginning before that of its leg.
SAME_BEGIN = 1e-9
# Share of the contacts that break at an edge together, below which they are the rounding of conservation.
LEAST_LUMP = 1e-15


class March:
    """Breaks and force on panels, by number conservation (paper, Eq. Q5c), batch after batch.

    start : law of the stretches at t = 0
    edges : sorted times at which the number of breaks may bend or jump; the first is 0
    tolerance : largest error of a panel, a share of the contacts: of the number of breaks, and of the force divided by
        `longest_stretch`, together; soft/moves.py, which plans a move piece by piece, sets edges and tolerance anew
    guess : the first guess of the width of a panel, a length
    longest_stretch : that of the births

    solved : the panels so far
    lumps : the start first; their times are on the path
    present, _past : sums over births on the present leg, and over all other contacts
    widths : how wide the next panels are
    steady_since : when the march ended because breaks were steady; inf where they were not
    unfinished, fault : whether it was stopped before the last edge, and the fault of the program if one stopped it
    jumps : those on its panels, in the order of time
    open_end : whether the last edge is no kink, but as far as the march is planned: it may end a panel before
    """

    def __init__(
        self, births: Births, start: Start, edges: Array, tolerance: float, guess: float
    ) -> None:
        """Begin with the start as the only lump, before the first panel."""
        self.births, self.life, self.motion = births, births.life, births.motion
        self.edges, self.tolerance = edges, tolerance
        self.guess, self.longest_stretch = guess, births.longest_stretch

        self.solved = SolvedPanels()
        self.lumps = [Lump(0.0, 1.0, start)]
        self.present, self._past = Present(births), Past(births)
        self.widths, self.steady_since = PanelWidth(self.life.quick), np.inf
        self.unfinished, self.fault, self.open_end = False, "", False
        self.jumps = list[Jump]()

        # whether all contacts of the start are as if born at t = 0: G_0(t) = E(t, 0), in the table of the first leg
        same_stretch = start.is_single and start.span == births.law.span
        self._start_is_birth = same_stretch and self.life.start_as_births

    @property
    def survival_error(self) -> float:
        """Largest error of a survival: of a birth on the present leg, or of an earlier one."""
        return max(self.present.error, self._past.survival_error)

    @property
    def unseen_error(self) -> float:
        """What the residuals of the panels are blind to, a share of the contacts: the errors of survivals, and of the
        sums over earlier births (see ErrorBudget). A wrong survival conserves the number as well as the right one."""
        return self.survival_error + self._past.error

    def run(self) -> "March":
        """Solve all panels; on a single leg, those until breaks have become steady."""
        try:
            for _ in self.batches():
                if self.motion.one_leg and self._steady():
                    # The later changes that `_steady` allows are added to the error, as going on would cost digits.
                    # F is read amid the last panel, where rounding puts no time behind its end.
                    self.steady_since = self.solved.end - 0.5 * self.solved.width[-1]
                    self.solved.error[-1] += AGREE * self.tolerance
                    break
        except StoppedError as why:
            self.unfinished = True
            self.fault = str(why) if isinstance(why, FaultError) else ""
        return self

    def batches(self) -> Iterator[None]:
        """Solve all panels, yielding after each good batch of them."""
        fastest = int(np.abs(self.motion.speeds).argmax())
        slack = SAME_BEGIN * self.motion.duration(self.guess, fastest)
        legs = self.motion.legs_between(self.edges, slack)
        for begin, end, leg in zip(self.edges[:-1], self.edges[1:], legs.tolist(), strict=True):
            self._break_lumps(begin, end)
            yield from self._segment(leg, begin, end)

    def _segment(self, leg: int, begin: float, edge: float) -> Iterator[None]:
        """Solve from an edge to the next, yielding after each good batch. Clocks: past.py."""
        leg_start_path = float(self.motion.times[leg])
        open_end = self.open_end and edge == self.edges[-1]
        segment_begin_leg, edge_leg = begin - leg_start_path, edge - leg_start_path
        tolerance, widths, now_leg = self.tolerance, self.widths, segment_begin_leg
        guess_duration = self.motion.duration(self.guess, leg)
        whole_life = self.motion.duration(self.life.largest_stretch, leg)
        widths.begin(leg, edge_leg - now_leg, guess_duration, whole_life, tolerance, open_end)
        while not widths.at_edge(edge_leg - now_leg):
            stop_after(self.births.until)
            proposal = widths.propose(edge_leg - now_leg)
            batch = self._solve_batch(leg, now_leg, proposal.width, proposal.panels)

            # Panels before the first that is off by more than the tolerance are kept; from there on they are solved
            # again, narrower. All of the batch are kept with their errors where halving would only resolve rounding, as
            # at a jump of the breaks, and beyond the allowed work: solved again at this width they would be the same.
            too_narrow = widths.too_narrow(now_leg)
            keep_all = too_narrow or self.births.work > MOST_WORK
            now_path = leg_start_path + now_leg
            rejected = np.flatnonzero(batch.error > tolerance)
            if rejected.size and too_narrow:
                first_rejected = int(rejected[0])
                at_path = now_path + first_rejected * proposal.width
                at_edge = now_leg == segment_begin_leg and not first_rejected
                error = float(batch.error[first_rejected])
                self.jumps.append(Jump(at_path, leg, error, behind_edge=at_edge))
            kept = batch.error.size if keep_all or not rejected.size else int(rejected[0])
            self.solved.append(
                batch, kept, begin=now_path, breaks_begin_own_leg=now_leg, width=proposal.width
            )

            at_end = kept >= proposal.to_edge and not open_end
            now_leg = edge_leg if at_end else now_leg + kept * proposal.width
            if kept < batch.error.size:
                widths.narrow(kept, float(batch.error[kept]))
            else:
                most = float(np.abs(batch.breaks[:, -1]).max())
                widths.widen(proposal, batch.error, broken=most, unresolved=keep_all)
                yield

    def longest_cycle(self, leg: int) -> float:
        """The longest time from a break to the next one of the same contact, which is out for the delay, then holds."""
        return self.present.straight(float(self.motion.speeds[leg])).longest + self.births.delay

    def _oldest_that_counts(self, t: float, leg: int) -> float:
        """Contacts that broke before this time on the path neither are out nor hold at the time t on this leg."""
        return t - self.longest_cycle(leg)

    def _steady(self) -> bool:
        """Whether breaks have been steady for longer than any cycle. Each rate of breaks is a mean of those at most a
        longest cycle before (renewal equation); where these agree to the tolerance, so do all that follow."""
        cycles, speed = CYCLES * self.longest_cycle(0), self.motion.speeds[0]
        solved, now = self.solved, self.solved.end
        after_last_lump, ahead = now - self.lumps[-1].birth, self.edges[-1] - now
        if not speed or after_last_lump < cycles or ahead < CYCLES_AHEAD * cycles:
            return False
        rates = solved.rates_from(now - cycles)
        rates_agree = np.ptp(rates) < AGREE * self.tolerance * rates.mean()
        change = float(np.ptp(solved.force[-len(rates) :]))
        return bool(rates_agree and change < AGREE * self.tolerance * self.longest_stretch)

    def _solve_batch(self, leg: int, begin_leg: float, width: float, count: int) -> Batch:
        """Solve panels of one width, the first of which begins at `begin_leg`."""
        self.births.work += WORK_OF_PANEL * count
        speed, same_width = float(self.motion.speeds[leg]), self._count_same_width(width, leg)
        of_panel = self.present.panel_sums(speed, width, same_width + count)
        targets_leg = begin_leg + width * (np.arange(count)[:, None] + TARGETS)
        self._past.enter(leg, self.solved)  # if it is not yet
        from_others = self._sums_on_leg(leg, targets_leg, same_width)
        breaks_same_width = self.solved.breaks[self.solved.count - same_width :]
        return solve_batch(of_panel, from_others, breaks_same_width, self.longest_stretch)

    def _count_same_width(self, width: float, leg: int) -> int:
        """How many of the last panels have this width and breaks on this leg, so that PanelSums hold for them: there
        survival depends on the lag alone. Panels from so long ago that none holds are left out. Fewer would cost time
        only; one more would be wrong, which may not show: its width is another, or Past counts its births, too."""
        # one width before, as a panel's last breaks come one after its first; and one more, amply for rounding
        oldest = self._oldest_that_counts(self.solved.end, leg) - 2.0 * width
        leg_start_path = float(self.motion.times[leg])
        return self.solved.count_same_width(width, max(oldest, leg_start_path - SAME_BEGIN * width))

    def enter_and_sum_at(self, t: Array) -> Array:
        """As `_sums_on_leg`, at times t in rows, all on one leg, which is entered for good; (2, *t.shape)."""
        leg = self.motion.leg_of_all(t)
        self._past.enter(leg, self.solved)
        return self._sums_on_leg(leg, t - self.motion.times[leg])

    def _sums_on_leg(self, leg: int, grid_leg: Array, same_width: int = 0) -> Array:
        """Number and force at later times on the leg that is entered (Past.enter); (2, *grid_leg.shape).

        Panels on the time axis, and who adds the contacts that are born of their breaks:

            | births on earlier legs | on this leg, other widths | this leg, same width | to be solved |
              Past, and all lumps      Present.sums                PanelSums              PanelSums

        Here are the first two, and those that are out, of any panel; `solve_batch` adds the other two.

        grid_leg : times in rows
        same_width : number of the last panels that have the width of those to be solved
        """
        # on the first leg a start that is as births at t = 0 is in their table
        in_table = leg == 0 and self._start_is_birth
        lumps = self.lumps[1:] if in_table else self.lumps
        both = self._past.at(leg, grid_leg, lumps)
        if in_table:
            both += self.present.look_up(float(self.motion.speeds[leg]), grid_leg)
        t_leg = grid_leg.ravel()
        t_path = float(self.motion.times[leg]) + t_leg
        oldest = self._oldest_that_counts(float(t_path.min()), leg)
        solved, end = self.solved, self.solved.count - same_width
        first_that_counts = panel_at(solved.begin, oldest)
        born_on_leg = solved.pick(slice(max(first_that_counts, self._past.first_panel), end))
        both += self.births_on_leg(t_leg, leg, born_on_leg).reshape(both.shape)
        # breaks of all of them may be out, on whatever leg
        if self.births.delay > 0.0 and first_that_counts < end:
            out = solved.pick(slice(first_that_counts, end)).still_out(t_path, self.births.delay)
            both[0] += out.reshape(grid_leg.shape)
        return both

    def births_on_leg(self, t_leg: Array, leg: int, panels: SolvedPanels) -> Array:
        """Number and force of births on a leg at times on it, (2, n); `panels`: those of the breaks, without gaps."""
        broken = np.flatnonzero(np.abs(panels.breaks).max(axis=1) > NO_SURVIVAL)
        if not broken.size:
            return np.zeros((2, t_leg.size))
        panels = panels.pick(slice(broken[0], broken[-1] + 1))
        births_leg = panels.births(panels.births_begin(self.motion.times[leg], self.births.delay))
        return self.present.sums(float(self.motion.speeds[leg]), t_leg, births_leg)

    def _break_lumps(self, t: float, end: float) -> None:
        """Make a lump of the contacts that break together at the edge t, if any; the next edge is `end`."""
        if not t > 0.0 or not len(self.life.atoms):
            return
        number_until, number_from = self._numbers_at_edge(t, end)
        broken = number_until - number_from
        if broken > LEAST_LUMP:
            # broken at t, they are out until they are born one delay later
            self.lumps.append(Lump(t + self.births.delay, broken, self.births.law))

    def _numbers_at_edge(self, t: float, end: float) -> tuple[float, float]:
        """The number of contacts at the edge t: the limit from before, and that from after, where lumps are broken."""
        leg = int(self.motion.leg(t))
        edge_leg = t - self.motion.times[leg]
        beside = 0.5 * min(self.solved.width[-1], end - t)
        # Where the edge ends the leg the later times are asked for on it all the same: on the next leg Past would enter
        # that too early. Only the number at the edge is read, where both legs have the same stretches.
        self._past.enter(leg, self.solved)
        # a row of times is on the side of a jump on which its middle is (motion.History)
        until = self._sums_on_leg(leg, np.array([[edge_leg - beside, edge_leg]]))[0]
        after = self._sums_on_leg(leg, np.array([[edge_leg, edge_leg + beside]]))[0]
        return float(until[0, -1]), float(after[0, 0])

    def cut(self, t: float, births: Births, goes_on: bool = False) -> "March":
        """For master/soft: a march that has the contacts of this one at the time t, and none of its plans: set its
        edges before it runs. `births` are along a motion that is the same up to t, of the same life, a timeless one.
        `goes_on` : t is where the panels so far end, and the next ones may be as wide. Tests: test_soft.py."""
        start = self.lumps[0].law
        other = March(births, start, self.edges, self.tolerance, self.guess)
        # the contacts, and the errors with which they are known
        other.solved = self.solved.up_to(t, SAME_BEGIN * self.guess)
        # it has made the start, the first lump; those that break at t, born at once (no delay), it finds again
        other.lumps += [lump for lump in self.lumps[1:] if lump.birth < t]
        other._past.count_errors_of(self._past)
        other.jumps = self.jumps.copy()
        # work that is done: tables and sums of panels, found again at the widths so far; no motion changes them
        other.present = self.present.counted_on(births)
        other.widths = self.widths.after_cut(goes_on)
        births.work = self.births.work
        return other

    def postpone_births(self, begin: float, end: float) -> None:
        """For master/soft, where contacts that broke in a slip form at its end: all that are out at `end` are born
        there together, as a lump. Of the two panels
        from begin to end, without births, the last is short: `_numbers_at_edge` looks back over half of it."""
        number, _ = self.enter_and_sum_at(np.array([[end]]))
        leg_start_path = float(self.motion.times[self.motion.leg(0.5 * (begin + end))])
        nearly = end - min(SHORT_LAST * self.guess, end - begin)
        batch = Batch.of_one_panel_without_contacts()
        for first, width in ((begin, nearly - begin), (nearly, end - nearly)):
            if width > 0.0:
                on_leg = first - leg_start_path
                self.solved.append(batch, 1, begin=first, breaks_begin_own_leg=on_leg, width=width)
        self.lumps.append(Lump(end, 1.0 - float(number[0, 0]), self.births.law))
