"""Replicas of coupled contacts, N of them on one soft slider each: what one does, and what all of them tell."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from eq_model.coupled.result import SIZES, Followed, fields_of, read_rows
from eq_model.layout import Blocks
from eq_model.state import Found, State
from origins import Contacts, Drive, identical
from origins.contacts import check_contacts
from origins.errors import InputError, positive, refuse

if TYPE_CHECKING:
    from eq_model.coupled.slide_kernel import Pull

# Share of the contacts that an avalanche breaks at least to be a slip. Before a slip avalanches
# break up to 2 N^(-1/3) of the contacts, 0.13 at N = 4,000; slips of a spring below 0.7 K* break
# most of them.
SLIP_FRACTION = 0.2

_MOST_BUCKETS = 1 << 25  # which take 270 MB
_NEVER = -(1 << 62)
_OF_A_SLIP = ("pulled", "before", "after", "force_before", "force_after", "size")
_NO_SUMS, _NO_COUNTS = np.zeros((2, 0), np.int64), np.zeros((0, 2, 0), np.uint32)


class Replicas:
    """Follows replicas of `n` contacts on the slider that `drive` pulls; a slip breaks at least `slip_fraction` of
    them (None: 0.2)."""

    MOST = 1 << 31  # contacts of a replica
    seconds = 0.0

    def __init__(
        self, contacts: Contacts, drive: Drive, n: int, seed: int, slip_fraction: float | None
    ) -> None:
        from eq_model.coupled.draws import Draws
        from eq_model.coupled.queue_kernel import bucket_bits
        from eq_model.coupled.slide_kernel import Pull

        check_coupled(contacts, drive)
        self.slip_fraction = positive(
            "slip_fraction", SLIP_FRACTION if slip_fraction is None else slip_fraction
        )
        if self.slip_fraction > 1.0:
            refuse("slip_fraction", slip_fraction, "must be at most 1, a share of the contacts")
        assert drive.spring is not None
        self._draws, self._drive, self._n = Draws(contacts, seed), drive, n
        self._unit, self._spring = self._draws.unit, drive.spring
        law, mean = contacts.thresholds, contacts.mean_threshold
        self._shift = bucket_bits(n, mean / self._unit, lambda width: float(law.cdf(width * mean)))
        # contacts that pull forward take the slider beyond the drive, no further than they are stretched
        way = drive.path[-1] + self._draws.furthest
        self._buckets = (int(max(way, 0.0) / self._unit) >> self._shift) + 2
        if self._buckets > _MOST_BUCKETS:
            most = _MOST_BUCKETS * self._unit * 2.0**self._shift
            refuse("path[-1]", drive.path[-1], f"must be below {most:.3g} for {n} coupled contacts")
        delay, nothing = contacts.delay, np.empty(0)
        self._pull = Pull(
            spring=drive.spring * n,
            path=nothing,
            time=nothing,
            clock=nothing,
            clock_drive=nothing,
            wait=contacts.waiting_time,
            mean=mean / self._unit,
            slip=max(int(np.ceil(self.slip_fraction * n)), 1),
            at_once=drive.slip == "instant" and delay is None,
            resets=drive.slip == "reset",
            linked=contacts.stiffness == "linked",
            delayed=delay is not None,
        )

    def nothing(self) -> tuple[Any, Any, Any]:
        """What no replica found."""
        return _NO_SUMS, _NO_COUNTS, np.empty(0)

    def follow(self, blocks: Blocks, replica: int) -> Found:
        """What a replica does; -1 compiles."""
        if replica < 0:
            # kernels are the same for all laws and rules
            Replicas(Contacts(identical(1.0)), Drive([3.0], spring=1.0), 2, 0, 1.0).pull(0)
            return Found(*self.nothing(), 0, 0)
        found = self.pull(replica)
        return Found(_NO_SUMS, _NO_COUNTS, found.row(replica), found.breaks, 0)

    def told(self, blocks: Blocks, state: State) -> dict[str, Any]:
        """Fields of the result."""
        replicas = read_rows(state.rows, self._drive.path.size)
        return {**fields_of(replicas), "slip_fraction": self.slip_fraction}

    def histograms(self, n: int, counts: Any) -> tuple[()]:
        """None."""
        return ()

    def pull(self, replica: int) -> Followed:
        """The replica's slider, pulled to the end of the path.

        Raises InputError where contacts would break while the drive moves back to its first point.
        """
        from eq_model.coupled import slide_kernel as kernel
        from eq_model.coupled.queue_kernel import clear, make_queue

        n, size = self._n, self._drive.path.size
        (first, later), queue = (
            self._draws.of_replica(replica),
            make_queue(n, self._shift, self._buckets),
        )
        slider = np.zeros(1, kernel.SLIDER)
        s, slips = slider[0], list[list[float]]()
        s["back"] = _NEVER
        kernel.form_all(slider, queue, first, self._pull, n)
        balance = float(s["force"]) / self._pull.spring
        pull = self._driven(s, balance)
        held, sizes = np.zeros(size, np.int64), np.zeros(SIZES, np.int64)
        told, most = kernel.Told(np.zeros(size), np.zeros(size), held, sizes), n * pull.delayed + 1
        returns = kernel.Returns(np.empty(most), np.empty(most, np.int64))
        while (why := kernel.slide(slider, queue, later, pull, told, returns)) != kernel.PATH_DONE:
            if why == kernel.BUCKETS_PASSED:
                continue  # to let an interrupt be heard
            if why == kernel.OVERTAKEN:
                raise InputError(
                    "reforming: contacts that form again stretched forward take the slider far beyond the drive; use a "
                    "stiffer spring, or stretches closer to 0"
                )
            if why == kernel.RESET_DUE:  # no contact holds, no return is due, and X = X_T
                drive = s["pulled"] / pull.spring
                s["size"], s["after"], s["force_after"] = s["broken"], drive, 0.0
                s["at"], s["returning"] = np.rint(drive), s["returns"]
                for name in ("force", "stiffness", "held", "out", "broken"):
                    s[name] = 0
                clear(queue, int(s["at"]))
                kernel.form_all(slider, queue, later, pull, n)
            slips.append([float(s[name]) for name in _OF_A_SLIP])
        unit, each = self._unit, self._unit / n
        scales = [each / self._spring, unit, unit, each, each, 1.0]
        return Followed(
            position=told.position * unit,
            force=told.force * each,
            holding=told.held / n,
            slips=np.reshape(slips, (-1, len(scales))) * scales,
            avalanches=told.avalanches,
            breaks=int(s["breaks"]),
            balance=balance * unit,
        )

    def _driven(self, s: np.void, balance: float) -> Pull:
        """The pull of a drive that comes to its path from X_T = balance (units)."""
        drive, unit, spring = self._drive, self._unit, self._pull.spring
        path, both = drive.path / unit, spring + s["stiffness"]
        if spring * path[0] - s["force"] <= both * s["back"]:
            first = (s["force"] + both * s["back"]) / spring * unit
            raise InputError(
                f"path[0] = {drive.path[0]:g}: contacts break backwards while the drive moves there"
                f" from X_T = {balance * unit:g}, where it balances the start; begin the path above"
                f" {first:g}"
            )
        way = np.abs(np.diff(path, prepend=balance))
        time = np.cumsum(way) * unit / drive.velocity if drive.time is None else drive.time
        # at the end the drive rests
        clock, places = np.r_[0.0, time, time[-1] + 1.0], np.r_[balance, path, path[-1]]
        moves = np.append(True, np.diff(clock) > 0.0)
        return self._pull._replace(
            path=spring * path, time=time, clock=clock[moves], clock_drive=places[moves]
        )


def check_coupled(contacts: Contacts, drive: Drive) -> None:
    """Raise InputError for what is not followed on a soft slider: laws, and ways that turn."""
    solver = "eq_model.simulate with a spring"
    if isinstance(contacts, Contacts) and contacts.thermal is not None:
        raise InputError(
            f"contacts.thermal: {solver} takes T = 0: the slider's speed hangs on all contacts at "
            "once, so that none can draw its break beforehand; use master.solve, or leave it out"
        )
    check_contacts(contacts, solver, ("delay", "reforming", "stiffness"))
    at_once = drive.slip == "instant" and contacts.delay is None
    if contacts.reforming is not None and not at_once:
        raise InputError(
            "contacts.reforming: contacts that form again stretched after an avalanche would pull "
            f'the slider once more; {solver} takes them with slip = "instant" and no delay'
        )
    back = np.flatnonzero(np.diff(drive.path) < 0.0)
    if back.size:
        at = int(back[0]) + 1
        refuse(
            f"path[{at}]",
            drive.path[at],
            f"lies behind path[{at - 1}]; {solver} takes a drive that does not turn",
        )
