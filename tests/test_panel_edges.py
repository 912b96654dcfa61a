"""Where panels end and how wide they are: halving mends a fault there, so that forces hide it. These tests do not."""

from __future__ import annotations

import re

import numpy as np
import pytest

import master.renewal.edges as panel_edges
from master.motion import Motion
from master.numerics.table import Table
from master.renewal.births import Births, reforming_law
from master.renewal.edges import edges, passings
from master.renewal.panel_width import PanelWidth
from master.rigid import march_of
from master.solve import solve
from master.survival.life import ColdLife
from origins import Contacts, Delay, gaussian, rectangular

BOX = rectangular(0.5, 1.5)


def test_panels_end_where_contacts_meet_the_jumps_of_their_thresholds():
    """Breaks bend at 0.5 and 1.5, and where the contacts born one delay later meet these lengths."""
    contacts, delay = Contacts(BOX), 0.3
    motion = Motion(np.array([0.0, 4.0]), np.array([0.0, 4.0]))
    births = Births(ColdLife(contacts), reforming_law(contacts), motion, delay)
    times = edges(births, contacts.start, 1e-8).times
    first, second = [0.5, 1.5], [0.5 + delay + 0.5, 0.5 + delay + 1.5, 1.5 + delay + 1.5]
    for expected in (0.0, delay, *first, *second, 4.0):
        assert np.abs(times - expected).min() < 1e-12
    assert np.abs(times - 1.0).min() > 1e-3  # without the delay there would be one


def test_the_edges_of_the_example_at_the_head_of_the_file_are_these():
    """Each time, size and need as told there, none more and none less."""
    told = re.findall(r"t = (\S+) +size (\S+) .*?( \(needed\))?$", str(panel_edges.__doc__), re.M)
    contacts, delay = Contacts(rectangular(0.8, 1.2)), 0.15
    motion = Motion.along(np.array([0.0, 1.0, 0.0]))
    births = Births(ColdLife(contacts), reforming_law(contacts), motion, delay)
    found = edges(births, contacts.start, 1e-3)
    assert found.times[1:-1] == pytest.approx([float(time) for time, _, _ in told], abs=1e-12)
    assert [float(f"{kink.size:.0e}") for kink in found.kinks] == [
        float(size) for _, size, _ in told
    ]
    assert [kink.needed for kink in found.kinks] == [bool(needed) for _, _, needed in told]
    assert len(told) == 10 and found.times[[0, -1]].tolist() == [0.0, 2.0]


def test_the_example_of_passings():
    """The numbers of the docstring: a bend on the way there, and the way back to the largest |x|."""
    motion = Motion.along(np.array([0.0, 0.5, -1.0]))
    met = list(passings(motion, 0.0, 0.2, np.array([0.6])))
    assert [time for time, _ in met] == pytest.approx([0.4, 1.9])
    assert met[0][1] == 0.6 and np.isnan(met[1][1])


def tried(error_of, length=1.0, first=0.1, tolerance=1e-8):
    """Widths tried by the controller for panels with these errors; and ends of the panels that were kept."""
    widths, t, all_tried, kept = PanelWidth(True), 0.0, [], []
    widths.begin(0, length, first, 1.0, tolerance)
    while not widths.at_edge(length - t):
        proposal = widths.propose(length - t)
        width = proposal.width
        begins = t + width * np.arange(proposal.panels)
        errors = np.array([error_of(begin, width) for begin in begins])
        bad = np.flatnonzero(errors > tolerance)
        good = int(bad[0]) if bad.size else errors.size
        all_tried.append((t, width))
        kept += [(begin, width) for begin in begins[:good]]
        t += good * width
        if bad.size:
            widths.narrow(good, float(errors[good]))
        else:
            widths.widen(proposal, errors, 1.0, unresolved=False)
        assert len(all_tried) < 1000
    return all_tried, kept


def test_panels_get_as_wide_as_the_tolerance_allows():
    """Errors as (w/0.02)^16 of the tolerance: 50 panels are enough, and 200 too many."""
    _, kept = tried(lambda t, width: 1e-8 * (width / 0.02) ** 16)
    assert 50 <= len(kept) <= 200
    assert abs(sum(width for _, width in kept) - 1.0) < 1e-9


def test_two_bad_widths_tell_the_next_one_where_halving_is_slow():
    """Errors in proportion to the width of the first panel: by quarters it would take 11 tries from 0.1 to 5e-8."""
    all_tried, _ = tried(
        lambda t, width: 0.1 * width if t == 0.0 else 1e-8 * (width / (2.0 * t)) ** 16
    )
    assert sum(t == 0.0 for t, _ in all_tried) <= 8


def test_errors_of_panels_that_miss_a_peak_tell_no_width():
    """A peak of breaks narrower than the panel: errors as in a mixture of narrow laws, until it is met."""
    all_tried, _ = tried(
        lambda t, width: (
            0.5 * (10.0 * width) ** 1.2 if width > 0.02 else 1e-8 * (50.0 * width) ** 16
        )
    )
    assert min(width for _, width in all_tried) > 1e-3


def test_two_bad_widths_tell_the_next_one_where_errors_are_as_their_square():
    """The first two widths tell the third, 1e-4 in place of 0.1, up to a factor of 10."""
    all_tried, _ = tried(
        lambda t, width: width**2 if t == 0.0 else 1e-8 * (width / (2.0 * t)) ** 16
    )
    widths = [width for t, width in all_tried if t == 0.0]
    assert 1e-5 < widths[2] < 1e-4 and widths[1] > 1e-3


def test_panels_up_to_an_open_end_keep_their_width():
    """A plan that ends amid smooth breaks makes no panels of another width, whose sums over births are new ones."""
    widths, width, end = PanelWidth(True), 0.3, 0.0
    for plan in (1.0, 2.0):  # each from where the panels before end
        widths.begin(0, plan, width, 1.0, 1e-8, open_end=True)
        remaining = plan
        while not widths.at_edge(remaining):
            proposal = widths.propose(remaining)
            assert proposal.width == width
            widths.widen(proposal, np.full(proposal.panels, 1e-10), 1.0, unresolved=False)
            remaining -= proposal.panels * width
        assert 0.0 < remaining < width
        end += plan - remaining
    assert end == pytest.approx(9 * width)
    # a plan below one panel is met
    widths.begin(0, 0.1, width, 1.0, 1e-8, open_end=True)
    assert widths.propose(0.1).width == 0.1


def test_births_on_earlier_legs_are_cut_where_their_survival_bends():
    """Between the right cuts E of a rectangular law is a line in the time of birth, so that no piece is halved."""
    contacts = Contacts(BOX)
    motion = Motion.along(np.array([0.0, 1.2, -0.9, 1.4]))
    march = march_of(contacts, motion, ColdLife(contacts), 1e-8).run()
    assert march.births.work < 60_000  # 19,000; without the cuts two millions


def test_every_turn_is_an_edge_however_many_there_are():
    """Of other kinks the smallest are left out beyond some hundreds; a panel on two legs would have no survival."""
    contacts = Contacts(gaussian(1.0, 0.1))
    motion = Motion.along(np.append(0.0, np.tile([0.6, 0.0], 225)))
    births = Births(ColdLife(contacts), reforming_law(contacts), motion)
    found = edges(births, contacts.start, 1e-6).times
    assert np.isin(motion.times, found).all()


def test_an_edge_is_just_at_its_turn_where_another_kink_comes_a_rounding_before():
    """Contacts meet the jump of their thresholds at 0.5; a panel that ended there would lie on two legs."""
    contacts, turn = Contacts(BOX), 0.5 * (1.0 + 4e-13)
    motion = Motion.along(np.array([0.0, turn, -1.0]))
    births = Births(ColdLife(contacts), reforming_law(contacts), motion)
    found = edges(births, contacts.start, 1e-6).times
    assert np.isin(motion.times, found).all() and not np.isin(0.5, found)


def test_no_births_of_a_panel_lie_on_two_legs_however_many_there_are(monkeypatch):
    """With a delay a panel ends one delay before each turn, too: from 150 turns on these were left out as small."""
    contacts, path = Contacts(gaussian(1.0, 0.2), delay=Delay(0.137)), [0.0, 1.3, 0.1, 1.2, -0.2]
    asked = solve(contacts, path, 1e-6).force
    monkeypatch.setattr("master.renewal.edges.MOST_EDGES", 8)  # so that four legs are many
    few = solve(contacts, path, 1e-6)
    assert few.success and np.abs(few.force - asked).max() < 2e-6
    motion = Motion.along(np.array(path))
    births = Births(ColdLife(contacts), reforming_law(contacts), motion, 0.137)
    found = edges(births, contacts.start, 1e-6).times
    assert np.isin(motion.times[1:-1] - 0.137, found).all()


def test_a_panel_without_a_width_hides_none():
    """Edges that fall on one another, many of them, as of islands whose barriers are alike: the table gives its
    function between all of them."""
    apart = np.repeat(np.linspace(0.0, 1.0, 40), 3)
    table = Table(lambda x: np.cos(x)[None], apart, 1e-12, 1e-9)
    x = np.linspace(0.0, 1.0, 1001)[:-1]
    x = np.concatenate([x, table.begin])
    np.testing.assert_allclose(table(x)[0], np.cos(x), atol=1e-11)
    assert abs(table.up_to(np.array([0.7]))[0] - np.sin(0.7)) < 1e-11
