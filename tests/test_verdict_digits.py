"""Digits, prefixes and counts on the page of `mesofriction verdict`."""

from dataclasses import replace

import numpy as np
import pytest

from tests.verdicts import slips, told
from toolkit.results.slips import Spread
from toolkit.scene.scale import Scale, prefixed_like
from toolkit.verdict import answers
from toolkit.verdict.sliders.records import Behaviour, Finite
from toolkit.verdict.slips_in_words import fall_of, fluctuating, period_with_scatter
from toolkit.verdict.text.words import page

IN_NEWTONS = Scale(1.0, "N", 1.0, "N/m", "m", "s", None, 517_733.0)


def on_area(*behaviours: Behaviour, finite: tuple[Finite, ...] = ()) -> answers.Verdict:
    """The verdict on these sliders in newtons, on an area of 517,733 contacts."""
    found = told(*behaviours)
    return replace(found, answers=(replace(found.own, scale=IN_NEWTONS),), finite=finite)


def test_contacts_of_an_area_are_told_in_three_digits() -> None:
    """517,733 of them are so many by one reading of the surface, and half as many by another."""
    few = Finite("reset", 517_733, "stick-slip", 0.6, 1e-3, 0.0, 1e-3, 5.0, period=70.0)
    text = "\n".join(page(on_area(slips("reset"), finite=(few,))))
    assert "518,000 contacts" in text and "517,733" not in text
    late = Finite("reset", 517_733, "unknown", message="takes too long")
    text = "\n".join(page(on_area(slips("reset"), finite=(late,))))
    assert "what 518,000 contacts do" in text and "517,733" not in text


def test_a_scatter_has_the_prefix_of_the_number_before_it() -> None:
    """4.82 ± 0.04 mm (scatter ± 140 µm) was told."""
    spread = Spread(mean=4.82e-3, std=1.4e-4, low=4.6e-3, high=5e-3, number=9)
    few = Finite(
        *("reset", 2282, "stick-slip", 0.241, 2e-3, 0.0, 0.0, 8.0),
        period=4.82e-3,
        period_error=4e-5,
        periods=spread,
        befores=Spread(mean=0.241, std=6.9e-3, low=0.23, high=0.25, number=9),
    )
    found = on_area(slips("reset"), finite=(few,))
    assert period_with_scatter(found, few)[0] == "4.82 ± 0.04 mm (scatter ± 0.14 mm)"
    assert fall_of(few, IN_NEWTONS) == "241 ± 2 mN (scatter ± 6.9 mN) down to 0 N"
    wide = replace(few, periods=replace(spread, std=3e-3, low=6e-4, high=9e-3, number=20))
    assert "(half of them 0.60 mm to 9.0 mm)" in period_with_scatter(found, wide)[0]
    slides = Finite("instant", 2282, "smooth", late=1.2e-3, late_error=1e-6, fluctuation=2.5e-5)
    assert fluctuating(slides, IN_NEWTONS) == ", fluctuating by ± 0.025 mN"


@pytest.mark.parametrize(
    "value, like, unit, said",
    [
        (1.4e-4, 4.82e-3, "m", "0.14 mm"),
        (1.4e-9, 4.82e-3, "m", "1.4 nm"),  # less than a thousandth of a millimetre
        (0.014, 0.787, "N_c<k>", "0.014 N_c<k>"),
        (np.nan, 1.0, "N", "not known"),
        (2.0, 0.0, "N", "2.0 N"),
    ],
)
def test_a_prefix_is_shared_where_the_number_can_be_read(
    value: float, like: float, unit: str, said: str
) -> None:
    assert prefixed_like(value, like, unit) == said


@pytest.mark.parametrize(
    "value, said",
    [
        (0.0, "K* is 0 N_c<k> to 0.44 N_c<k>"),
        (np.inf, "K* is 0.44 N_c<k> to infinite"),
        (0.45, "K* is nearly the same"),  # and no "factor of some 1"
    ],
)
def test_readings_that_slip_on_no_spring_or_on_all_have_no_factor(value: float, said: str) -> None:
    """K* differs by a factor of inf was told."""
    own = told(slips("reset")).own
    other = replace(own, name="b", critical_spring=answers.Quantity(value, 0.0))
    lines = "\n".join(page(replace(told(), answers=(own, other))))
    assert f"{said} over 2 readings" in lines and "factor of inf" not in lines


def test_how_often_a_smooth_slider_slips_does_not_hang_on_small_falls() -> None:
    """A slow machine does not follow the falls before the first slip, and does not follow the contacts of the area."""
    said = set[str]()
    for seen, smaller in ((1, 0), (5, 4)):
        smooth = slips("instant", kind="smooth", before=0.5, after=0.5, slips=seen, smaller=smaller)
        for kind, often in (("smooth", 5.0), ("unknown", 0.0)):
            few = Finite("instant", 517_733, kind, slips=often, late=0.5, late_error=1e-3)
            text = page(on_area(smooth, finite=(few,)))
            said |= {one for one in text if one.startswith("K is below K*, and yet")}
    assert len(said) == 1 and "slips once, and then no more" in said.pop()
    few = Finite("instant", 517_733, "stick-slip", 0.6, 1e-3, 0.4, 1e-3, 9.0, period=60.0)
    (line,) = [one for one in page(on_area(smooth, finite=(few,))) if "and yet sliding" in one]
    assert line.count("infinitely many contacts") == 1 and "the slider slips once" in line
