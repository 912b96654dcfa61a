"""Replicas of coupled contacts, N of them on one soft slider each: following one, and the result of all."""

from collections.abc import Callable
from typing import Any

import numpy as np

from eq_model.blocks import Blocks, State, check_dropped
from eq_model.coupled.work import check_work, growth
from eq_model.engine import StretchLimits
from eq_model.result import SIZES, CoupledSlips, means
from origins import Contacts, Drive, ProportionalGrowth, identical
from origins.contacts import check_contacts
from origins.drive import SLIP_FRACTION
from origins.errors import InputError, positive, refuse
from origins.thresholds.law import Array

LARGEST = 2.0**61  # largest position, in units: sums of two are whole numbers of 64 bits

# Of F before a slip: one contact of 2^31 that holds bears more, unless it is stretched by less than 2e-3 <x_s>.
ROUND_OFF = 1e-12


class CoupledSliders:
    """Replicas, a block each, on a slider that `drive` pulls; a slip breaks at least `slip_fraction` of the contacts
    (None: 0.2). `dropped` says, asked now and then, whether to give up the one that is followed."""

    MOST = 1 << 31  # largest number of contacts of a replica
    nothing = State()

    def __init__(
        self,
        contacts: Contacts,
        drive: Drive,
        blocks: Blocks,
        seed: int,
        slip_fraction: float | None,
        dropped: Callable[[], bool] | None = None,
    ) -> None:
        """Choose the unit of length; InputError for what is not followed, and for what would take too long."""
        from eq_model.draws.births import births_of

        check_coupled(contacts, drive)
        self._contacts, self._drive, self._seed, self.blocks = contacts, drive, seed, blocks
        self._dropped = dropped
        self._n, self._unit = blocks.each, unit_of(contacts)
        self.slip_fraction = checked_slip_fraction(slip_fraction)
        self._births = births_of(contacts, self._unit)
        self._prepare()

    def _prepare(self) -> None:
        """Make what sliders of this kind need; InputError for paths that are not followed."""
        raise NotImplementedError


class Replicas(CoupledSliders):
    """Follows replicas on a slider without mass."""

    def _prepare(self) -> None:
        """Choose the buckets of waiting breaks, and how many breaks are followed at most."""
        from eq_model.coupled.queue_kernel import bucket_bits, ring_bits

        contacts, drive, n = self._contacts, self._drive, self._n
        law, mean = contacts.thresholds, contacts.mean_threshold
        numbered = contacts.growing is not None or contacts.thermal is not None
        self._shift = bucket_bits(
            n, mean / self._unit, lambda width: float(law.cdf(width * mean)), numbered
        )
        # one contact in a thousand breaks beyond
        span = float(law.isf(2.0**-10)) * growth(contacts, drive)
        self._limits = StretchLimits(contacts, drive)
        span = min(span, self._limits.largest_threshold)
        self._ring_bits = ring_bits(n, self._shift, mean / self._unit, span / self._unit)
        refuse_beyond(drive, LARGEST * self._unit, self._unit)
        self._most = check_work(contacts, drive, n)

    def fields(self, state: State) -> dict[str, Any]:
        """Fields of the result."""
        tables = state.rows, state.slips.reshape(-1, 8)
        rows, slips = (table[np.argsort(table[:, 0], kind="stable")] for table in tables)
        # a row: its replica's number, breaks, X_T = F(0)/K, avalanches by class; then X, F and the fraction that holds
        numbers, avalanches, curves = np.split(rows, [3, 3 + SIZES], axis=1)
        curves = curves.reshape(len(rows), 3, -1)
        fields: dict[str, Any] = {"positions": curves[:, 0], "forces": curves[:, 1]}
        for k, name in enumerate(("position", "force", "holding")):
            fields[name], fields[f"{name}_standard_error"] = means(curves[:, k])
        columns: list[Any] = list(slips.T)
        for whole in (0, 1, 7):
            columns[whole] = columns[whole].astype(np.int64)
        # F before and after: where no contact holds K (X_T - X) is the round-off of two lengths that are equal
        columns[6][np.abs(columns[6]) < ROUND_OFF * np.abs(columns[5])] = 0.0
        return fields | {
            "slips": CoupledSlips(*columns),
            "avalanches": avalanches.astype(np.int64),
            "balance": float(numbers[:, 2].mean()),
            "step_error": np.zeros(curves.shape[2]),
            "slip_fraction": self.slip_fraction,
        }

    def follow(self, replica: int) -> State:
        """Follow a replica while its slider is pulled to the end of the path; -1 only compiles.

        Raises InputError where contacts would break while the drive moves back to its first point, and DroppedError.
        """
        from eq_model.coupled import slide_kernel as kernel
        from eq_model.coupled.ages import NoHeat, ages_of
        from eq_model.coupled.heat import heat_of
        from eq_model.coupled.heat_moves import begin_with_heat
        from eq_model.coupled.queue_kernel import make_queue
        from eq_model.coupled.slider import SLIDER
        from eq_model.coupled.turns import legs_of, turn
        from eq_model.draws.streams import make_stream
        from eq_model.draws.supply import make_supply

        if replica < 0:
            few, mean = few_contacts(self._contacts), self._contacts.mean_threshold
            path = [3.0 * mean, 2.0 * mean] if self._may_turn() else [3.0 * mean]
            # so fast that contacts in heat break a few times at most
            rate = 1.0 if few.thermal is None else few.thermal.rates.scale
            drive, blocks = Drive(path, mean * rate, spring=1.0), Blocks(2, 2)
            Replicas(few, drive, blocks, seed=0, slip_fraction=1.0).follow(0)
            return self.nothing
        check_dropped(self._dropped)
        n, unit, contacts = self._n, self._unit, self._contacts
        stream = make_stream(self._seed, replica)
        mean = contacts.mean_threshold / unit if contacts.stiffness == "linked" else 0.0
        first, later = (make_supply(births, stream, mean) for births in self._births)
        heat = heat_of(contacts, self._drive, n, unit, stream)
        ages, warm = ages_of(contacts, n, heat), not isinstance(heat, NoHeat)
        queue = make_queue(4 * n if warm else n, self._shift, self._ring_bits)
        slider, slips = np.zeros(1, SLIDER), list[Array]()
        s = slider[0]
        s["way"], s["back"], s["drive"] = 1, -(1 << 62), -np.inf  # never, and nowhere
        s["age"] = 0.0 if contacts.growing is None else contacts.growing.start_pinned_for
        kernel.form_all(slider, queue, first, ages, n)
        s["age"], spring = 0.0, (self._drive.spring or 0.0) * n
        if warm:
            begin_with_heat(slider, queue, ages)
        balance, room = s["force"] / spring * unit, np.empty((2, n), np.int64)
        rules, curves = self._rules(), list[Array]()
        for leg in legs_of(self._drive, balance):
            pull = self._pull(rules, leg, s)
            if leg.direction != s["way"]:
                turn(slider, queue, ages, pull, *room)
            while (reason := kernel.slide(slider, queue, later, ages, pull)) != kernel.PATH_DONE:
                if reason == kernel.SLIP_ENDED:
                    slip = leg.direction * pull.avalanche[:-1]
                    slips.append(np.r_[replica, len(slips), slip, pull.avalanche[-1]])
                elif reason == kernel.OVERTAKEN:
                    raise InputError(
                        "reforming: contacts that form again stretched forward take the slider far beyond the drive; "
                        "use a stiffer spring, or stretches closer to 0"
                    )
                if s["breaks"] > self._most:  # a slider that creeps takes more than one that slips
                    at = leg.direction * (s["base"] + s["drive"] / spring) * unit
                    hint = f"takes more than {self._most:.0e} breaks of {n} contacts, here up to X_T = {at:.4g}"
                    refuse("path[-1]", self._drive.path[-1], f"{hint}; end the path before")
                check_dropped(self._dropped)
            curves.append(np.array([[leg.direction], [leg.direction], [1]]) * pull.at_points)
        each = unit / n
        x, force, holding = np.concatenate(curves, axis=1) + 0.0  # no number is -0
        numbers = replica, s["breaks"], balance
        row = np.r_[numbers, rules.avalanches, x * unit, force * each, holding / n]
        # a slip's X_T in two parts: K (X_T - base), and the base
        scales = [1.0, 1.0, unit / spring, unit, unit, unit, each, each, 1.0]
        table = np.reshape(slips, (-1, 9)) * scales + 0.0
        table[:, 2] += table[:, 3]
        table = np.delete(table, 3, axis=1)
        return State(rows=row[None], slips=table, breaks=int(s["breaks"]))

    def _may_turn(self) -> bool:
        """Whether the drive goes back anywhere, also to its first point from where it balances the start."""
        path, start = self._drive.path, self._contacts.start.span
        return start != (0.0, 0.0) or path[0] < 0.0 or bool((np.diff(path) < 0.0).any())

    def _rules(self) -> Any:
        """The Pull of a slider without a leg of the drive."""
        from eq_model.coupled.slider import Pull

        n, drive, delay = self._n, self._drive, self._contacts.delay
        waits, nowhere = 1 if delay is None else n + 1, np.empty(0)
        return Pull(
            n=n,
            spring=(drive.spring or 0.0) * n,
            path=nowhere,
            time=nowhere,
            clock=nowhere,
            clock_drive=nowhere,
            wait=-1.0 if delay is None else delay.time,
            slip=max(int(np.ceil(self.slip_fraction * n)), 1),
            at_once=drive.slip == "instant" and delay is None,
            resets=drive.slip == "reset",
            furthest=0,
            avalanche=np.empty(7),
            at_points=np.empty((3, 0)),
            avalanches=np.zeros(SIZES, np.int64),
            due=np.empty(waits),
            many=np.empty(waits, np.int64),
        )

    def _pull(self, rules: Any, leg: Any, s: np.void) -> Any:
        """The Pull of a slider on a leg of the drive, mirrored where that goes back."""
        places, clock, limits = leg.direction * leg.places / self._unit, leg.clock, self._limits
        # relaxed contacts come to rest behind the drive; before they do, the slider has passed where all others are
        begin, furthest = leg.direction * s["way"] * s["at"], limits.largest_threshold / self._unit
        if leg.first == 0:
            furthest = limits.largest_birth / self._unit
        return rules._replace(
            path=places[1:],
            time=clock[1:],
            # at the end the drive holds
            clock=np.append(clock, clock[-1] + 1.0),
            clock_drive=np.append(places, places[-1]),
            furthest=int(max(begin, places[-1]) + furthest) + 1,
            at_points=np.zeros((3, places.size - 1)),
        )


def checked_slip_fraction(slip_fraction: float | None) -> float:
    """The smallest fraction of the contacts that breaks in a slip; InputError unless it is one."""
    # before a slip avalanches break up to 2 N^(-1/3) of the contacts, 0.13 at N = 4,000; slips of a spring below
    # 0.7 K* break most of them
    fraction = SLIP_FRACTION if slip_fraction is None else positive("slip_fraction", slip_fraction)
    if fraction > 1.0:
        refuse("slip_fraction", slip_fraction, "must be at most 1, a share of the contacts")
    return fraction


def few_contacts(contacts: Contacts) -> Contacts:
    """Contacts of one threshold, with the laws for which kernels are compiled, those of rates and of growth; the same
    kernels serve all others."""
    # a temperature belongs to the mean threshold
    one, law = identical(contacts.mean_threshold), contacts.growing
    grown = law.over(one) if isinstance(law, ProportionalGrowth) else one
    return Contacts(grown, thermal=contacts.thermal)


def unit_of(contacts: Contacts) -> float:
    """The length of which all positions and thresholds are whole multiples: 2^-28 mean thresholds, or more if the
    largest threshold would exceed 2^40 of them."""
    from eq_model.draws.births import tables_of

    largest = tables_of(contacts)["thresholds"].largest
    return max(2.0**-28 * contacts.mean_threshold, 2.0**-40 * largest)


def refuse_beyond(drive: Drive, most: float, unit: float) -> None:
    """InputError for a drive that goes further than `most` (a length), where positions have no whole units left."""
    far = int(np.argmax(np.abs(drive.path)))
    if abs(drive.path[far]) > most:
        last = far == drive.path.size - 1
        hint = f"must be below {most:.3g}; positions are whole multiples of {unit:.3g}"
        refuse("path[-1]" if last else f"path[{far}]", drive.path[far], hint)


def check_coupled(contacts: Contacts, drive: Drive) -> None:
    """Raise InputError for laws and paths that cannot be followed on a soft slider."""
    heavy = drive.mass is not None
    solver = "eq_model.simulate with a mass" if heavy else "eq_model.simulate with a spring"
    takes = ["delay", "reforming", "stiffness"]
    if isinstance(contacts, Contacts) and contacts.thermal is not None:
        if contacts.thermal.closure == "paper":
            raise InputError(
                'contacts.thermal: closure = "paper" is an approximation of the master equation; use closure = "exact"'
            )
        takes.append("thermal")
    if isinstance(contacts, Contacts) and isinstance(contacts.growing, ProportionalGrowth):
        takes.append("growing")
    check_contacts(contacts, solver, tuple(takes), own_rates=True, other="master.solve")
    if heavy and contacts.reforming is not None:
        raise InputError(
            f"contacts.reforming: {solver} takes contacts that form again at x = 0; leave out reforming, or the "
            "mass, or use master.solve"
        )
    if contacts.reforming is not None and (drive.slip != "instant" or contacts.delay is not None):
        raise InputError(
            "contacts.reforming: contacts that form again stretched after an avalanche would pull "
            f'the slider once more; {solver} takes them with slip = "instant" and no delay'
        )
    back = np.flatnonzero(np.diff(drive.path) < 0.0)
    if heavy and back.size:
        at = int(back[0]) + 1
        why = "it tells slips by falls of the spring's force, which the way back makes, too"
        hint = f"lies behind path[{at - 1}]; {solver} takes a drive that does not turn: {why}"
        if contacts.stiffness != "linked":
            hint += "; use master.solve, which takes turns"
        refuse(f"path[{at}]", drive.path[at], hint)
