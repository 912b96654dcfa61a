"""Contacts, starts and the drive: what they say and what they refuse."""

import numpy as np
import pytest
from scipy import stats

import origins
from origins import Contacts, Drive, InputError, gaussian_start
from origins.start import as_start

GAUSSIAN = origins.gaussian(1.0, 0.05)
BOX = origins.rectangular(0.5, 1.0)


def says(call, *parts: str) -> None:
    with pytest.raises(InputError) as refusal:
        call()
    assert all(part in str(refusal.value) for part in parts) and "\n" not in str(refusal.value), str(refusal.value)


def test_contacts_of_any_law() -> None:
    contacts = Contacts(thresholds=GAUSSIAN)
    assert contacts.thresholds is GAUSSIAN and contacts.start.is_single and contacts.start.mean() == 0.0
    assert contacts.mean_threshold == 1.0 and contacts.cut_weight == 0.0
    assert Contacts(stats.gamma(3.0)).mean_threshold == 3.0
    assert Contacts(origins.identical(2.0)).mean_threshold == 2.0


@pytest.mark.parametrize("infinite", [stats.halfcauchy(), stats.lomax(0.8)])
def test_infinite_mean(infinite) -> None:
    says(lambda: Contacts(infinite), "thresholds: the mean is inf", "never reach a steady state")


def test_infinite_mean_of_an_own_law() -> None:
    class Slow(origins.Thresholds):
        def support(self) -> tuple[float, float]:
            return 1.0, np.inf

        def _moment(self, n: int) -> float:
            return np.inf

    says(lambda: Contacts(Slow()), "thresholds: the mean threshold is inf")


@pytest.mark.parametrize("value", [1.0, 1.5, -1.0, -3.0])
def test_single_start_beyond_every_threshold(value: float) -> None:
    says(lambda: Contacts(BOX, start=value), "start: a weight of 1 lies beyond every threshold", "|x| >= 1;")
    assert Contacts(BOX, start=np.sign(value) * 0.999).cut_weight == 0.0


def test_start_at_the_one_threshold() -> None:
    says(lambda: Contacts(origins.identical(1.0), start=1.0), "beyond every threshold")
    assert Contacts(origins.identical(1.0), start=np.nextafter(1.0, 0.0)).cut_weight == 0.0


def test_start_where_survival_underflows() -> None:
    """No end of the support, but nothing left that floating point can tell."""
    says(lambda: Contacts(GAUSSIAN, start=10.0), "start: a weight of 1 lies beyond every threshold")
    says(lambda: Contacts(GAUSSIAN, start=gaussian_start(0.0, 3.0)), "beyond every threshold, at |x| >= 2.8")
    assert Contacts(GAUSSIAN, start=2.5).cut_weight == 0.0


def test_start_weight_beyond_is_cut_and_said() -> None:
    """Up to 1e-6 is cut off; both sides count, since barriers and thresholds ask for |x|."""
    for std, weight in ((0.2, 2 * stats.norm.sf(5.0)), (0.15, 2 * stats.norm.sf(1 / 0.15))):
        contacts = Contacts(BOX, start=gaussian_start(0.0, std))
        assert contacts.cut_weight == pytest.approx(weight, rel=1e-12) and 0.0 < contacts.cut_weight < 1e-6
    says(lambda: Contacts(BOX, start=gaussian_start(0.0, 0.21)), "start: a weight of 1.92e-06 lies beyond")
    says(lambda: Contacts(BOX, start=stats.uniform(0.9, 0.2)), "start: a weight of 0.5 lies beyond")
    assert Contacts(BOX, start=stats.uniform(-1.0, 2.0)).cut_weight == 0.0
    assert Contacts(BOX, start=gaussian_start(0.0, 0.025)).cut_weight == 0.0


def test_starts() -> None:
    assert as_start(None).span == (0.0, 0.0) and as_start(0.3).mean() == 0.3 and as_start(np.float64(-0.1)).is_single
    single = gaussian_start(0.2, 0.0)
    assert single.is_single and single.span == (0.2, 0.2) and as_start(single) is single
    x, q = np.linspace(-0.1, 0.1, 7), np.array([1e-12, 0.3, 0.9])
    for start, twin in (
        (gaussian_start(0.01, 0.025), stats.norm(0.01, 0.025)),
        (as_start(stats.expon()), stats.expon()),
    ):
        assert not start.is_single and start.mean() == pytest.approx(twin.mean(), rel=1e-15)
        for name, argument in (("pdf", x), ("cdf", x), ("sf", x), ("ppf", q), ("isf", q)):
            np.testing.assert_allclose(getattr(start, name)(argument), getattr(twin, name)(argument), rtol=1e-12)
        assert twin.cdf(start.span[0]) + twin.sf(start.span[1]) < 4e-16
    assert as_start(stats.uniform(1.0, 2.0)).span == (1.0, 3.0)
    assert as_start(stats.uniform(1.0, 2.0)).breakpoints.tolist() == [1.0, 3.0]


@pytest.mark.parametrize(
    "bad, says_",
    [
        (np.nan, "start = nan: "),
        (np.inf, "start = inf: "),
        ("relaxed", "start = 'relaxed': "),
        (True, "start = True: "),
        ([0.0, 1.0], "start = [0.0, 1.0]: "),
        (stats.cauchy(), "start: the mean of the distribution is"),
        (stats.norm([0.0, 1.0], 1.0), "start: the distribution has arrays as parameters"),
        (stats.poisson(1.0), "start = "),
    ],
)
def test_bad_starts(bad: object, says_: str) -> None:
    says(lambda: Contacts(GAUSSIAN, start=bad), says_)


def test_bad_gaussian_starts() -> None:
    says(lambda: gaussian_start(np.nan, 0.1), "mean = nan: ")
    says(lambda: gaussian_start(0.0, -0.1), "std = -0.1: ")
    says(lambda: gaussian_start(0.0, np.inf), "std = inf: ")


def test_paths() -> None:
    assert Drive([0.0, 1.0, 1.0, 3.0]).path.tolist() == [0.0, 1.0, 1.0, 3.0]
    assert Drive(2.0).path.tolist() == [2.0] and Drive([3]).path.dtype == float
    assert Drive(np.linspace(0, 5, 501)).path.shape == (501,)
    assert Drive([0.0, 2.0]).forward and not Drive([0.0, 2.0, 1.0]).forward and not Drive([-0.1, 1.0]).forward
    assert Drive([0.0, 1.0], time=[0.0, 3.0]).only_forward("this").time.tolist() == [0.0, 3.0]


@pytest.mark.parametrize(
    "path, begins",
    [
        ([], "path = array of shape (0,): "),
        ([[0.0, 1.0]], "path = array of shape (1, 2): "),
        ([0.0, np.nan, 1.0], "path[1] = nan: "),
        ([0.0, np.inf], "path[1] = inf: "),
        ([-0.1, 1.0], "path[0] = -0.1: lies behind X = 0; this takes a path that does not turn round"),
        ([0.0, 2.0, 1.0, 3.0], "path[2] = 1.0: lies behind path[1] = 2; this takes a path that does not turn round"),
        ("far", "path = 'far': "),
        (None, "path"),
        ([0.0, "x"], "path = [0.0, 'x']: "),
    ],
)
def test_bad_paths(path: object, begins: str) -> None:
    with pytest.raises(InputError) as refusal:
        Drive(path).only_forward("this")  # type: ignore[arg-type]
    assert str(refusal.value).startswith(begins)


@pytest.mark.parametrize("law", [(1e200, 1e199), (1e300, 1e299), (1e-200, 1e-201)])
def test_lengths_whose_powers_overflow_are_refused(law: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="choose another unit of length"):
        Contacts(origins.gaussian(*law))


def test_contacts_that_never_hold_are_refused() -> None:
    class Loose(origins.Thresholds):
        """Half of the weight at 0, the rest at 1."""

        def support(self) -> tuple[float, float]:
            return 0.0, 1.0

        @property
        def atoms(self) -> tuple[np.ndarray, np.ndarray]:
            return np.array([0.0, 1.0]), np.array([0.5, 0.5])

    with pytest.raises(origins.InputError, match=r"a weight of 0\.5 lies at x = 0; such contacts never hold"):
        origins.Contacts(Loose())
