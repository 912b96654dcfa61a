"""An ensemble cut short and gone on with, and one that stops by itself: the same bits as without."""

import dataclasses
from itertools import islice
from typing import Any

import numpy as np
import pytest

import eq_model
import origins
from eq_model import layout
from eq_model.state import State
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


def test_states_of_several_ranks_are_joined_and_gaps_filled() -> None:
    asked: dict[str, Any] = {"n_contacts": 100_000, "n_replicas": 2}
    whole = followed(eq_model.Ensemble(PLAIN, PATH, **asked))
    first, second = (eq_model.Ensemble(PLAIN, PATH, **asked) for _ in range(2))
    list(islice(first, 2))
    # as another rank's share: all that follows the first five blocks
    second = eq_model.Ensemble(PLAIN, PATH, **asked, earlier=[some_of(PLAIN, asked, 5)])
    list(islice(second, 3))
    rest = dataclasses.replace(
        second.state,
        sums=second.state.sums - some_of(PLAIN, asked, 5).sums,
        done=[range(5, 8)],
        contacts=second.state.contacts - some_of(PLAIN, asked, 5).contacts,
        breaks=second.state.breaks - some_of(PLAIN, asked, 5).breaks,
    )
    same(followed(eq_model.Ensemble(PLAIN, PATH, **asked, earlier=[first.state, rest])), whole)


def some_of(contacts: Contacts, asked: dict[str, Any], blocks: int) -> State:
    """What the first blocks found."""
    ensemble = eq_model.Ensemble(contacts, PATH, **asked)
    assert len(list(islice(ensemble, blocks))) == blocks
    return ensemble.state


def test_it_stops_where_the_tolerance_is_reached() -> None:
    run = eq_model.simulate(PLAIN, PATH, n_contacts=2_000_000, tolerance=1e-3)
    assert run.success and "within the tolerance" in run.message
    largest = run.force_standard_error.max() / PLAIN.mean_threshold
    assert 1e-3 / 2.0 < largest <= 1e-3 and run.contacts < 2_000_000
    # the contacts are the first ones of all
    first = eq_model.Ensemble(PLAIN, PATH, n_contacts=2_000_000)
    for _ in first:
        if first.state.contacts == run.contacts:
            break
    same(dataclasses.replace(run, message="", success=False), dataclasses.replace(first.result(), message=""))


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


def test_no_block_begins_after_the_wall_time() -> None:
    ensemble = eq_model.Ensemble(WAITING, PATH, n_contacts=10_000_000, wall_time=2.5)
    # two seconds and a half are over once the third block is done
    ensemble.clock = lambda: float(len(ensemble.state.done) and ensemble.state.done[0].stop)
    run = followed(ensemble)
    assert not run.success and run.contacts == ensemble.blocks.before(3)
    # no block at all would be no result
    shortest: dict[str, Any] = {"n_contacts": 10_000_000, "wall_time": 1e-9}
    assert eq_model.simulate(WAITING, PATH, **shortest).contacts == ensemble.blocks.size(0)
    alone = eq_model.simulate(WAITING, PATH, **shortest, tolerance=0.1)
    assert alone.success and alone.contacts == ensemble.blocks.size(0)


def test_another_ensembles_state_is_refused() -> None:
    other = eq_model.Ensemble(PLAIN, [1.0, 2.0], n_contacts=10)
    with pytest.raises(origins.InputError, match="another path"):
        eq_model.Ensemble(PLAIN, PATH, n_contacts=10, earlier=[other.state])
    with pytest.raises(origins.InputError, match="no block"):
        other.result()


@pytest.mark.parametrize("total", [1, 16_384, 16_385, 300_001])
@pytest.mark.parametrize("replicas", [1, 3])
@pytest.mark.parametrize("seconds", [0.0, 1e-4, 1.0])
def test_blocks_cover_all_contacts_of_each_replica(total: int, replicas: int, seconds: float) -> None:
    blocks = layout.make_blocks(total, replicas, seconds)
    sizes = [blocks.size(block) for block in range(min(blocks.total, 5000))]
    assert max(sizes) - min(sizes) <= 1 and max(sizes) <= layout.BLOCK and min(sizes) >= 1
    assert [blocks.before(block) for block in range(len(sizes))] == np.cumsum([0, *sizes])[:-1].tolist()
    assert blocks.before(blocks.total) == total * replicas == blocks.contacts([range(blocks.total)])
    assert blocks.before(blocks.each) == total
    for ranks in (1, 2, 7):
        shares = [layout.share([range(blocks.total)], rank, ranks) for rank in range(ranks)]
        assert sum(blocks.contacts(part) for part in shares) == total * replicas


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
