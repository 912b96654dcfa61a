"""README.md and docs: code runs and prints what they say, calls in tables give their numbers, links lead somewhere."""

import importlib.util
import re
import sys
import tomllib
from dataclasses import fields
from pathlib import Path
from types import ModuleType
from typing import Any

import matplotlib
import numpy as np
import pytest
from scipy import stats

import master
import origins
import toolkit
from eq_model.histogram import Histogram
from origins.thresholds.quadrature import gauss
from toolkit.scene.scene import shipped_scenes
from toolkit.scene.tables import read_table

ROOT = Path(__file__).parents[1]
README, DOCS = ROOT / "README.md", ROOT / "docs"
PAGES = {page.name: page for page in (README, *sorted(DOCS.glob("*.md")))}
TEXTS = {name: page.read_text(encoding="utf-8") for name, page in PAGES.items()}


def blocks(page: str, kind: str) -> list[str]:
    return re.findall(rf"```{kind}\n(.*?)```", TEXTS[page], re.DOTALL)


def executed(page: str, **changes: str) -> dict[str, Any]:
    """The names that all code of a page makes, run from its first line to its last."""
    names: dict[str, Any] = {}
    for code in blocks(page, "python"):
        for old, new in changes.items():
            code = code.replace(old, new)
        exec(compile(code, page, "exec"), names)
    return names


def script(name: str) -> ModuleType:
    """The module docs/<name>.py."""
    spec = importlib.util.spec_from_file_location(name, DOCS / f"{name}.py")
    assert spec is not None and spec.loader is not None
    sys.modules[name] = module = importlib.util.module_from_spec(spec)  # a dataclass looks it up
    spec.loader.exec_module(module)
    return module


# -- calls in tables ------------------------------------------------------------------------------

# page: the script beside it, and how many rows it has at least
TABLES = {"extremes.md": ("", 16), "laws.md": ("laws", 16), "sliders.md": ("sliders", 4)}
ROW = re.compile(r"^\| ([^|]+) \| `([^`]+)` \| (refused: [^|]+|[-\d.e]+) \|$", re.MULTILINE)
ROWS = [(page, *row) for page in TABLES for row in ROW.findall(TEXTS[page])]


@pytest.fixture(scope="module")
def named() -> dict[str, dict[str, Any]]:
    own = {"master": master, "pi": np.pi, "stats": stats, **vars(origins)}
    return {
        page: own | (vars(master) | vars(script(name)) if name else {})
        for page, (name, _) in TABLES.items()
    }


@pytest.mark.parametrize("page", TABLES)
def test_every_row_is_read(page: str) -> None:
    lines = TEXTS[page].split("## Numbers")[-1].splitlines()
    table = [line for line in lines if re.match(r"\| [^|]+ \| `[^`|]+` \| [^|]+ \|$", line)]
    assert len([row for row in ROWS if row[0] == page]) == len(table) >= TABLES[page][1]


@pytest.mark.parametrize(("page", "case", "call", "answer"), ROWS, ids=[row[2] for row in ROWS])
def test_row(page: str, case: str, call: str, answer: str, named: dict[str, Any]) -> None:
    if answer.startswith("refused: "):
        with pytest.raises(origins.InputError, match=re.escape(answer.removeprefix("refused: "))):
            eval(call, named[page])
        return
    value = float(eval(call, named[page]))
    digits = len(re.sub(r"^[-0.]*|[.]|e.*$", "", answer))
    allowed = 0.5001 * 10.0 ** (1 - max(digits, 9)) * abs(value)
    if page == "sliders.md":
        allowed = 1.5e-6  # its error, and the last digit's half
    elif "round-off" in case:
        allowed = 1e-14  # what counts as zero differs from machine to machine
    assert abs(value - float(answer)) <= allowed


# -- code, scenes, links --------------------------------------------------------------------------


@pytest.mark.parametrize("page", ["islands.md", "rough-surfaces.md"])
def test_a_page_prints_what_it_says(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    names = executed(page)
    assert capsys.readouterr().out.endswith(blocks(page, "text")[0])
    if page == "rough-surfaces.md":
        assert names["pc"].interface.separation == pytest.approx(names["h0"], rel=1e-12)
        assert names["pc"].interface.cautions == () and 0.05 < names["rough"].rms_slope < 0.5


def test_readme_is_a_door() -> None:
    assert len(TEXTS["README.md"].splitlines()) <= 150
    names = executed("README.md", **{"n_contacts=100_000": "n_contacts=100"})
    assert names["s"].success and names["s"].force_error < 1e-8
    assert names["e"].force.shape == names["s"].force.shape
    (scene,) = blocks("README.md", "toml")
    assert toolkit.load_scene(tomllib.loads(scene)).contacts.thresholds.mean() == 1.0
    (surface,) = blocks("origins.md", "toml")
    read = read_table(tomllib.loads(surface))
    assert read.contacts.thresholds["surface"]["file"] == "scan.di"


def test_named_scenes_are_shipped() -> None:
    commands = r"mesofriction (?:run|thresholds|precision|compare) ([-a-z ]+?) *(?:#|$)"
    found = re.findall(commands, "\n".join(TEXTS.values()), re.MULTILINE)
    named = {name for names in found for name in names.split()}
    told = TEXTS["laws.md"].split("Shipped scenes:")[1].split("Where the paper")[0]
    laws = set(re.findall(r"`([-a-z]+)`", told))
    assert len(named) >= 4 and len(laws) == 7 and named | laws <= set(shipped_scenes())


def test_examples_of_extending_run() -> None:
    names = executed("extending.md")
    law = names["half_cosine"](1.0)
    x = np.array([0.2, 0.7])
    np.testing.assert_allclose(law.cdf(x), x + np.sin(np.pi * x) / np.pi, rtol=1e-12)
    held = master.steady_state(names["contacts"])
    assert held.success and 0.0 < held.force < law.moment(2) / (2.0 * law.mean())


def test_the_glossary_is_short() -> None:
    assert TEXTS["glossary.md"].count("\n| ") - 1 <= 25


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    def address(line: str) -> str:
        return re.sub(r"[\s-]+", "-", re.sub(r"[^\w\s-]", "", line.lower())).strip("-")

    for target, anchor in re.findall(r"\]\(([^)#:]+)(?:#([^)]*))?\)", TEXTS[page]):
        file = PAGES[page].parent / target
        assert file.exists(), target
        if anchor:
            headings = re.findall(r"^#+ (.*)$", file.read_text(encoding="utf-8"), re.MULTILINE)
            assert anchor in map(address, headings), anchor


# -- pages with numbers of their own --------------------------------------------------------------


def test_transients_keep_mass_or_sign_and_not_both() -> None:
    found = script("laws").transient(end=1.0, step=0.01)
    sign, mass = found["positivity"], found["mass"]
    assert 0.75 < sign.outrun < 0.85 and sign.mass_defect[-1] > 0.06
    assert sign.positivity_defect.max() == 0.0
    assert mass.path[-1] < 0.85 and np.abs(mass.mass_defect).max() < 1e-12


def test_histograms(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    matplotlib.use("Agg")
    (scene,) = blocks("histograms.md", "toml")
    tables = tomllib.loads(scene)
    tables["eq"] |= {"contacts": 20_000, "replicas": 1}
    result = toolkit.run(tables, folder="hold-output")
    names = executed("histograms.md")
    assert Path("histograms.png").read_bytes().startswith(b"\x89PNG")
    assert result.eq is not None
    _, after, later = result.eq.histograms
    assert [result.time[one.point] for one in result.eq.histograms] == [2.0, 102.0, 102.5]
    (told,) = re.findall(r"Of the scene above (\d+) % ", TEXTS["histograms.md"])
    printed = re.findall(r"^([\d.]+)% of all contacts are at x = 0$", capsys.readouterr().out, re.M)
    assert abs(float(printed[0]) - float(told)) < 1.5
    # what a bin says of itself, and two of them
    rebinned = names["rebinned"]
    _, *own = rebinned(after.stretch_edges, after.stretches, result.eq.contacts, 4096)
    assert np.allclose(own, [after.stretches, after.stretch_error])
    edges, density, _ = rebinned(later.threshold_edges, later.thresholds, later.count, 2048)
    assert np.array_equal(edges, later.threshold_edges[::2])
    assert float((density * np.diff(edges)).sum()) == pytest.approx(1.0)
    weight = later.stretches.sum() * np.diff(later.stretch_edges)[0]
    assert float(weight) == pytest.approx(later.count / 20_000)
    rows = " ".join(re.findall(r"^\| (`[^|]+) \|", TEXTS["histograms.md"], re.MULTILINE))
    assert {field.name for field in fields(Histogram)} <= set(re.findall(r"`(\w+)`", rows))


def test_rough_surfaces(tmp_path: Path) -> None:
    own = script("rough_surfaces")
    found = own.readings()
    assert set(own.table(found)) <= set(TEXTS["rough-surfaces.md"].splitlines())
    own.draw(found, tmp_path / "again.png")
    assert (tmp_path / "again.png").stat().st_size > 50_000 and own.PICTURE.is_file()
    spring = {reading.name: reading.propensity.critical_spring for reading in found}
    assert spring["GW, strength"] / spring["GW, amontons"] == pytest.approx(90, rel=0.03)
    assert spring["GW, amontons, mixed"] / spring["GW, amontons"] == pytest.approx(200, rel=0.03)
    for law in ("amontons", "paper"):
        assert 30 < spring[f"Persson, {law}"] / spring[f"GW, {law}"] < 40
    gw, mixed, persson = (
        toolkit.load_scene(f"rough-{name}").contacts.interface
        for name in ("gw-amontons", "gw-mixed", "persson-amontons")
    )
    assert f"{gw.area_fraction:.2%}" == "0.96%" and f"{persson.area_fraction:.2%}" == "0.92%"
    # the patches are as large as the advice has it
    assert persson.patch_area == pytest.approx(gw.mean_area, rel=1e-3)
    assert f"{mixed.plasticity_index:.1f}" == "8.5"
    assert mixed.plastic_fraction == pytest.approx(0.25, abs=0.01)


def test_stress_above_the_hardness() -> None:
    """Persson's share of area and load above H, by sums over the stresses as (PcPersson) has them."""
    i = toolkit.load_scene("rough-persson-amontons").contacts.interface
    width, hardness = i.material.contact_modulus * np.sqrt(i.moments.m2), i.material.hardness
    edges = np.unique(np.append(np.linspace(0.0, 10.0 * width, 101), hardness))
    s, weights = gauss(edges[:-1], edges[1:])
    away, mirrored = (s - i.pressure) / width, (s + i.pressure) / width
    density = weights * (np.exp(-(away**2)) - np.exp(-(mirrored**2)))
    parts = (density, s * density)
    area, load = (part[edges[:-1] >= hardness].sum() / part.sum() for part in parts)
    assert i.plastic_fraction == pytest.approx(area, rel=1e-6)
    said = f"{100 * area:.1f} %\nof the area", f"{100 * load:.1f} % of the load"
    assert all(part in TEXTS["rough-surfaces.md"] for part in said)
    assert any("plastic" in line for line in i.cautions)
