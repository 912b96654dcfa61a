"""What scenes build: each kind of thresholds, drives in space and time, the ensemble's laws; files, and odd values."""

import copy
import math
import re
import tomllib
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import slow
from scenes import GAUSSIAN, ROUGH, scene

import eq_model
import origins
import toolkit
from origins.errors import InputError
from toolkit.running.checkpoint import identity
from toolkit.scene import laws
from toolkit.scene.interfaces import foreseen
from toolkit.scene.scene import SHIPPED
from toolkit.scene.tables import to_toml

# a call of every kind that works
LAWS: dict[str, dict[str, Any]] = {
    "identical": {"value": 1.5},
    "gaussian": {"mean": 1.0, "std": 0.05},
    "rectangular": {"lower": 0.5, "upper": 1.5},
    "gw-elastic": {"B": 1.588},
    "gw-plastic": {"B": 1.251},
    "gw-gaussian": {"separation": 1.0, "scale": 2.0, "regime": "mixed", "plasticity_index": 9.0},
    "persson": {"centre": 1.0, "width": 0.5},
    "lubricated": {"width": 0.7, "power": 2.0, "decay": 1.5},
    "grains": {"alpha": 1.0, "time": 8.0, "B": 1.0, "jacobian": "paper"},
    "growing-grains": {"alpha": 1.0, "B": 1.0, "age": 4.0},
    "domains": {"lattice_constant": 3.88, "sizes": [[7, 9]], "stiffness": 1.0, "samples": 200},
    "from-samples": {"x_s": [0.9, 1.0, 1.1, 1.3]},
}


@pytest.mark.parametrize("kind", [*sorted(laws.THRESHOLDS)])
def test_kind_is_the_function_of_that_name(kind: str) -> None:
    if kind == "mixture":
        parts = [{"kind": name, **LAWS[name]} for name in ("gaussian", "rectangular")]
        given = {"components": parts, "weights": [0.25, 0.75]}
        built = [origins.gaussian(1.0, 0.05), origins.rectangular(0.5, 1.5)]
        direct = origins.mixture(built, [0.25, 0.75])
    elif kind == "from-topography":
        surface = {"shape": (64, 64), "pixel_size": 1e-8, "hurst": 0.8, "rms_slope": 0.1, "seed": 1}
        given = ROUGH | {"surface": {"kind": "self-affine", **surface}}
        options = {"model": "gw", "law": "amontons", "pressure": 1e6}
        options |= {"detrend": "centre", "periodic": True}
        heights = origins.self_affine_surface(**surface)
        material = origins.Material(**given["material"])
        direct = origins.from_topography(heights, 1e-8, **options, material=material)
    else:
        given = LAWS[kind]
        direct = origins.Contacts(getattr(origins, kind.replace("-", "_"))(**given)).thresholds
    asked = scene({"kind": kind, **given}, drive={"to": 1e-8, "points": 3})
    built = toolkit.load_scene(asked).contacts.thresholds
    x = direct.mean() * np.linspace(0.01, 3.0, 50)
    assert np.array_equal(built.sf(x), direct.sf(x)) and built.mean() == direct.mean()


def test_kelvins_are_a_temperature_where_contacts_have_a_stiffness() -> None:
    def contacts(temperature: Any, **surface: float) -> origins.Contacts:
        law = ROUGH | {"surface": ROUGH["surface"] | surface}
        warm = {"law": "soft", "temperature": temperature, "attempt_frequency": 1e12}
        tables = {"thresholds": law, "thermal": warm}
        return toolkit.load_scene(scene(contacts=tables, drive={"to": 1e-8, "points": 3})).contacts

    found = contacts({"kelvin": 300.0})
    known = 1.380649e-23 * 300.0 / found.interface.mean_stiffness
    assert found.thermal.temperature == pytest.approx(known, rel=1e-14)
    assert contacts(known).thermal.temperature == known
    # joules; and micrometres taken for metres
    with pytest.raises(InputError, match=r"'27 C': must be .* or \{ kelvin = 300\.0 \}$"):
        contacts("27 C")
    with pytest.raises(InputError, match=r"temperature = 4\.14e-21: .*\{ kelvin = 299\.9 \}"):
        contacts(4.14e-21)
    with pytest.raises(
        InputError, match=r"in m², .* did you mean temperature = \{ kelvin = 300 \}"
    ):
        contacts(300)
    told = r"^contacts\.thermal\.temperature\.kelvin = 300\.0: k_BT/<k> = .* in their unit\?"
    with pytest.raises(InputError, match=told):
        contacts({"kelvin": 300.0}, radius=1.0, std=0.05, density=1.0)


def test_scans_are_found_beside_the_scene_file(tmp_path: Path) -> None:
    scans = pytest.importorskip("SurfaceTopography")
    heights = 200.0 * origins.self_affine_surface((24, 24), 1.0, hurst=0.8, rms_slope=0.1, seed=1)
    sizes = "Width: 10 µm\nHeight: 10 µm\nValue units: nm"
    np.savetxt(tmp_path / "own.txt", heights, header=sizes)
    (tmp_path / "text.di").write_text("no scan at all")

    def mean(**scan: str) -> float:
        law = ROUGH | {"surface": {"kind": "scan", **scan}}
        file = tmp_path / "scan.toml"
        file.write_text(to_toml(scene(law, drive={"to": 1e-8, "points": 3})))
        return toolkit.load_scene(file).contacts.thresholds.mean()

    topography = scans.open_topography(str(tmp_path / "own.txt")).topography()
    options = {"model": "gw", "law": "amontons", "pressure": 1e6}
    material = origins.Material(**ROUGH["material"])
    direct = origins.from_topography(topography, **options, material=material)
    assert mean(file="own.txt") == direct.mean()
    for key, told, wrong in (
        ("file", "cannot be read as a scan", {"file": "text.di"}),
        ("unit", "the file has its own; leave it out", {"file": "own.txt", "unit": "nm"}),
    ):
        with pytest.raises(InputError, match=rf"^contacts\.thresholds\.surface.{key} = .*: {told}"):
            mean(**wrong)


CONTACT_LAWS: dict[str, Any] = {  # as a scene has it, and as origins
    "thermal": (
        {"law": "stiff", "temperature": 0.01, "attempt_frequency": 2.0},
        origins.Thermal("stiff", 0.01, 2.0),
    ),
    "delay": ({"time": 0.2}, origins.Delay(0.2)),
    "reforming": (
        {"kind": "boltzmann", "temperature": 1e-4},
        origins.boltzmann_reforming(1e-4).pdf(0.01),
    ),
    "stiffness": ("linked", "linked"),
}


def test_columns_of_samples_are_named_and_may_have_decimal_commas(tmp_path: Path) -> None:
    def mean(text: str, **more: Any) -> float:
        (tmp_path / "own.txt").write_text(text, encoding="utf-8")
        law = {"kind": "from-samples", "file": str(tmp_path / "own.txt"), **more}
        return toolkit.load_scene(scene(law)).contacts.mean_threshold

    plain = mean("1.0\n1.1\n1.3\n")
    table = "count;x_s;w\n1;1,0;5\n2;1,1;5\n3;1,3;5\n"
    assert mean(table, column="x_s") == plain == mean(table, column="x_s", weight_column="w")
    assert mean("# n x_s\n1 1.0\n2 1.1\n3 1.3\n", column="x_s") == plain
    assert mean("1,0\n1,1\n1,3\n", decimal=",") == plain
    for text, more, told in (
        (table, {"column": "x_S"}, "column = 'x_S': is no column of the header; did you mean x_s?"),
        (
            "1.0\n2.0\n",
            {"column": "x_s"},
            "no header stands before the numbers; write its number, as",
        ),
        ("1,0\n1,1\n", {}, 'write decimal = ","'),
        ("3,7298e-09\n1,85e-9\n", {}, 'write decimal = ","'),
        ("1.0\n1.1\n", {"decimal": ";"}, "decimal = ';'"),
    ):
        with pytest.raises(InputError) as wrong:
            mean(text, **more)
        assert told in str(wrong.value)


def test_a_damaged_scan_is_told_in_words(tmp_path: Path) -> None:
    """Readers quote the bytes that they cannot read; the message does not."""
    pytest.importorskip("SurfaceTopography")
    (tmp_path / "junk.di").write_bytes(np.random.default_rng(1).bytes(3000))
    law = ROUGH | {"surface": {"kind": "scan", "file": str(tmp_path / "junk.di")}}
    with pytest.raises(InputError, match=r"none of the .* readers .* takes it") as told:
        toolkit.load_scene(scene(law, drive={"to": 1e-8, "points": 3}))
    assert str(told.value).isprintable()


def test_a_matrix_of_heights_may_have_commas_or_semicolons(tmp_path: Path) -> None:
    """The same thresholds, gaps included, as with blanks; a comma that may be a decimal one is never a separator."""
    pytest.importorskip("SurfaceTopography")
    heights = 2e-7 * origins.self_affine_surface((24, 20), 1.0, hurst=0.8, rms_slope=0.1, seed=1)
    heights[3, 5] = heights[8, -1] = np.nan
    cells = [[f"{height:.6e}" for height in row] for row in heights.T]

    def moments(mark: str, gap: str, decimal: str = ".", rows: Any = cells) -> Any:
        lines = [mark.join(row).replace("nan", gap).replace(".", decimal) for row in rows]
        (tmp_path / "own.csv").write_text("# heights\n" + "\n".join(lines))
        surface = {"kind": "scan", "file": str(tmp_path / "own.csv"), "unit": "m"}
        law = ROUGH | {"surface": surface | {"physical_sizes": [2.4e-5, 2e-5]}}
        made = toolkit.load_scene(scene(law, drive={"to": 1e-8, "points": 3}))
        return made.contacts.interface.moments

    plain = moments(" ", "nan")
    assert plain.missing_fraction == 2 / 480
    assert moments(",", "nan") == moments(",", "") == moments(" , ", "NaN") == plain
    assert moments(";", "") == moments(";", "", ",") == moments(";\t", "nan", ",") == plain
    assert moments(",", "nan", rows=[[*row, ""] for row in cells]) == plain
    wrong = {"mark": "\t", "decimal": ","}, {"mark": " ", "decimal": ","}
    for given in (*wrong, {"mark": ",", "rows": [*cells, cells[0] * 2]}):
        with pytest.raises(InputError, match=r"blanks, commas or semicolons .* nan or nothing"):
            moments(gap="nan", **given)


@pytest.mark.parametrize("name", CONTACT_LAWS)
def test_contacts_carry_every_law_of_a_scene(name: str) -> None:
    start = {"kind": "gaussian", "mean": 0.0, "std": 0.025}
    tables = {"thresholds": GAUSSIAN, "start": start, name: CONTACT_LAWS[name][0]}
    contacts = toolkit.load_scene(scene(contacts=tables)).contacts
    found = getattr(contacts, name)
    assert contacts.laws == (name,)
    assert (found.law.pdf(0.01) if name == "reforming" else found) == CONTACT_LAWS[name][1]
    assert contacts.start.pdf(0.01) == origins.gaussian_start(0.0, 0.025).pdf(0.01)


@pytest.mark.parametrize(
    ("turns", "points"), [([3.0, -3.0, 3.0], 601), ([1.0, 0.999, 5.0], 4), ([2.0, -1e-9, 1e-9], 6)]
)
def test_every_turning_point_is_a_point_of_the_path(turns: list[float], points: int) -> None:
    path = toolkit.load_scene(scene(drive={"turns": turns, "points": points})).path
    assert path.size == points and path[0] == 0.0 and path[-1] == turns[-1]
    place = [int(np.flatnonzero(path == turn)[0]) for turn in turns[:-1]] + [points - 1]
    ends = [0.0, *turns]
    for first, last, begin, end in zip([0, *place[:-1]], place, ends[:-1], ends[1:], strict=True):
        leg = np.linspace(begin, end, last - first + 1)
        np.testing.assert_allclose(path[first : last + 1], leg, atol=1e-15)


def test_drives_in_time_begin_hold_and_change_speed() -> None:
    def driven(**drive: Any) -> origins.Drive:
        return toolkit.load_scene(scene(drive=drive)).drive

    made = driven(turns=[1.0, 1.0, 3.0, 2.0], times=[2.0, 10.0, 11.0, 11.5], points=10)
    # as many points to each piece, holds among them
    path = [0.0, 0.5, 1.0, 1.0, 1.0, 5 / 3, 7 / 3, 3.0, 2.5, 2.0]
    assert made.path.tolist() == pytest.approx(path)
    time = [0.0, 1.0, 2.0, 6.0, 10.0, 31 / 3, 32 / 3, 11.0, 11.25, 11.5]
    assert made.time.tolist() == pytest.approx(time)
    made = driven(**{"from": 0.5}, turns=[2.0, 2.0], times=[1.0, 2.0, 4.0], points=5)
    assert made.path.tolist() == [0.5, 1.25, 2.0, 2.0, 2.0]
    assert made.time.tolist() == [1.0, 1.5, 2.0, 3.0, 4.0]
    # points of a hold may be even in its logarithm
    times = [1.0, 1.0 + 1e6, 2.0 + 1e6]
    made = driven(turns=[1.0, 1.0, 2.0], times=times, points=28, hold_scale=1e-2)
    held = made.time[9:19] - 1.0
    np.testing.assert_allclose(np.diff(np.log1p(held / 1e-2)), np.log1p(1e8) / 9.0, rtol=1e-6)


def test_histograms_are_counted_each_time_the_slider_is_there() -> None:
    held = {"turns": [1.0, 1.0, 3.0, 1.0], "times": [2.0, 10.0, 11.0, 11.5], "points": 13}
    for drive, eq, points in (
        ({"turns": [2.0, 0.0], "points": 41}, {"histograms": [1.0, 2.0]}, [10, 20, 30]),
        (held, {"histograms": [1.0]}, [3, 6, 12]),
        (held, {"histograms": [3.0], "histogram_times": [11.0, 10.0, 14.0 / 3.0]}, [4, 6, 9]),
    ):
        assert toolkit.load_scene(scene(drive=drive, eq=eq)).histogram_points().tolist() == points


def test_a_spring_of_a_surface_says_its_unit() -> None:
    def pulled(law: Any = ROUGH, **drive: Any) -> Any:
        return toolkit.load_scene(scene(law, drive={"to": 1e-9, "points": 5, **drive}))

    interface = pulled().contacts.interface
    each = interface.contact_density * interface.mean_stiffness
    assert pulled(spring="0.5 N_c<k>").drive.spring == 0.5
    assert pulled(spring="50 N/m", area=1e-4).drive.spring == pytest.approx(50.0 / (each * 1e-4))
    with pytest.raises(InputError, match="spring = '50 N/m': precision takes a rigid slider"):
        pulled(spring="50 N/m", area=1e-4).only_forward("precision")
    few = {"to": 1e-7, "points": 5, "spring": "50 N/m", "area": 1e-10}
    told = toolkit.run(scene(ROUGH, drive=few)).master.regime.reason
    assert told.startswith("K = 50.00 N/m, a rigid slider as fast as the drive has K* = ")
    assert told.endswith(
        "infinitely many contacts: the area holds 9 contacts; run [eq] contacts = 9"
    )
    followed = toolkit.run(scene(ROUGH, drive=few, eq={"contacts": 9, "replicas": 2}))
    assert followed.eq.contacts == 18
    both = toolkit.run(scene(ROUGH, drive=few, master={}, eq={"contacts": 9, "replicas": 2}))
    assert "the area holds" not in both.master.regime.reason
    # a path on which so many contacts would break too often is to end sooner, and there they are not refused
    stiff = {"spring": "0.5 N_c<k>", "area": 1e-10, "points": 5}
    long = toolkit.run(scene(ROUGH, drive=stiff | {"to": 30.0})).master.regime.reason
    assert "over 1e+10 breaks of each slider" in long and long.endswith("run [eq] contacts = 9")
    (end,) = re.findall(r"end it at ([\d.]+) m, ", long)
    asked = toolkit.load_scene(scene(ROUGH, drive=stiff | {"to": float(end)}))
    spring = asked.drive.spring
    eq_model.Ensemble(asked.contacts, asked.path, n_contacts=9, n_replicas=2, spring=spring)
    for drive, rule in (
        ({"spring": 50.0, "area": 1e-4}, r'no unit; .*= "50 N/m" with area.* or .* = "50 N_c<k>"'),
        ({"spring": "50 N/m"}, r"^drive\.spring = '50 N/m': needs drive\.area, the nominal area"),
        ({"spring": "50 N/m", "area": 1e-16}, "area = 1e-16: holds 9.5e-06 contacts; give over"),
        ({"spring": "50"}, "must be a number and a unit"),
        (
            {"spring": "50 kN"},
            "unit kN is not known; known: N/m, N_c<k>, mN/m, kN/m, N/mm, MN/m, N/µm, N/um$",
        ),
        ({"law": GAUSSIAN, "spring": "5 N/m", "area": 1.0}, "needs <k> in N/m"),
        ({"law": GAUSSIAN, "spring": 0.5, "area": 1.0}, "drive.area = 1.0: needs <k> in N/m"),
    ):
        with pytest.raises(InputError, match=rule):
            pulled(**drive)


@pytest.mark.parametrize(
    ("key", "text", "unit"),
    [
        ("contacts.thresholds.pressure", "1 MPa", "Pa"),
        ("contacts.delay.time", "10 ms", "s where speeds are in m/s"),
        ("drive.area", "1 mm²", "m²"),
        ("drive.to", "5 nm", "the scene's unit of length, m of a surface"),
    ],
)
def test_a_unit_where_a_number_stands_alone(key: str, text: str, unit: str) -> None:
    given = re.escape(f"{key} = '{text}': must be a number alone, in {unit}; only drive.spring")
    with pytest.raises(InputError, match=f"^{given}, mass and damping take text with a unit$"):
        toolkit.load_scene(scene(ROUGH), changes={key: text})


def test_mass_and_damping_of_the_slider() -> None:
    def pulled(law: Any = ROUGH, **drive: Any) -> Any:
        own = {"to": 1e-9, "points": 5, "spring": "0.5 N_c<k>"} | drive
        tables = {name: value for name, value in own.items() if value is not None}
        return toolkit.load_scene(scene(law, drive=tables, eq={"contacts": 10}))

    interface = pulled().contacts.interface
    each = 1e-4 * interface.contact_density * interface.mean_stiffness
    given = pulled(mass="0.2 kg", damping="3 N s/m", area=1e-4).drive
    assert given.mass == pytest.approx(0.2 / each) and given.damping == pytest.approx(3.0 / each)
    for same_spring in ("0.05 kN/m", "5e-5 N/um"):
        assert (
            pulled(spring=same_spring, area=1e-4).drive.spring
            == pulled(spring="0.05 N/mm", area=1e-4).drive.spring
        )
    same = pulled(spring="0.05 N/mm", mass="200 g", damping="3 kg/s", area=1e-4).drive
    assert same.spring == pytest.approx(50.0 / each)
    assert (same.mass, same.damping) == (pytest.approx(given.mass), given.damping)
    given = pulled(mass="2e-9 N_c<k> s2", damping="1e-5 N_c<k> s").drive
    assert (given.mass, given.damping, given.slip) == (2e-9, 1e-5, None)
    one, other = (identity(pulled(GAUSSIAN, spring=0.5, mass=m)) for m in (1.0, 2.0))
    assert one != other and one != identity(pulled(GAUSSIAN, spring=0.5, mass=1.0, damping=0.1))
    for drive, rule in (
        ({"mass": 0.2, "area": 1e-4}, r'^drive\.mass = 0.2: has no unit; .*"0.2 kg" with area'),
        ({"mass": "0.2 kg"}, r"^drive\.mass = '0.2 kg': needs drive\.area"),
        (
            {"mass": "2 lb", "area": 1e-4},
            r"^drive\.mass = '2 lb': unit lb is not known; known: kg,",
        ),
        ({"mass": "0 kg", "area": 1e-4}, r"^drive\.mass = '0 kg': must be above zero"),
        (
            {"law": GAUSSIAN, "spring": 0.5, "mass": "0.2 kg"},
            r"^drive\.mass: in kg needs <k> in N/m",
        ),
        (
            {"law": GAUSSIAN, "spring": None, "mass": 0.2},
            r"^drive\.mass = 0.2: is of a soft slider",
        ),
        ({"damping": "3 N s/m", "area": 1e-4}, r"^drive\.damping = .*: is of a slider with mass"),
        (
            {"law": GAUSSIAN, "spring": 0.5, "mass": 1.0, "slip": "instant"},
            r"^drive\.slip = .*decide",
        ),
        ({"law": GAUSSIAN, "spring": 0.5, "mass": 1.0, "damping": -1.0}, r"^drive\.damping = -1.0"),
    ):
        with pytest.raises(InputError, match=rule) as caught:
            pulled(**drive)
        assert "\n" not in str(caught.value)


def test_a_soft_spring_is_stretched_far() -> None:
    """1e6 mean thresholds are little for the drive of a machine's spring, and much for a rigid slider."""
    drive, eq = {"to": 2e6, "points": 5, "spring": 1e-6}, {"contacts": 10}
    assert toolkit.load_scene(scene(drive=drive, eq=eq)).drive.spring == 1e-6
    assert foreseen(toolkit.load_scene(scene(drive=drive))) == []
    (note,) = foreseen(toolkit.load_scene(scene(drive=drive | {"to": 4e6, "spring": 1.0})))
    assert "in that unit?" in note
    del drive["spring"]
    with pytest.raises(InputError, match=r"drive: goes as far as 2e\+06 mean thresholds"):
        toolkit.load_scene(scene(drive=drive, eq=eq))


def test_fewer_contacts_than_the_area_holds_change_slips_alone() -> None:
    """Without a spring contacts are independent, and nothing is said of their number."""
    eq = {"contacts": 1000}
    for spring in (None, "50 N/mm"):
        drive = {"to": 5e-8, "points": 3, "area": 1e-6} | ({"spring": spring} if spring else {})
        notes = " ".join(foreseen(toolkit.load_scene(scene(ROUGH, drive=drive, eq=eq))))
        assert "N_c = " in notes and ("follows 1,000 contacts" in notes) == (spring is not None)
    # with the load, by which an area in another unit is seen, in newtons whatever the units of forces
    wide = scene(ROUGH, drive={"to": 5e-8, "points": 3, "area": 1.0}) | {"units": "N_c<k>"}
    told = [note for note in foreseen(toolkit.load_scene(wide)) if note.startswith("N_c = ")]
    assert re.search(r"and N_c<k> = \S+ N/m, under \S+ [MGk]?N, on drive.area = 1 m²$", told[0])


def test_files_dicts_and_names(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(to_toml(scene()))
    for given in (file, str(file)):
        found = toolkit.load_scene(given)
        assert found.name == "mine" and found.text == to_toml(scene())
    odd = scene(title='quotes " and \\ and é', drive={"to": 1e16, "points": 3, "spring": 1e-8})
    assert tomllib.loads(toolkit.load_scene(odd).text) == odd  # a dict is kept as TOML
    numbers = toolkit.load_scene(scene(drive={"to": np.float64(2.0), "points": np.int64(3)}))
    assert numbers.path.tolist() == [0.0, 1.0, 2.0]
    (tmp_path / "broken.toml").write_bytes(b"\xff\xfe")
    for wrong, told in (
        ("gausian", r"^scene = 'gausian': .* did you mean gaussian or .*\? `mesofriction "),
        (tmp_path / "min.toml", r"no shipped scene; did you mean .*mine\.toml"),
        (tmp_path / "broken.toml", "is no text in UTF-8; name another file"),
        (tmp_path, "is a folder; name a file in it"),
        (3, r"^scene = 3: must be a dict"),
        (
            scene(GAUSSIAN | {"std": object()}),
            r"^contacts\.thresholds\.std = .*: a scene holds numbers",
        ),
    ):
        with pytest.raises(InputError, match=told):
            toolkit.load_scene(wrong)


# -- every key of shipped scenes with a value it cannot have --------------------------------------------

WRONG = ("yes", True, 0, -5.0, math.nan, math.inf, 1e300, 1e-300, 10**30, [], {}, [math.nan])
ONE_OF_EACH = ["ageing", "growing-grains", "kinetic-force", "reforming", "stick-slip", "two-peaks"]


def places(table: dict[str, Any] | list[Any]) -> Iterator[list[Any]]:
    """The way to every key, of tables in lists too, and to the first item of every list."""
    for key, value in table.items() if isinstance(table, dict) else list(enumerate(table))[:1]:
        yield [key]
        if isinstance(value, dict | list):
            yield from ([key, *rest] for rest in places(value))


@pytest.mark.parametrize(
    ("name", "each"),
    [*((name, 1) for name in ONE_OF_EACH), ("rough-gw-mixed", 8), slow("rough-gw-mixed", 1)],
)
def test_what_cannot_be_is_one_line_that_names_its_key(name: str, each: int) -> None:
    """Of a surface, which is made anew each time, every key has one in eight of the wrong values, in turn."""
    tables = tomllib.loads((SHIPPED / f"{name}.toml").read_text())
    if name == "rough-gw-mixed":
        tables["contacts"]["thresholds"]["surface"]["shape"] = [16, 16]
        warm = {"law": "soft", "temperature": {"kelvin": 300.0}, "attempt_frequency": 1e12}
        tables["contacts"]["thermal"] = warm
    if name == "reforming":
        held = {"turns": [2.0, 2.0, 4.0], "times": [2.0, 102.0, 104.0], "hold_scale": 0.1}
        tables["drive"] = held | {"points": 31}
    toolkit.load_scene(tables)
    for turn, way in enumerate(places(tables)):
        # the drive and the solvers of a surface are those of the other scenes
        wrong_here = WRONG[turn % each :: each]
        for value in wrong_here if name in ONE_OF_EACH or way[0] == "contacts" else ():
            at = wrong = copy.deepcopy(tables)
            for key in way[:-1]:
                at = at[key]
            at[way[-1]] = value
            told = ""
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    toolkit.load_scene(wrong)
                except InputError as error:
                    told = str(error)
            assert "\n" not in told and len(told) < 400, (way, value, told)
            if isinstance(value, float) and math.isnan(value):  # nothing takes it
                assert str(way[0] if isinstance(way[-1], int) else way[-1]) in told, (way, told)


def test_an_unknown_kind_is_no_stiffness_that_is_not_known(tmp_path: Path) -> None:
    """The kind "gw" of a rough surface is none; beside a spring in N/m its <k> was said to be missing."""
    file = tmp_path / "mine.toml"
    file.write_text(
        '[contacts]\nthresholds = { kind = "gw" }\n[drive]\nto = 1.0\nspring = "50 N/m"\narea = 1e-6\n'
    )
    with pytest.raises(InputError, match=r"^contacts\.thresholds\.kind = 'gw': must be one of"):
        toolkit.load_scene(str(file), solved=False)
