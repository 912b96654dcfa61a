"""Soft sliders whose drive turns often: the error does not grow from turn to turn where contacts forget."""

import re
from itertools import pairwise

import numpy as np
import pytest
from conftest import slow

import master
import origins
from master.soft.cold_contacts import ColdContacts
from master.soft.moves import LoadingHistory, Move
from master.soft.turns import LegEnd, loss_of_breaks, remedy_of, unsteadiness

TURNS = 14
# of a drive whose legs are 0.6 to 3.4 loadings long, in these
FAR_TURNS = np.array([0.0, 2.3, -1.1, 1.7, -0.6, 0.9])


def back_and_forth(spring: float, seed: int) -> np.ndarray:
    """A drive that turns so often, five points a leg, each leg of random length, two to five periods of stick-slip."""
    far = np.random.default_rng(seed).uniform(1.0, 2.5, TURNS) * (1.0 + spring) / spring
    turns = far * (-1.0) ** np.arange(TURNS)
    legs = zip(np.append(0.0, turns[:-1]), turns, strict=True)
    return np.concatenate([np.linspace(begin, end, 6)[1:] for begin, end in legs])


@pytest.mark.parametrize("std, spring, seed", [slow(0.35, 0.02, 1), (0.2, 0.3, 3)])
def test_instant_slips_have_the_force_of_a_rigid_slider_at_the_same_places(
    std: float, spring: float, seed: int
) -> None:
    """The error told is within the tolerance: carried from turn to turn by 1/K it was up to 1e30 mean thresholds."""
    contacts = origins.Contacts(origins.gaussian(1.0, std))
    soft = master.solve(contacts, back_and_forth(spring, seed), 1e-6, spring=spring, slip="instant")
    assert soft.success and soft.force_error <= 1e-6
    rigid = master.solve(contacts, soft.position, 1e-10)
    off = np.abs(soft.force - rigid.force).max() / contacts.mean_threshold
    # where X is off by force_error/K, F(X) is by at most as much, as F' is at most 1
    assert off <= soft.force_error * (1.0 + 1.0 / spring) + rigid.force_error


@pytest.mark.parametrize("slip", ["reset", slow("reform-after")])
@pytest.mark.parametrize("std, spring, seed", [(0.3, 0.03, 4)])
def test_slips_between_turns_keep_the_error(
    slip: str, std: float, spring: float, seed: int
) -> None:
    """A finer solution, whose own error is another, stays within what both tell."""
    contacts = origins.Contacts(origins.gaussian(1.0, std))
    path = back_and_forth(spring, seed)
    rough, fine = (
        master.solve(contacts, path, tolerance, spring=spring, slip=slip)
        for tolerance in (1e-5, 1e-9)
    )
    assert rough.success and rough.slips.drive.size == fine.slips.drive.size > TURNS
    off = np.abs(rough.slips.drive - fine.slips.drive).max()
    assert off <= rough.slips.drive_error + fine.slips.drive_error
    assert rough.slips.drive_error <= 1e-5 / spring


@pytest.mark.parametrize(
    ("y", "stiffness"),
    [(0.5, "linked"), (1.1, "independent"), (2.6, "linked"), (12.0, "independent")],
)
def test_the_place_of_a_turn_changes_the_force_by_no_more_than_is_told(
    y: float, stiffness: str
) -> None:
    """Beside rigid sliders that turn at y and a little behind: the force over the way back, from the turn or at X."""
    contacts = origins.Contacts(origins.gaussian(1.0, 0.3), stiffness=stiffness)
    move = Move(ColdContacts(contacts, 1.0, 1e-8, np.inf), 1, LoadingHistory(contacts.start))
    curve = move.curve_to(y)
    way, back = 1e-4, np.linspace(0.02, 6.0, 60)

    def per_way(places: list[np.ndarray]) -> float:
        at, behind = (
            master.solve(contacts, np.append(x, path), 1e-11).force
            for x, path in zip((y, y + way), places, strict=True)
        )
        return float(np.abs(behind - at)[1:].max() / way)

    carried, told = per_way([y - back, y + way - back]), unsteadiness(move, y)
    # the largest stretch stands for that of each contact; where breaks are steady nothing is left
    assert carried <= told <= 40.0 * carried + 1e-5
    assert told < 1e-3 or y < 12.0
    stays, told = per_way([y - back, y - back]), loss_of_breaks(move, curve, y)
    # the way itself is not short beside the change of F'
    assert stays <= 1.05 * told
    assert told <= 5.0 * stays


@pytest.mark.slow
def test_an_error_that_grows_at_turns_names_the_turn_at_which_to_end() -> None:
    """The path to the turn that is named has the error that is told, and is solved."""
    contacts, ends = origins.Contacts(origins.gaussian(1.0, 0.3)), 25.0 * FAR_TURNS / 3.0
    path = np.concatenate([np.linspace(*leg, 9)[1:] for leg in pairwise(ends.tolist())])
    found = master.solve(contacts, path, 1e-8, spring=0.3, slip="reform-after")
    told = r"end the path at the turn at X_T = (\S+), up to which it is (\S+), or loosen the tol"
    said = re.search(told, found.message)
    assert said is not None and not found.success, found.message
    place, error = map(float, said.groups())
    leg = int(np.argmin(np.abs(ends - place)))
    assert 0 < leg < ends.size - 1 and ends[leg] == pytest.approx(place, rel=1e-5)
    shorter = master.solve(contacts, path[: 8 * leg], 1e-8, spring=0.3, slip="reform-after")
    assert shorter.success and shorter.force_error == pytest.approx(error, rel=0.5)
    longer = master.solve(contacts, path[: 8 * leg + 8], 1e-8, spring=0.3, slip="reform-after")
    assert longer.force_error > 1e-8


@pytest.mark.parametrize(
    "errors, heat, told",
    [
        ([1e-9, 2e-8, 3e-8], 0.0, "at X_T = 1, up to which it is 1.0e-09, or loosen the tolerance"),
        ([2e-8, 3e-8], 0.0, "shorten the path or loosen the tolerance"),
        # forces are known up to there, although no better than asked
        ([2e-8, 3e-4, 0.5], 0.0, "at X_T = 2, up to which it is 3.0e-04, or loosen the tolerance"),
        ([1e-2, 0.5], 1e-3, "at X_T = 1, up to which it is 1.0e-02, or leave out the heat"),
        ([0.5], 1e-3, "end the path sooner, or leave out the heat"),
    ],
)
def test_what_makes_the_error_of_turns_and_heat_smaller(
    errors: list[float], heat: float, told: str
) -> None:
    legs = [LegEnd(float(end), error) for end, error in enumerate(errors, start=1)]
    assert remedy_of(legs, heat, 1e-8).removeprefix("end the path at the turn ") == told
