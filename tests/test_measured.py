"""Your own samples in scenes: lists, files, and the errors that come of few samples."""

from pathlib import Path

import numpy as np
import pytest

import origins
import toolkit
from toolkit.judge.describe import describe
from toolkit.pictures.thresholds import plot_samples
from toolkit.scene.interfaces import NAMES, misfit, numerical_only, sampling_errors
from toolkit.scene.kinds import from_samples

SAMPLES = 0.2 + np.random.default_rng(3).weibull(2.5, 100)


def write(folder: Path, text: str) -> Path:
    (folder / "own.txt").write_text(text, encoding="utf-8")
    return folder


def test_a_file_gives_the_law_of_its_values(tmp_path: Path) -> None:
    lines = "# thresholds\n" + "".join(f"{value!r}  # nm\n" for value in SAMPLES.tolist())
    law, x = from_samples(write(tmp_path, lines), file="own.txt"), np.linspace(0.3, 2.0, 9)
    assert (law.pdf(x) == origins.from_samples(SAMPLES).pdf(x)).all()


def test_forces_and_weights_from_a_file(tmp_path: Path) -> None:
    weights = np.linspace(1.0, 3.0, SAMPLES.size)
    lines = "".join(f"{force!r},{weight!r}\n" for force, weight in zip(SAMPLES.tolist(), weights.tolist(), strict=True))
    law = from_samples(write(tmp_path, lines), file="own.txt", quantity="f_s", column=1, weight_column=2,
                       coefficient=2.0)  # fmt: skip
    own = origins.from_samples(f_s=SAMPLES, coefficient=2.0, weights=weights)
    assert law.mean() == own.mean() and law.sf(0.7) == own.sf(0.7)


def test_a_column_beside_an_index_under_a_header(tmp_path: Path) -> None:
    lines = "event,force_uN\n" + "".join(f"{i},{force!r}\n" for i, force in enumerate(SAMPLES.tolist()))
    law = from_samples(write(tmp_path, lines), file="own.txt", quantity="f_s", column=2, stiffness=2.0)
    assert law.mean() == origins.from_samples(f_s=SAMPLES, stiffness=2.0).mean()
    with pytest.raises(origins.InputError, match="column = 2: says what a file holds"):
        from_samples(tmp_path, x_s=[1.0, 2.0], column=2)


@pytest.mark.parametrize(
    ("text", "more", "message"),
    [
        ("1.0\ntwo\n", {}, r"file = 'own\.txt': line 2 must hold one number, x_s finite and above zero"),
        ("a\nb\n1.0\n", {}, "line 2 must hold one number"),
        ("index,force\n1,0.5\n", {"quantity": "f_s"}, "several columns; say which of the 2 columns holds f_s"),
        ("1 2\n", {"column": 3}, "there is no column 3"),
        ("1 2\n", {"column": 0}, "column = 0: "),
        ("1 2\n1 -3\n", {"column": 1, "weight_column": 2}, "line 2 must hold 2 columns.*, weights finite"),
        ("1.0\n1.0 2.0\n", {}, "line 2 must hold one number"),
        ("# nothing\n", {}, "holds no numbers"),
        ("1.0\nnan\n", {"quantity": "f_s"}, "line 2 must hold one number, f_s finite and above zero"),
        ("1.0\n", {"quantity": "x"}, "quantity = 'x': must be"),
        ("1.0\n", {"x_s": [1.0]}, "holds the samples; leave x_s, f_s and weights out"),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, more: dict, message: str) -> None:
    with pytest.raises(origins.InputError, match=message):
        from_samples(write(tmp_path, text), file="own.txt", **more)


def test_absent_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(origins.InputError, match=r"file = 'none\.txt': no such file in"):
        from_samples(tmp_path, file="none.txt")
    with pytest.raises(origins.InputError, match="quantity = 'f_s': says what a file holds"):
        from_samples(tmp_path, x_s=[1.0, 2.0], quantity="f_s")


def test_errors_of_samples_are_sampling_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    contacts = origins.Contacts(origins.from_samples(SAMPLES))
    errors = sampling_errors(contacts)
    assert tuple(errors) == NAMES
    expected = SAMPLES.std(ddof=1) / np.sqrt(SAMPLES.size)
    # an error from 20 resamples is known to a sixth
    assert abs(errors["mean"] / expected - 1.0) < 0.7
    monkeypatch.setattr("toolkit.judge.describe.sampling_errors", lambda contacts: errors)
    numbers = describe(contacts).numbers
    assert all(numbers[name].error >= errors[name] for name in NAMES)
    assert sampling_errors(origins.Contacts(origins.gaussian(1.0, 0.1))) == {}


def test_few_samples_and_values_that_repeat_too_rarely_to_be_exact_are_told() -> None:
    (note,) = misfit(origins.from_samples([1.0, 1.0, 2.0, 2.0]))
    assert note == (
        "few thresholds, 4 samples: the smooth law's cdf lies 0.5 from that of the samples, sampling allows 0.68; take "
        "more samples; values that repeat are exact from 10 times on; those you know to be exact are `identical`"
    )
    (note,) = misfit(origins.from_samples(np.repeat([1.0, 2.0], 9)))
    assert "0.5 from that of the samples, sampling allows 0.32; take more samples; they are rounded" in note
    (note,) = misfit(origins.from_samples(SAMPLES, weights=10.0 ** np.arange(-50.0, 50.0)))
    assert note.startswith("few thresholds, 100 samples, which their weights make 1.2: ") and "repeat" not in note
    # exact they are
    assert misfit(origins.from_samples(np.repeat([1.0, 2.0], 15))) == []


def test_a_run_with_samples_says_whose_errors_it_tells() -> None:
    def notes(kind: dict) -> tuple[str, ...]:
        return toolkit.run({"contacts": {"thresholds": kind}, "drive": {"to": 1.0, "points": 3}, "master": {}}).notes

    assert notes({"kind": "gaussian", "mean": 1.0, "std": 0.1}) == ()
    (note,) = notes({"kind": "from-samples", "x_s": SAMPLES.tolist()})
    assert note.startswith("errors are numerical only, not those of the samples: ") and "bootstrap" in note
    assert [note] == numerical_only(origins.from_samples(SAMPLES))


def test_the_picture_shows_the_samples() -> None:
    from matplotlib.figure import Figure

    axes = plot_samples(Figure().subplots(), origins.from_samples(SAMPLES))
    (line,) = axes.lines
    x, above = line.get_data()
    np.testing.assert_allclose(above, [np.mean(one < SAMPLES) for one in x], atol=1e-12)
    assert x.size == 100 and line.get_drawstyle() == "steps-post"
    assert not plot_samples(Figure().subplots(), origins.gaussian(1.0, 0.1)).lines
