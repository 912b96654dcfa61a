"""Replicas of coupled contacts on a slider with mass: following one, and the result of all."""

from typing import Any, NamedTuple

import numpy as np

from eq_model.blocks import Blocks, State, check_dropped
from eq_model.coupled.ensemble import (
    LARGEST,
    CoupledSliders,
    few_contacts,
    refuse_beyond,
)
from eq_model.coupled.mass.chance import fall_by_chance
from eq_model.coupled.work import growth, often_by_heat, slower_by_own_law, static_force
from eq_model.result import SIZES, Energy, HeavySlips, means
from origins import Drive
from origins.drive import RISE, ROOM, SLIP_FRACTION
from origins.errors import InputError, refuse
from origins.thresholds.law import Array

MOST_BREAKS = 10**11  # of a replica: some two hours, also of fewer that are SLOWER
SLOWER = 15  # time of a break of contacts that grow beside one of others
LONGEST = 1e13  # oscillations between two points of the path, after which a double has three digits of their phase
CURVES = "position", "force", "holding", "velocity", "contact_force"
ENERGIES = "drive", "damped", "released", "contacts", "spring", "kinetic"


class Pulled(NamedTuple):
    """A slider, an array of one `state.SLIDER`; its contacts, none of which holds yet; and what pulls it."""

    slider: Any
    contacts: Any
    pull: Any


class DriveLegs(NamedTuple):
    """Legs of the drive: X_T where each begins (lengths), the drive's speed on it, and the time that it takes."""

    places: Array
    speeds: Array
    lasts: Array


class HeavySliders(CoupledSliders):
    """Follows replicas on a slider with mass, of which a slip breaks a share of the contacts that held."""

    def _prepare(self) -> None:
        """Choose how many breaks are followed at most; InputError for paths that are too long."""
        from eq_model.coupled import heat

        by_heat = heat.SLOWER if self._contacts.thermal else 1
        by_age = SLOWER if self._contacts.growing else 1
        slower = max(by_age, by_heat) * slower_by_own_law(self._contacts)
        self._most_breaks = MOST_BREAKS // int(slower)
        self._check_length()

    def _check_length(self) -> None:
        """InputError for paths that are too long to be followed."""
        contacts, drive, end = self._contacts, self._drive, self._drive.path[-1]
        spring, mean = drive.spring or 0.0, contacts.mean_threshold
        most = 0.5 * LARGEST * self._unit
        force = mean * growth(contacts, drive) + abs(contacts.start.mean())
        if force > spring * most:
            hint = f"must be above {force / most:.3g}; slips are longer than positions have digits"
            refuse("spring", spring, hint)
        # a slider may swing beyond the drive by as much as it was behind, which is no more than the drive's way
        behind = min(max(force / spring, self._most_behind()), abs(end))
        refuse_beyond(drive, LARGEST * self._unit - behind, self._unit)
        # a contact breaks once a mean threshold where it does not wait
        breaks = self._n * max(end - self._most_behind(), 0.0) / mean / growth(contacts, drive)
        breaks *= contacts.delay is None
        breaks += self._n * often_by_heat(contacts, drive)
        if breaks > self._most_breaks:
            less = "a lower temperature" if contacts.thermal is not None else "a delay"
            refuse(
                "path[-1]",
                end,
                f"takes {breaks:.1e} breaks of {self._n} contacts, and at most {self._most_breaks:.0e} are followed; "
                f"shorten the path, or give fewer contacts or {less}",
            )
        lasts = self._legs(contacts.start.mean() / spring).lasts
        most = float(lasts.max()) * np.sqrt((spring + 1.0) / (drive.mass or 1.0)) / (2.0 * np.pi)
        if most > LONGEST:
            refuse(
                "mass",
                drive.mass,
                f"oscillates {most:.1e} times between two points of the path, and at most {LONGEST:.0e} times are "
                "followed; give a larger mass, or points that are closer",
            )

    def _most_behind(self) -> float:
        """About how far the slider is behind the drive at most (a length): by the contacts' static force, by the force
        of its damping, which swings up to twice what it is, and by its inertia as the drive starts."""
        contacts, drive = self._contacts, self._drive
        spring, mean = drive.spring or 0.0, contacts.mean_threshold
        force = mean  # no contact bears more on the average
        if contacts.stiffness == "independent" and not contacts.growing:
            force = min(mean, static_force(contacts.thresholds) + abs(contacts.start.mean()))
        speed = float(np.abs(self._legs(contacts.start.mean() / spring).speeds).max())
        swung = speed * ((drive.mass or 0.0) / spring) ** 0.5
        return (force * growth(contacts, drive) + 2.0 * drive.damping * speed) / spring + swung

    def _legs(self, balance: float) -> DriveLegs:
        """The legs of the drive, from the balance at t = 0 on."""
        drive = self._drive
        places = np.r_[balance, drive.path]
        displacements = np.diff(places)
        lasts = np.abs(displacements) / drive.velocity
        if drive.time is not None:
            lasts = np.diff(drive.time, prepend=0.0)
        if (displacements[0] != 0.0) and not lasts[0] > 0.0:
            hint = f"leaves no time to get there from X_T = {balance:g}, where the drive balances the start"
            refuse("path[0]", drive.path[0], hint)
        speeds = np.divide(
            displacements, lasts, out=np.zeros_like(displacements), where=lasts > 0.0
        )
        return DriveLegs(places[:-1], speeds, lasts)

    def fields(self, state: State) -> dict[str, Any]:
        """Fields of the result."""
        tables = state.rows, state.slips.reshape(-1, 10)
        rows, slips = (table[np.argsort(table[:, 0], kind="stable")] for table in tables)
        # a row: its replica's number, X_T = F(0)/K, what is stored there; falls of the force by class; the curves and
        # energies at the points
        numbers, falls, curves = np.split(rows, [3, 3 + SIZES], axis=1)
        curves = curves.reshape(len(rows), len(CURVES) + len(ENERGIES), -1)
        energies = dict(zip(ENERGIES, np.moveaxis(curves[:, len(CURVES) :], 1, 0), strict=True))
        fields: dict[str, Any] = {"positions": curves[:, 0], "forces": curves[:, 1]}
        fields |= {"velocities": curves[:, 3], "contact_forces": curves[:, 4]}
        for k, name in enumerate(CURVES):
            fields[name], fields[f"{name}_standard_error"] = means(curves[:, k])
        columns: list[Any] = list(slips.T)
        for whole in (0, 1, 7):
            columns[whole] = columns[whole].astype(np.int64)
        return fields | {
            "slips": HeavySlips(*columns),
            "avalanches": falls.astype(np.int64),
            "balance": float(numbers[:, 1].mean()),
            "step_error": np.zeros(curves.shape[-1]),
            "slip_fraction": self.slip_fraction,
            "energy": Energy(start=numbers[:, 2], **energies),
        }

    def follow(self, replica: int) -> State:
        """Follow a replica to the end of the path; -1 only compiles.

        Raises InputError where it takes too many breaks, and DroppedError.
        """
        from eq_model.coupled.mass import kernel, state
        from eq_model.draws.streams import make_stream
        from eq_model.draws.supply import make_supply

        if replica < 0:
            few, mean = few_contacts(self._contacts), self._contacts.mean_threshold
            # so fast that contacts in heat break a few times at most
            rate = 1.0 if few.thermal is None else few.thermal.rates.scale
            drive = Drive([3.0 * mean], mean * rate, spring=1.0, mass=rate**-2)
            HeavySliders(few, drive, Blocks(2, 2), seed=0, slip_fraction=1.0).follow(0)
            return self.nothing
        check_dropped(self._dropped)
        n, unit, stream = self._n, self._unit, make_stream(self._seed, replica)
        first, later = (make_supply(births, stream) for births in self._births)
        spring = self._drive.spring or 0.0
        slider, contacts, pull = self._pulled(stream)
        kernel.form_all(slider, contacts, first, pull)
        s, slips = slider[0], list[Array]()
        balance = s["force"] / n / spring * unit
        pull.places[:], pull.speeds[:], pull.lasts[:] = self._legs(balance)
        pull.places[:] /= unit
        pull.begins[1:] = np.cumsum(pull.lasts[:-1])
        pull.chance[:] = fall_by_chance(self._contacts, n, pull.speeds) / unit
        pull.chance[:] *= growth(self._contacts, self._drive)  # by which forces grow at most
        pull.least_breaks[:] = n * self._least_share(pull.speeds)
        pull.speeds[:] /= unit
        pull.energy[:] = 0.0
        pull.energy[state.STORED, 0] = at_start = self._stored(s, contacts)
        while (reason := kernel.slide(slider, contacts, later, pull)) != kernel.PATH_DONE:
            if reason == kernel.SLIP_ENDED:
                slips.append(np.r_[replica, len(slips), pull.slipped])
            elif reason == kernel.TOO_MANY:
                drive = pull.places[s["leg"]] * unit
                raise InputError(
                    f"path[-1] = {self._drive.path[-1]:g}: takes more than {self._most_breaks:.0e} breaks of {n} "
                    f"contacts, so many by X_T = {drive:g}; shorten the path, or give fewer contacts or a longer delay"
                )
            check_dropped(self._dropped)
        curves = pull.at_points * self._scales()
        curves[state.ENERGIES + state.STORED, -1] = self._stored(s, contacts) / n * unit * unit
        force, speed = curves[state.FORCE], curves[state.SPEED]
        moving = 0.5 * np.stack([force**2 / spring, (self._drive.mass or 0.0) * speed**2])
        at_start = 0.5 * spring * balance**2 + at_start / n * unit * unit
        row = np.r_[replica, balance, at_start, pull.falls, curves.ravel(), moving.ravel()]
        scales = [1.0, 1.0, unit, unit, unit, unit, unit, 1.0, 1.0, unit]
        table = np.reshape(slips, (-1, 10)) * scales
        return State(rows=row[None], slips=table, breaks=int(s["breaks"]))

    def _least_share(self, speeds: Array) -> Array:
        """The least share of all contacts that breaks in a slip, at these speeds of the drive: SLIP_FRACTION of the
        share that holds in steady sliding, while the others wait; and no less than RISE, as the breaks of fewer cannot
        lower the force by RISE, a mean threshold each."""
        mean = self._contacts.mean_threshold
        holding = mean / (mean + np.abs(speeds) * self._contacts.waiting_time)
        return np.maximum(RISE, min(self.slip_fraction, SLIP_FRACTION) * holding)

    def _pulled(self, stream: Any) -> Pulled:
        """At X = 0, where the slider rests, and without legs."""
        from eq_model.coupled.ages import ages_of
        from eq_model.coupled.heat import heat_of
        from eq_model.coupled.mass import state
        from eq_model.coupled.mass.nearest import make_nearest

        n, drive, contacts = self._n, self._drive, self._contacts
        slider = np.zeros(1, state.SLIDER)
        slider[0]["due"] = np.inf
        delay, points = contacts.delay, drive.path.size
        waits = 1 if delay is None else n + 1
        width = contacts.mean_threshold / self._unit / 16.0
        own = state.BreakPlaces(
            make_nearest(n, width),
            make_nearest(n, width),
            np.empty(waits, np.int32),
            np.empty(waits),
            ages_of(contacts, n, heat_of(contacts, drive, n, self._unit, stream)),
        )
        law = contacts.growing
        mean = contacts.mean_threshold / self._unit if contacts.stiffness == "linked" else 0.0
        pull = state.PullWithMass(
            n=n,
            spring=drive.spring or 0.0,
            per_mass=1.0 / (drive.mass or 1.0),
            damping=drive.damping,
            rate=drive.damping / (drive.mass or 1.0),
            mean=mean,
            wait=-1.0 if delay is None else delay.time,
            slip_fraction=self.slip_fraction,
            least_breaks=np.empty(points),
            room=ROOM * contacts.mean_threshold / self._unit,
            rise=RISE * contacts.mean_threshold / self._unit,
            chance=np.empty(points),
            most_breaks=self._most_breaks,
            places=np.empty(points),
            speeds=np.empty(points),
            lasts=np.empty(points),
            begins=np.zeros(points),
            age=0.0 if law is None else float(law.start_pinned_for),
            at_points=np.empty((state.ENERGIES + 4, points)),
            swing=np.zeros(8),
            slipped=np.zeros(8),
            falls=np.zeros(SIZES, np.int64),
            energy=np.zeros((4, 2)),
        )
        return Pulled(slider, own, pull)

    def _scales(self) -> Array:
        """The user's units of the rows of PullWithMass.at_points, shape (rows, 1)."""
        each, square = 1.0 / self._n, self._unit * self._unit
        curves = self._unit, self._unit, each, self._unit, self._unit
        return np.array([*curves, square, square, each * square, each * square])[:, None]

    def _stored(self, s: np.void, contacts: Any) -> float:
        """Energy of the contacts that hold, anew: a sum over them, with k_i in <k>, in whole units squared."""
        from eq_model.coupled.mass.nearest import FAR

        n, total = self._n, 0.0
        for begin in range(0, n, 1 << 16):  # in parts, which take little memory
            part = slice(begin, begin + (1 << 16))
            ahead, behind = contacts.ahead.places[part], contacts.behind.places[part]
            holds = ahead != FAR
            ahead, behind = ahead[holds], behind[holds]
            stretch = 0.5 * (2 * s["at"] + (behind - ahead)) + s["off"]
            threshold = 0.5 * (ahead + behind)
            if contacts.ages.numbered:  # whose places may lie before their thresholds
                threshold = contacts.ages.fresh[part][holds]
            k = self._contacts.relative_stiffness(threshold * self._unit)
            total += float(k @ stretch**2)
        return 0.5 * total
