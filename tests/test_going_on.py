"""An ensemble cut short and gone on with, and one that stops by itself: the same bits as without."""

import dataclasses
from itertools import islice
from typing import Any

import numpy as np
import pytest

import eq_model
import origins
from eq_model import layout
from origins import Contacts, Delay

GAUSSIAN = origins.gaussian(1.0, 0.1)
PATH = np.linspace(0.0, 3.0, 7)
PLAIN, WAITING = Contacts(GAUSSIAN, origins.gaussian_start(0.0, 0.1)), Contacts(GAUSSIAN, delay=Delay(0.2))


def followed(ensemble: eq_model.Ensemble) -> eq_model.EnsembleResult:
    for _ in ensemble:
        pass
    return ensemble.result()


def same(one: eq_model.EnsembleResult, other: eq_model.EnsembleResult) -> None:
    for field in dataclasses.fields(one):
        if field.name not in ("run_time", "compile_time", "histograms", "breaks_per_rank"):
            assert np.array_equal(getattr(one, field.name), getattr(other, field.name)), field.name


@pytest.mark.parametrize("contacts", [PLAIN, WAITING], ids=["plain", "waiting"])
def test_gone_on_with_twice_it_is_the_uninterrupted_one(contacts: Contacts) -> None:
    asked: dict[str, Any] = {"n_contacts": 300_000, "seed": 4}
    whole = followed(eq_model.Ensemble(contacts, PATH, **asked))
    first = eq_model.Ensemble(contacts, PATH, **asked)
    assert len(list(islice(first, 2))) == 2
    part = first.result()
    assert 0 < part.contacts < 300_000 and not part.success and "stopped" in part.message
    second = eq_model.Ensemble(contacts, PATH, **asked, earlier=[first.state])
    ((done, total),) = islice(second, 1)
    # only what was missing is done again
    assert total == 300_000 - part.contacts and 0 < done < total
    last = eq_model.Ensemble(contacts, PATH, **asked, earlier=[second.state])
    same(followed(last), whole)


def test_blocks_that_take_long_become_smaller_and_quick_ones_larger_again() -> None:
    whole = followed(eq_model.Ensemble(WAITING, PATH, n_contacts=200_000))
    ensemble, now = eq_model.Ensemble(WAITING, PATH, n_contacts=200_000), 0.0

    def clock() -> float:
        """A machine that is slow at first, and then does as it should, and is fast in the end."""
        nonlocal now
        contacts = ensemble.state.contacts
        now += 0.6 if contacts < 100_000 else 0.2 if contacts < 150_000 else 0.0
        return now

    ensemble.clock = clock
    sizes = np.diff([0, *(done for done, _ in ensemble)])
    # none reaches across a multiple of 2^16
    assert sizes.tolist() == [1 << 16, 1 << 15, 1 << 14, *[1 << 13] * 6, 1 << 14, 1 << 14, 200_000 - 3 * (1 << 16)]
    same(ensemble.result(), whole)


def test_states_of_several_ranks_are_joined_and_gaps_filled() -> None:
    whole = followed(eq_model.Ensemble(PLAIN, PATH, n_contacts=200_000))
    ensemble = eq_model.Ensemble(PLAIN, PATH, n_contacts=200_000)
    states = []
    for block in (range(10, 5000), range(70_000, 100_001), range(5000, 5001)):
        nothing = dataclasses.replace(ensemble.state, sums=0 * ensemble.state.sums, done=[])
        states.append(nothing.after(block, *ensemble._engine.follow(block)))
    same(followed(eq_model.Ensemble(PLAIN, PATH, n_contacts=200_000, earlier=states)), whole)


def test_it_stops_where_the_tolerance_is_reached() -> None:
    run = eq_model.simulate(PLAIN, PATH, n_contacts=2_000_000, tolerance=1e-3)
    assert run.success and "within the tolerance" in run.message
    largest = run.force_standard_error.max() / PLAIN.mean_threshold
    assert 1e-3 / 2.0 < largest <= 1e-3 and run.contacts < 2_000_000
    # the contacts are the first ones of all
    first = eq_model.simulate(PLAIN, PATH, n_contacts=run.contacts)
    same(dataclasses.replace(run, message=""), dataclasses.replace(first, message=""))


def test_a_round_that_was_not_enough_is_not_judged_again() -> None:
    """Cut short in the round after it, whose finished blocks would make it enough."""
    asked: dict[str, Any] = {"n_contacts": 2_000_000, "tolerance": 1.15e-3}
    whole = followed(eq_model.Ensemble(PLAIN, PATH, **asked))
    assert whole.success
    for blocks in range(1, 7):
        first = eq_model.Ensemble(PLAIN, PATH, **asked)
        list(islice(first, blocks))
        assert first.expected >= whole.contacts
        same(followed(eq_model.Ensemble(PLAIN, PATH, **asked, earlier=[first.state])), whole)


def test_a_tolerance_out_of_reach_is_said() -> None:
    run = eq_model.simulate(PLAIN, PATH, n_contacts=50_000, tolerance=1e-4)
    assert not run.success and run.contacts == 50_000 and "above the tolerance" in run.message


def test_no_block_begins_after_the_wall_time() -> None:
    ensemble = eq_model.Ensemble(WAITING, PATH, n_contacts=10_000_000, wall_time=2.5)
    # two seconds and a half are over once the third block is done
    ensemble.clock = lambda: ensemble.state.contacts / (1 << 16)
    run = followed(ensemble)
    assert not run.success and run.contacts == 3 << 16
    # no block at all would be no result
    shortest: dict[str, Any] = {"n_contacts": 10_000_000, "wall_time": 1e-9}
    assert eq_model.simulate(WAITING, PATH, **shortest).contacts == 1 << 16
    alone = eq_model.simulate(WAITING, PATH, **shortest, tolerance=0.1)
    assert alone.success and alone.contacts < 1 << 16


def test_another_ensembles_state_is_refused() -> None:
    other = eq_model.Ensemble(PLAIN, [1.0, 2.0], n_contacts=10)
    with pytest.raises(origins.InputError, match="another path"):
        eq_model.Ensemble(PLAIN, PATH, n_contacts=10, earlier=[other.state])
    with pytest.raises(origins.InputError, match="no block"):
        other.result()


def test_rounds_double_and_cover_all() -> None:
    for total in (1, 16_384, 16_385, 1_000_003):
        rounds = layout.rounds(total, True)
        assert [i for part in rounds for i in (part.start, part.stop)][1:-1:2] == [part.start for part in rounds[1:]]
        assert rounds[0].start == 0 and rounds[-1].stop == total and len(rounds[0]) <= 16_384
        assert all(abs(len(later) - later.start) <= 1 for later in rounds[1:])
    assert layout.rounds(10**9, False) == [range(10**9)]


@pytest.mark.parametrize(
    "laws",
    [{"ageing": origins.Ageing(origins.gaussian(1.2, 0.05), rate=2e3)}, {"thermal": origins.Thermal("soft", 0.5, 1e7)}],
    ids=["ageing", "hot"],
)
def test_what_takes_long_begins_with_few_contacts(laws: dict[str, Any]) -> None:
    contacts = origins.Contacts(origins.gaussian(1.0, 0.05), **laws)
    ensemble = eq_model.Ensemble(contacts, 0.2, n_contacts=1000, wall_time=1e-9)
    # each of these takes a tenth of a second or so
    ((done, _),) = ensemble
    assert ensemble.result().contacts == done <= 4
