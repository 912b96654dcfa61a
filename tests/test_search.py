"""A search for wrong answers beyond the table of extreme cases; what it finds is kept there."""

import os
from typing import Any, get_args

import numpy as np
import pytest
from scipy import stats

import origins
from origins.contacts import Contacts
from origins.drive import SlipRule
from toolkit.stability.case import Case
from toolkit.stability.table import answered

hypothesis = pytest.importorskip("hypothesis")
st = pytest.importorskip("hypothesis.strategies")
RULES = get_args(SlipRule)


def decades(low: float, high: float) -> Any:
    """Numbers of any size between two powers of ten."""
    return st.floats(low, high).map(lambda power: float(f"{10.0**power:.3g}"))


@st.composite
def any_thresholds(draw: Any) -> Any:
    """Laws from all but exact to heavy-tailed, with a mean of about 1."""
    kind = draw(st.sampled_from(["gaussian", "lognormal", "gamma", "two peaks", "box"]))
    width = draw(decades(-6.0, 0.3))
    if kind == "gaussian":
        return origins.gaussian(1.0, min(width, 0.3))
    if kind == "lognormal":
        return stats.lognorm(width, scale=float(np.exp(-0.5 * width**2)))
    if kind == "gamma":
        shape = max(width**-2.0, 0.3)
        return stats.gamma(min(shape, 1e6), scale=1.0 / min(shape, 1e6))
    if kind == "box":
        return origins.rectangular(1.0 - min(width, 0.9), 1.0 + min(width, 0.9))
    apart, weight = draw(decades(-6.0, -0.1)), draw(decades(-6.0, -0.3))
    peaks = [origins.gaussian(at, min(width, 0.1) * at) for at in (1.0 - apart, 1.0 + apart)]
    return origins.mixture(peaks, [weight, 1.0 - weight])


@st.composite
def any_case(draw: Any) -> Case:
    """Contacts with at most one law, of extreme strength, on a path that may turn, rigid, on a spring, with a mass."""
    law, start = draw(any_thresholds()), draw(st.one_of(st.none(), st.floats(-0.5, 1.0)))
    number, strength = draw(st.integers(0, 6)), draw(decades(-6.0, 2.0))
    laws: dict[str, Any] = {"start": start}
    if number == 1:
        laws["delay"] = origins.Delay(strength)
    elif number == 2:
        laws["thermal"] = origins.Thermal("soft", strength, draw(decades(-3.0, 6.0)))
    elif number == 3:
        laws["thermal"] = origins.Thermal("stiff", strength, draw(decades(-3.0, 6.0)))
    elif number == 4:
        laws["stiffness"] = "linked"
    elif number == 5:
        law = origins.strengthening(law, min(strength, 1.0), draw(decades(-6.0, 3.0)))
    lengths = np.array(draw(st.lists(decades(-2.0, 0.8), min_size=1, max_size=3)))
    corners = np.append(0.0, np.cumsum(lengths * (-1.0) ** np.arange(lengths.size)))
    path = np.interp(np.linspace(0.0, lengths.size, 24), np.arange(corners.size), corners)
    drive: dict[str, Any] = {}
    if lengths.size == 1 and number in (0, 1, 4, 5) and draw(st.booleans()):
        drive = {"spring": draw(decades(-6.0, 6.0)), "slip": draw(st.sampled_from(RULES))}
        if draw(st.booleans()) and number != 4:
            del drive["slip"]
            drive |= {"mass": draw(decades(-6.0, 6.0)), "damping": draw(decades(-6.0, 3.0))}
        path = path * (1.0 + 1.0 / drive["spring"])
    tolerance, described = draw(decades(-9.0, -3.0)), f"{law!r} {laws} {path.tolist()} {drive}"
    return Case(
        "searched",
        described,
        lambda: Contacts(law, **laws),
        path,
        None,
        drive,
        tolerance,
        n_contacts=0 if drive else 5_000,
    )


@pytest.mark.slow
@hypothesis.settings(
    max_examples=int(os.environ.get("STABILITY_EXAMPLES", "60")),
    deadline=None,
    derandomize="STABILITY_EXAMPLES" not in os.environ,
    suppress_health_check=list(hypothesis.HealthCheck),
    database=None,
)
@hypothesis.given(any_case())
def test_no_case_that_a_search_finds_is_wrong(case: Case) -> None:
    """What it finds belongs into the table. Ensembles of a soft slider slip elsewhere, and are left out. Heat far above
    all barriers, which is drawn again and again, takes all the time that there is: a solver has less than in the table.
    """
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("toolkit.stability.case.LONGEST", 3.0)
        assert not [row for row in answered(case) if row.verdict == "wrong"]
