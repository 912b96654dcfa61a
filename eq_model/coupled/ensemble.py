"""Replicas of coupled contacts, N of them on one soft slider each: following one, and the result of all."""

from collections.abc import Callable
from typing import Any

import numpy as np

from eq_model.blocks import Blocks, State, check_dropped
from eq_model.coupled.work import check_work, growth
from eq_model.engine import StretchLimits
from eq_model.result import SIZES, CoupledSlips, means
from origins import Contacts, Drive, identical
from origins.contacts import check_contacts
from origins.drive import SLIP_FRACTION
from origins.errors import InputError, positive, refuse
from origins.thresholds.law import Array

LARGEST = 2.0**61  # largest position, in units: sums of two are whole numbers of 64 bits

# In mean thresholds: how far the slider may go back to the first point of the path where contacts break by heat. By
# chance it does where the start has no mean force.
MOST_BACK = 0.01


# Of F before a slip: one contact of 2^31 that holds bears more, unless it is stretched by less than 2e-3 <x_s>.
ROUND_OFF = 1e-12


class Replicas:
    """Follows replicas, a block each, on the slider that `drive` pulls; a slip breaks at least `slip_fraction` of
    the contacts (None: 0.2). `dropped` says, asked now and then, whether to give up the one that is followed."""

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
        """Choose the unit and the buckets of waiting breaks; InputError for what is not followed on a soft slider."""
        from eq_model.coupled.queue_kernel import bucket_bits, ring_bits
        from eq_model.draws.births import births_of

        check_coupled(contacts, drive)
        self._contacts, self._drive, self._seed, self.blocks = contacts, drive, seed, blocks
        self._dropped = dropped
        self._n = n = blocks.each
        self.slip_fraction, self._unit = checked_slip_fraction(slip_fraction), unit_of(contacts)
        self._births = births_of(contacts, self._unit)
        law, mean = contacts.thresholds, contacts.mean_threshold
        strengthens, warm = contacts.strengthening is not None, contacts.thermal is not None
        self._shift = bucket_bits(
            n, mean / self._unit, lambda width: float(law.cdf(width * mean)), strengthens or warm
        )
        # one contact in a thousand breaks beyond
        span = float(law.isf(2.0**-10)) * growth(contacts, drive)
        span = min(span, StretchLimits(contacts, drive).largest_threshold)
        self._ring_bits = ring_bits(n, self._shift, mean / self._unit, span / self._unit)
        if drive.path[-1] > LARGEST * self._unit:
            hint = f"must be below {LARGEST * self._unit:.3g}; positions are whole multiples of {self._unit:.3g}"
            refuse("path[-1]", drive.path[-1], hint)
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
        from eq_model.draws.streams import make_stream
        from eq_model.draws.supply import make_supply

        if replica < 0:
            # kernels are the same for all rules and laws but those of rates
            mean = self._contacts.mean_threshold  # to which a temperature belongs
            few = Contacts(identical(mean), thermal=self._contacts.thermal)
            drive, blocks = Drive([3.0 * mean], spring=1.0), Blocks(2, 2)
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
        s["back"], s["drive"] = -(1 << 62), -np.inf  # never, and nowhere
        s["age"] = 0.0 if contacts.growing is None else contacts.growing.start_pinned_for
        kernel.form_all(slider, queue, first, ages, n)
        if warm:
            s["back"] = (ages.zero - np.rint(ages.fresh / ages.fresh_ratio)).max()
        balance = s["force"] / (n * (self._drive.spring or 0.0))
        pull, each, s["age"] = self._pull(s), unit / n, 0.0
        if warm:
            begin_with_heat(slider, queue, ages)
        while (reason := kernel.slide(slider, queue, later, ages, pull)) != kernel.PATH_DONE:
            if reason == kernel.SLIP_ENDED:
                slips.append(np.r_[replica, len(slips), pull.avalanche])
            elif reason == kernel.OVERTAKEN:
                raise InputError(
                    "reforming: contacts that form again stretched forward take the slider far beyond the drive; use a "
                    "stiffer spring, or stretches closer to 0"
                )
            if s["breaks"] > self._most:  # a slider that creeps takes more than one that slips
                at = (s["base"] + s["drive"] / pull.spring) * unit
                hint = f"takes more than {self._most:.0e} breaks of {n} contacts, here up to X_T = {at:.4g}"
                refuse("path[-1]", self._drive.path[-1], f"{hint}; end the path before")
            check_dropped(self._dropped)
        x, force, holding = pull.at_points
        numbers = replica, s["breaks"], balance * unit
        row = np.r_[numbers, pull.avalanches, x * unit, force * each, holding / n]
        # a slip's X_T in two parts: K (X_T - base), and the base
        scales = [1.0, 1.0, unit / pull.spring, unit, unit, unit, each, each, 1.0]
        table = np.reshape(slips, (-1, 9)) * scales
        table[:, 2] += table[:, 3]
        table = np.delete(table, 3, axis=1)
        return State(rows=row[None], slips=table, breaks=int(s["breaks"]))

    def _move_back(self, s: np.void, load: float) -> None:
        """Move a slider whose contacts break by heat back to where it balances a load of the drive below that of the
        start. Kernels take a drive that never goes back, so that it is there from the begin on."""
        both = self._n * (self._drive.spring or 0.0) + s["stiffness"]
        displacement = int(np.rint((load - s["force"]) / both))
        if displacement * self._unit < -MOST_BACK * self._contacts.mean_threshold:
            first = s["force"] / (self._n * (self._drive.spring or 0.0)) * self._unit
            hint = f"lies behind F(0)/K = {first:.4g}, where the drive balances the start; with heat begin there"
            refuse("path[0]", self._drive.path[0], hint)
        s["force"] += s["stiffness"] * displacement
        s["at"] += displacement

    def _pull(self, s: np.void) -> Any:
        """The Pull of a slider with its first contacts, from the position that balances them on."""
        from eq_model.coupled.slider import Pull

        n, drive, unit, delay = self._n, self._drive, self._unit, self._contacts.delay
        spring = (drive.spring or 0.0) * n
        path, both, balance = drive.path / unit, spring + s["stiffness"], s["force"] / spring
        if spring * path[0] - s["force"] <= both * s["back"]:
            first = (s["force"] + both * s["back"]) / spring * unit
            raise InputError(
                f"path[0] = {drive.path[0]:g}: contacts break backwards while the drive moves there"
                f" from X_T = {balance * unit:g}, where it balances the start; begin the path above"
                f" {first:g}"
            )
        distances = np.abs(np.diff(path, prepend=balance))
        time = np.cumsum(distances) * unit / drive.velocity if drive.time is None else drive.time
        begin = balance
        if self._contacts.thermal is not None and path[0] < balance:
            begin = path[0]
            self._move_back(s, spring * path[0])
        # at the end the drive holds
        clock, places = np.r_[0.0, time, time[-1] + 1.0], np.r_[begin, path, path[-1]]
        moves = np.append(True, np.diff(clock) > 0.0)
        waits = 1 if delay is None else n + 1
        limits = StretchLimits(self._contacts, drive)
        return Pull(
            n=n,
            spring=spring,
            path=path,
            time=time,
            clock=clock[moves],
            clock_drive=places[moves],
            wait=-1.0 if delay is None else delay.time,
            slip=max(int(np.ceil(self.slip_fraction * n)), 1),
            at_once=drive.slip == "instant" and delay is None,
            resets=drive.slip == "reset",
            furthest=int((max(drive.path[-1], 0.0) + limits.largest_birth) / unit) + 1,
            avalanche=np.empty(7),
            at_points=np.zeros((3, path.size)),
            avalanches=np.zeros(SIZES, np.int64),
            due=np.empty(waits),
            many=np.empty(waits, np.int64),
        )


def checked_slip_fraction(slip_fraction: float | None) -> float:
    """The smallest fraction of the contacts that breaks in a slip; InputError unless it is one."""
    # before a slip avalanches break up to 2 N^(-1/3) of the contacts, 0.13 at N = 4,000; slips of a spring below
    # 0.7 K* break most of them
    fraction = SLIP_FRACTION if slip_fraction is None else positive("slip_fraction", slip_fraction)
    if fraction > 1.0:
        refuse("slip_fraction", slip_fraction, "must be at most 1, a share of the contacts")
    return fraction


def unit_of(contacts: Contacts) -> float:
    """The length of which all positions and thresholds are whole multiples: 2^-28 mean thresholds, or more if the
    largest threshold would exceed 2^40 of them."""
    from eq_model.draws.births import tables_of

    largest = tables_of(contacts)["thresholds"].largest
    return max(2.0**-28 * contacts.mean_threshold, 2.0**-40 * largest)


def check_coupled(contacts: Contacts, drive: Drive) -> None:
    """Raise InputError for laws and paths that cannot be followed on a soft slider."""
    heavy = drive.mass is not None
    solver = "eq_model.simulate with a mass" if heavy else "eq_model.simulate with a spring"
    takes = ["delay", "reforming", "stiffness"]
    if isinstance(contacts, Contacts) and contacts.thermal is not None:
        if heavy:
            raise InputError(
                f"contacts.thermal: {solver} takes T = 0; take master.solve, which follows it in steps of time, "
                "or leave out the heat or the mass"
            )
        if contacts.thermal.closure == "paper":
            raise InputError(
                'contacts.thermal: closure = "paper" is an approximation of the master equation; use closure = "exact"'
            )
        takes.append("thermal")
    if isinstance(contacts, Contacts) and contacts.strengthening and not heavy:
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
    if back.size:
        at = int(back[0]) + 1
        why = "it tells slips by falls of the spring's force, which the way back makes, too"
        if not heavy:
            why = "contacts wait in the order in which the slider breaks them ahead"
        hint = f"lies behind path[{at - 1}]; {solver} takes a drive that does not turn: {why}"
        if not (heavy and contacts.stiffness == "linked"):
            hint += "; use master.solve, which takes turns"
        refuse(f"path[{at}]", drive.path[at], hint)
