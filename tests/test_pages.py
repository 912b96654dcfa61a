"""README.md and docs: code prints what they say, calls and keys in tables are the code's, links lead somewhere."""

import importlib.util
import inspect
import re
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import msgspec
import numpy as np
import pytest
from conftest import slow
from scipy import stats

import master
import origins
import toolkit
from origins.laws.thermal import RATE_LAWS
from toolkit.scene import laws, tables
from toolkit.scene.scene import shipped_scenes

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


# page: the script beside it, and how many rows it has at least
TABLES = {"extremes.md": ("", 16), "laws.md": ("laws", 16), "sliders.md": ("sliders", 4)}
ROW = re.compile(r"^\| ([^|]+) \| `([^`]+)` \| (refused: [^|]+|[-\d.e]+) \|$", re.MULTILINE)
SLOW = ("static_force", "growing_grains", "PEAKS")  # a second each
ROWS = [(page, *row) for page in TABLES for row in ROW.findall(TEXTS[page])]


@pytest.fixture(scope="module")
def named() -> dict[str, dict[str, Any]]:
    own = {"master": master, "pi": np.pi, "stats": stats, **vars(origins)}
    by_master = {name: getattr(master, name) for name in master.__all__}
    return {
        page: own | (by_master | vars(script(name)) if name else {})
        for page, (name, _) in TABLES.items()
    }


@pytest.mark.parametrize(
    ("page", "case", "call", "answer"),
    [slow(*row, id=row[2], when=any(name in row[2] for name in SLOW)) for row in ROWS],
)
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


@pytest.mark.parametrize("page", [slow("islands.md"), "rough-surfaces.md"])
def test_a_page_prints_what_it_says(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    names = executed(page)
    assert capsys.readouterr().out.endswith(blocks(page, "text")[0])
    if page == "rough-surfaces.md":
        assert names["pc"].interface.separation == pytest.approx(names["h0"], rel=1e-12)
        assert names["pc"].interface.cautions == () and 0.05 < names["rough"].rms_slope < 0.5


def test_readme_is_a_door() -> None:
    assert len(TEXTS["README.md"].splitlines()) <= 150 and TEXTS["glossary.md"].count("\n| ") <= 26
    names = executed("README.md", **{"n_contacts=100_000": "n_contacts=100"})
    assert names["s"].success and names["s"].force_error < 1e-8
    assert names["e"].force.shape == names["s"].force.shape
    (scene,) = blocks("README.md", "toml")
    assert toolkit.load_scene(tomllib.loads(scene)).contacts.thresholds.mean() == 1.0
    commands = r"mesofriction (?:run|thresholds|precision|compare) ([-a-z ]+?) *(?:#|$)"
    found = " ".join(re.findall(commands, "\n".join(TEXTS.values()), re.MULTILINE)).split()
    assert len(found) >= 4 and set(found) <= set(shipped_scenes())


def test_examples_of_extending_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of laws with a memory run in test_own_law.py."""
    before = TEXTS["extending.md"].split("## A new law with a memory")[0]
    monkeypatch.setitem(TEXTS, "extending.md", before)
    names = executed("extending.md")
    law = names["half_cosine"](1.0)
    x = np.array([0.2, 0.7])
    np.testing.assert_allclose(law.cdf(x), x + np.sin(np.pi * x) / np.pi, rtol=1e-12)
    held = master.steady_state(names["contacts"])
    assert held.success and 0.0 < held.force < law.moment(2) / (2.0 * law.mean())
    by_master, by_ensemble = names["by_master"], names["by_ensemble"]
    off = np.abs(by_master.force - by_ensemble.force)
    assert by_master.success and (off <= 5.0 * by_ensemble.force_standard_error + 1e-15).all()
    named = names["LinearBarrier"](0.1, barrier=2.0)
    monkeypatch.setitem(RATE_LAWS, named.name, names["LinearBarrier"])
    by_name = origins.Thermal("linear-barrier", 0.1, barrier=2.0)
    assert names["Contacts"](law, thermal=named).thermal == by_name
    thermal = {"law": "linear-barrier", "temperature": 0.1, "barrier": 2.0}
    tables = {"contacts": {"thresholds": {"kind": "identical", "value": 1.0}, "thermal": thermal}}
    assert (
        toolkit.load_scene(
            tables | {"master": {}, "drive": {"to": 1.0, "points": 2}}
        ).contacts.thermal
        == by_name
    )
    thermal["barier"] = thermal.pop("barrier")
    with pytest.raises(
        origins.InputError, match=r"contacts.thermal.barier = 2.0: is unknown; .* barrier"
    ):
        toolkit.load_scene(tables, solved=False)


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


def test_histograms(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (scene,) = blocks("histograms.md", "toml")
    tables = tomllib.loads(scene)
    tables["eq"] |= {"contacts": 20_000, "replicas": 1}
    result = toolkit.run(tables, folder="hold-output")
    executed("histograms.md")
    assert Path("histograms.png").read_bytes().startswith(b"\x89PNG")
    assert [result.time[one.point] for one in result.eq.histograms] == [2.0, 102.0, 102.5]
    (told,) = re.findall(r"Of the scene above (\d+) % ", TEXTS["histograms.md"])
    printed = re.findall(r"^([\d.]+)% of all contacts are at x = 0$", capsys.readouterr().out, re.M)
    assert abs(float(printed[0]) - float(told)) < 1.5


@pytest.mark.slow  # quick: the page that prints what it says, above
def test_rough_surfaces(tmp_path: Path) -> None:
    own = script("rough_surfaces")
    found = own.readings()
    assert set(own.table(found)) <= set(TEXTS["rough-surfaces.md"].splitlines())
    own.draw(found, tmp_path / "again.png")
    assert (tmp_path / "again.png").stat().st_size > 50_000 and own.PICTURE.is_file()
    spring = {reading.name: reading.propensity.critical_spring for reading in found}
    assert spring["GW, strength"] / spring["GW, amontons"] == pytest.approx(90, rel=0.03)
    assert spring["GW, amontons, mixed"] / spring["GW, amontons"] == pytest.approx(200, rel=0.03)


# -- docs/scenes.md --------------------------------------------------------------------------------

GIVEN = ("folder", "comm", "thresholds")  # not for a scene to say
STRUCTS = {
    "The file": tables.SceneTable,
    "[contacts]": tables.ContactsTable,
    "[drive]": tables.DriveTable,
    "[master]": tables.MasterTable,
    "[eq]": tables.EqTable,
    "[sweep]": tables.SweepTable,
    "[verdict]": tables.VerdictTable,
    "[sweep.velocity]": tables.RangeTable,
}
OF_KINDS = {
    "[contacts.start]": laws.START,
    "[contacts.reforming]": laws.REFORMING,
    "[contacts.thresholds]": laws.THRESHOLDS,
    "[contacts.thresholds.surface]": laws.SURFACES,
    "[contacts.thresholds.material.contact_stiffness]": laws.STIFFNESSES,
    "[contacts.thresholds.island]": laws.ISLANDS,
    "[contacts.thresholds.substrate]": laws.SUBSTRATES,
}
CALLS = {
    **{f"[contacts.{name}]": laws.named(place) for name, place in laws.GROWTHS.items()},
    "[contacts.thermal]": origins.Thermal,
    "[contacts.ageing]": origins.Ageing,
    "[contacts.delay]": origins.Delay,
    "[contacts.interface]": origins.StatedInterface,
    "[contacts.thresholds.material]": origins.Material,
}


def sections() -> dict[str, list[list[str]]]:
    """The rows of each table, cells without their backticks, by the heading above it."""
    found: dict[str, list[list[str]]] = {}
    for line in TEXTS["scenes.md"].splitlines():
        if line.startswith("## "):
            rows = found.setdefault(line.removeprefix("## ").strip("`"), [])
        elif re.match(r"\| (`|\|)", line):
            rows.append([cell.strip() for cell in line.strip("|").split("|")])
    return found


def told(cells: list[str]) -> tuple[str, Any]:
    """A row's key and default; a key that is needed has inspect's empty one."""
    key, _, default, _ = cells
    value = {"needed": inspect.Parameter.empty, "left out": None}.get(default, default)
    if isinstance(value, str):
        value = tomllib.loads(f"it = {value.strip('`')}")["it"]
    return key.strip("`"), value


def of_function(function: Any) -> dict[str, Any]:
    parameters = inspect.signature(function).parameters
    named = {name: one for name, one in parameters.items() if one.kind is not one.VAR_KEYWORD}
    return {name: one.default for name, one in named.items() if name not in GIVEN}


def test_the_front_page_of_the_site_shows_the_verdict(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first page is README, its first picture that of `mesofriction verdict`; mkdocs, which builds the pages, is
    stood for by what docs/pages.py takes of it."""
    kept = {}

    class File:
        @staticmethod
        def generated(config: Any, address: str, content: str = "", abs_src_path: str = "") -> str:
            kept[address] = content
            return address

    for module, name in {"config.defaults": "MkDocsConfig", "structure.files": "Files"}.items():
        stand_in = SimpleNamespace(**{name: object, "File": File})
        monkeypatch.setitem(sys.modules, f"mkdocs.{module}", stand_in)
    pages = script("pages")
    for name in ("gallery", "api"):
        monkeypatch.setattr(pages, name, lambda *_: "")  # they read all scenes and rooms
    assert "index.md" in pages.on_files([], None)
    assert re.findall(
        r"^nav:\n  - \w+: (\S+)$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE
    ) == ["index.md"]
    shown = re.findall(r"!\[[^]]+\]\(([^)]+)\)", kept["index.md"])
    assert shown[0] == "pictures/verdict.png" and all(
        (DOCS / picture).is_file() for picture in shown
    )
    assert re.search(r"verdict\.png\)\n\n`mesofriction verdict`: does this", kept["index.md"])


def test_page_has_a_section_for_every_table() -> None:
    assert set(sections()) == {*STRUCTS, *OF_KINDS, *CALLS}


@pytest.mark.parametrize("heading", STRUCTS)
def test_table_of_fixed_keys(heading: str) -> None:
    fields = msgspec.structs.fields(STRUCTS[heading])
    code = {
        field.encode_name: inspect.Parameter.empty if field.required else field.default
        for field in fields
    }
    assert dict(map(told, sections()[heading])) == code


@pytest.mark.parametrize("heading", CALLS)
def test_table_of_one_function(heading: str) -> None:
    assert dict(map(told, sections()[heading])) == of_function(CALLS[heading])


def test_named_laws_of_rates() -> None:
    (row,) = (row for row in sections()["[contacts.thermal]"] if row[0] == "`law`")
    assert re.findall(r'"(\w+)"', row[-1]) == list(RATE_LAWS)


@pytest.mark.parametrize("heading", OF_KINDS)
def test_table_of_kinds(heading: str) -> None:
    page: dict[str, dict[str, Any]] = {}
    for kind, *cells in sections()[heading]:
        if kind:
            page[kind.strip("`")] = row = {}
        row.update([told(cells)])
    code = {}
    for kind, place in OF_KINDS[heading].items():
        module, name = place.split(":")
        code[kind] = of_function(getattr(import_module(module), name))
    assert page == code
