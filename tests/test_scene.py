"""Scene files: what they build, and how each mistake is named."""

import copy
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import eq_model
import origins
import toolkit
from origins.errors import InputError
from toolkit.scene import laws
from toolkit.scene.tables import to_toml

SCENE: dict[str, Any] = {
    "title": "test",
    "contacts": {
        "thresholds": {"kind": "gaussian", "mean": 1.0, "std": 0.05},
        "start": {"kind": "gaussian", "mean": 0.0, "std": 0.025},
    },
    "drive": {"to": 5.0, "points": 501},
    "master": {"tolerance": 1e-8},
    "eq": {"contacts": 100, "replicas": 2, "seed": 1},
}

# a call of every kind that works
MATERIAL = {"contact_modulus": 1e11, "local_friction": 0.1, "shear_modulus": 4e10}
SURFACE = {
    "kind": "self-affine",
    "shape": [64, 64],
    "pixel_size": 1e-8,
    "hurst": 0.8,
    "rms_slope": 0.1,
    "seed": 1,
}
LAWS: dict[str, dict[str, Any]] = {
    "identical": {"value": 1.5},
    "gaussian": {"mean": 1.0, "std": 0.05},
    "rectangular": {"lower": 0.5, "upper": 1.5},
    "mixture": {
        "components": [
            {"kind": "gaussian", "mean": 1.0, "std": 0.1},
            {"kind": "rectangular", "lower": 2.0, "upper": 3.0},
        ],
        "weights": [0.25, 0.75],
    },
    "gw-elastic": {"B": 1.588},
    "gw-plastic": {"B": 1.251},
    "gw-gaussian": {
        "separation": 1.0,
        "scale": 2.0,
        "law": "amontons",
        "regime": "mixed",
        "plasticity_index": 9.0,
    },
    "persson": {"centre": 1.0, "width": 0.5},
    "lubricated": {"width": 0.7, "power": 2.0, "decay": 1.5},
    "grains": {"alpha": 1.0, "time": 8.0, "B": 1.0, "jacobian": "paper"},
    "growing-grains": {"alpha": 1.0, "B": 1.0, "age": 4.0},
    "domains": {"lattice_constant": 3.88, "sizes": [[7, 9]], "stiffness": 1.0, "samples": 200},
    "from-samples": {"x_s": [0.9, 1.0, 1.1, 1.3]},
    "from-topography": {"model": "gw", "law": "amontons", "pressure": 1e6, "surface": SURFACE, "material": MATERIAL},
}


def changed(place: str, value: Any) -> dict[str, Any]:
    """SCENE with one key set, or taken out where value is None."""
    scene = copy.deepcopy(SCENE)
    *tables, key = place.split(".")
    table = scene
    for name in tables:
        table = table.setdefault(name, {})
    if value is None:
        del table[key]
    else:
        table[key] = value
    return scene


def with_law(law: dict[str, Any], to: float = 5.0) -> dict[str, Any]:
    return {**SCENE, "contacts": {"thresholds": law}, "drive": {**SCENE["drive"], "to": to}}


def test_every_kind_of_thresholds_has_an_example() -> None:
    assert set(LAWS) == set(laws.THRESHOLDS)


@pytest.mark.parametrize("kind", [kind for kind in LAWS if kind not in ("mixture", "from-topography")])
def test_kind_is_the_function_of_that_name(kind: str) -> None:
    built = toolkit.load_scene(with_law({"kind": kind, **LAWS[kind]})).contacts.thresholds
    direct = origins.Contacts(getattr(origins, kind.replace("-", "_"))(**LAWS[kind])).thresholds
    x = np.linspace(0.01, 3.0, 50)
    assert np.array_equal(built.sf(x), direct.sf(x))
    assert built.mean() == direct.mean()


def test_generated_surface_gives_its_thresholds() -> None:
    scene = with_law({"kind": "from-topography", **LAWS["from-topography"]}, to=5e-8)
    built = toolkit.load_scene(scene).contacts.thresholds
    direct = origins.from_topography(
        origins.self_affine_surface((64, 64), 1e-8, hurst=0.8, rms_slope=0.1, seed=1),
        1e-8,
        model="gw",
        law="amontons",
        material=origins.Material(**MATERIAL),
        pressure=1e6,
        detrend="centre",
        periodic=True,
    )
    x = direct.mean() * np.linspace(0.01, 3.0, 50)
    assert np.array_equal(built.sf(x), direct.sf(x))
    # whose contacts have a stiffness, so that kelvins are a temperature
    warm = {"thermal": {"law": "soft", "temperature": {"kelvin": 300.0}, "attempt_frequency": 1e12}}
    thermal = toolkit.load_scene(scene | {"contacts": scene["contacts"] | warm}).contacts.thermal
    assert thermal.temperature == pytest.approx(1.380649e-23 * 300.0 / direct.interface.mean_stiffness, rel=1e-14)
    # micrometres taken for metres
    law = {**scene["contacts"]["thresholds"], "surface": SURFACE | {"pixel_size": 1e-2}}
    with pytest.raises(InputError) as caught:
        toolkit.load_scene(scene | {"contacts": {"thresholds": law} | warm})
    told = str(caught.value)
    assert told.startswith("contacts.thermal.temperature.kelvin = 300.0: k_BT/<k> = ")
    assert "of <x_s>²; are the surface's lengths, <x_s> = " in told and " m, in their unit? below 1e-20 of it" in told


@pytest.mark.parametrize(
    ("file", "more"),
    [
        ("afm-10um.di", {}),
        ("confocal-88um.al3d", {"step": 2}),
        ("matrix-28um.txt", {"model": "persson", "patch_area": 1e-12, "detrend": "tilt"}),
    ],
)
def test_scan_is_found_from_the_scene_file(file: str, more: dict[str, Any], tmp_path: Path) -> None:
    data = Path(__file__).parents[2] / "shared" / "data"
    if not data.is_dir():
        pytest.skip("needs the measured surfaces")
    surface_topography = pytest.importorskip("SurfaceTopography")
    (tmp_path / file).symlink_to(data / file)
    law = {"kind": "from-topography", **LAWS["from-topography"], **more, "surface": {"kind": "scan", "file": file}}
    (tmp_path / "scan.toml").write_text(to_toml(with_law(law, to=5e-8)))
    built = toolkit.load_scene(tmp_path / "scan.toml").contacts.thresholds
    scan = surface_topography.open_topography(str(data / file)).topography(channel_index=0)
    keywords = {"model": "gw", "law": "amontons", "pressure": 1e6, "material": origins.Material(**MATERIAL), **more}
    direct = origins.from_topography(scan, **keywords)
    assert built.mean() == direct.mean() and built.moment(2) == direct.moment(2)


UNKNOWN = "cannot be read as a scan: it is in no format that SurfaceTopography knows, or cut short"


@pytest.mark.parametrize(
    ("scan", "message"),
    [
        ({"file": "none.di"}, "surface.file = 'none.di': no such file in "),
        ({"file": "text.di"}, f"surface.file = 'text.di': {UNKNOWN}"),
        ({"file": "own.txt", "unit": "nm"}, "surface.file = 'own.txt': cannot be read as a scan: Value for keyword "),
        ({"file": "bare.txt"}, "surface.file = 'bare.txt': cannot be read as a scan: `physical_sizes` could not be"),
        ({"file": "bare.txt", "channel": 1}, "surface.channel = 1: the file has 1 channel"),
        ({"file": "bare.txt", "physical_sizes": [1e-6, 1e-6]}, "surface.unit: is missing; lengths need one unit"),
        ({"file": "bare.txt", "folder": "/"}, "surface.folder = '/': unknown key; scan takes file,"),
    ],
)
def test_scan_that_is_no_surface_is_refused(scan: dict[str, Any], message: str, tmp_path: Path) -> None:
    pytest.importorskip("SurfaceTopography")
    (tmp_path / "text.di").write_text("no scan at all")
    heights = np.random.default_rng(2).random((8, 8))
    np.savetxt(tmp_path / "own.txt", heights, header="Width: 10 µm\nHeight: 10 µm\nValue units: nm")
    np.savetxt(tmp_path / "bare.txt", np.random.default_rng(1).random((8, 8)))
    law = {"kind": "from-topography", **LAWS["from-topography"], "surface": {"kind": "scan", **scan}}
    (tmp_path / "scan.toml").write_text(to_toml(with_law(law)))
    with pytest.raises(InputError) as caught:
        toolkit.load_scene(tmp_path / "scan.toml")
    assert str(caught.value).removeprefix("contacts.thresholds").removeprefix(".").startswith(message)
    assert "\n" not in str(caught.value)


AGED = {"kind": "gaussian", "mean": 2.0, "std": 0.5}


@pytest.mark.parametrize(
    ("place", "value", "says"),
    [
        ("contacts.thresholds.std", -1.0, " = -1.0: must be above zero"),
        ("contacts.thresholds.mean", "one", " = 'one': must be a number"),
        ("contacts.thresholds.width", 1.0, " = 1.0: unknown key; gaussian takes mean, std"),
        ("contacts.thresholds.mean", None, ": is missing; gaussian takes mean, std"),
        ("contacts.thresholds.kind", "gausian", " = 'gausian': must be one of identical, gau"),
        ("contacts.thresholds.kind", None, ": is missing; must be one of identical, gaussian"),
        ("contacts.thresholds", 3, ": expected table, got int"),
        ("contacts.thresholds", None, ": is missing"),
        ("contacts.start.std", -0.1, " = -0.1: must be zero or above"),
        ("contacts.delays", {"time": 1.0}, ": unknown key; known here: thresholds, start, "),
        ("contacts.delay", {}, ".time: is missing; it takes time"),
        ("contacts.thermal", {"law": "weak", "temperature": 0.1}, ".law = 'weak': must be \"soft\""),
        ("contacts.thermal", {"law": "soft", "temperature": {"kelvin": 300.0}}, ".temperature.kelvin = 300.0: needs"),
        ("contacts.ageing", {"rate": 1.0, "final": AGED | {"std": 0.0}}, ".final.std = 0.0: must be above zero"),
        ("contacts.ageing", {"rate": 1.0, "final": {"kind": "rectangular", "lower": 2.0, "upper": 3.0}}, ": a weight"),
        ("contacts.reforming", {"kind": "identical", "value": 9.0}, ": a weight of 1 lies beyond every threshold"),
        ("contacts.stiffness", "linkd", " = 'linkd': must be \"independent\" or \"linked\""),
        ("drive.to", math.inf, " = inf: must be finite"),
        ("drive.to", -5.0, " = -5.0: must be above zero; for the other way write turns = [-5]"),
        ("drive.to", True, ": expected float, got bool"),
        ("drive.turns", [2.0, "a"], "[1]: expected float, got str"),
        ("drive.points", None, ": is missing"),
        ("drive.points", 1, " = 1: must be a whole number of at least 2"),
        ("drive.points", 10.5, ": expected int, got float"),
        ("drive", None, ": is missing"),
        ("drive.slip", "instant", " = 'instant': is what a slip of a soft slider does, and without spring"),
        ("drive.times", [1.0, 2.0], " = [1.0, 2.0]: must hold one time for each of drive.turns, 1"),
        ("master.tolerance", 0.0, " = 0.0: must be above zero"),
        ("eq.contacts", 1.5, ": expected int, got float"),
        ("eq.seed", -1, " = -1: must be a whole number of at least 0"),
        ("eq.threads", 2, ": unknown key; known here: contacts, replicas, seed, tolerance, wall"),
        ("eq.wall_time", math.inf, " = inf: must be finite"),
        ("eq.histograms", [1.0, 2.005], "[1] = 2.005: is none of the path's points; near it are 2 "),
        ("eq.histogram_times", [1.0], " = [1.0]: are of a path with drive.times; without them say"),
        ("colour", "red", ": unknown key; known here: contacts, drive, title, master, eq, "),
    ],
)
def test_mistake_is_named_by_its_path(place: str, value: Any, says: str) -> None:
    with pytest.raises(InputError) as caught:
        toolkit.load_scene(changed(place, value))
    assert str(caught.value).startswith(place + says) and "\n" not in str(caught.value)


ROUGH = {"kind": "from-topography", **LAWS["from-topography"]}
SUMMITS = {"kind": "summits", "radius": 1e-6, "std": 1e-9, "density": 1e12}
ISLANDS = {"kind": "domains", "lattice_constant": 3.88, "mean_atoms": 100.0}
BENT = {"contact_modulus": 1e9, "local_friction": 0.1}
FALLING = BENT | {"contact_stiffness": {"kind": "power-law", "coefficient": 1.0, "exponent": -1.0}}
LINES = {"kind": "fourier", "wavevectors": [[1.0, 0.0]], "sines": [1.0]}


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (ROUGH | {"law": "strength"}, 'material.shear_strength: is missing; law = "strength" needs it; give the'),
        (ROUGH | {"material": {"contact_modulus": 1e9, "local_friction": 1}}, "material.shear_modulus: is missing;"),
        (ROUGH | {"material": FALLING}, "material.contact_stiffness.exponent = -1.0: must lie between 0 and 10"),
        (ROUGH | {"model": "persson"}, "patch_area: is missing; model = "),
        (ROUGH | {"pressure": 1e12}, 'or take the thresholds of model = "persson"'),
        (ROUGH | {"detrend": "tilt"}, 'write detrend = "centre"'),
        (ROUGH | {"surface": SUMMITS | {"radius": True}}, "surface.radius = true: must be a number"),
        (ROUGH | {"surface": SUMMITS | {"radius": 1e-300}}, "some of its numbers are too large or too small"),
        (ISLANDS, 'stiffness: is missing; law = "area" needs it; for lengths in units of your own write stiffness ='),
        (ISLANDS | {"sizes": [[7.0, 9.0]]}, "domains: give exactly one of sizes, such as [[10, 9]]"),
        (ISLANDS | {"stiffness": 1.0, "substrate": LINES}, "thresholds.substrate: varies in one direction only"),
        ({"kind": "mixture", "components": [1.0], "weights": [1.0]}, 'must be a list of tables, such as [{kind = "id'),
        ({"kind": "gaussian", "mean": 1.0, "std": 0.1, "form": "paper"}, "upper: is missing; form = "),
        ({"kind": "rectangular", "lower": 1.0, "upper": 1.0}, "for one value take identical, value = 1"),
    ],
)
def test_advice_can_be_written_in_the_scene(law: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        toolkit.load_scene(with_law(law, to=5e-8))
    assert message in str(caught.value)
    # no calls, no arguments as Python writes them, no values that TOML has not
    assert not re.search(r"origins\.|\b\w+=|\b[a-z_]+\([^)]|\(\d|\bNone\b|\bTrue\b|PowerLaw", str(caught.value))


CONTACT_LAWS: dict[str, Any] = {
    "thermal": {"law": "stiff", "temperature": 0.01, "attempt_frequency": 2.0},
    "ageing": {"rate": 1e-3, "final": AGED, "closure": "paper"},
    "delay": {"time": 0.2},
    "reforming": {"kind": "boltzmann", "temperature": 1e-4},
    "stiffness": "linked",
}


@pytest.mark.parametrize("name", [*CONTACT_LAWS, "turns", "times"])
def test_the_ensemble_takes_every_law_and_path(name: str) -> None:
    plain = {key: value for key, value in changed("eq.contacts", 2000).items() if key != "master"}
    scene = copy.deepcopy(plain)
    if name == "turns":
        scene["drive"] = {"turns": [1.5, -1.0, 2.0], "points": 501, "velocity": 2.0}
    elif name == "times":
        scene["drive"] = {"turns": [1.5, 1.5, 5.0], "times": [1.5, 9.0, 12.5], "points": 501}
        plain["contacts"] = scene["contacts"] = plain["contacts"] | {"delay": {"time": 2.0}}
    else:
        own = CONTACT_LAWS[name]
        scene["contacts"][name] = own | {"closure": "exact"} if name == "ageing" else own
    found, without, checked = toolkit.run(scene).eq, toolkit.run(plain).eq, toolkit.load_scene(scene)
    assert found is not None and without is not None and found.success
    drive, seed = checked.drive, {"n_contacts": 2000, "n_replicas": 2, "seed": 1}
    direct = eq_model.simulate(checked.contacts, drive.path, velocity=drive.velocity, time=drive.time, **seed)
    assert np.array_equal(found.force, direct.force) and np.array_equal(found.holding, direct.holding)
    assert np.abs(found.force - without.force).max() > 1e-3


def test_a_drive_in_time_holds_and_changes_speed() -> None:
    drive = {"turns": [1.0, 1.0, 3.0, 2.0], "times": [2.0, 10.0, 11.0, 11.5], "points": 10}
    made = toolkit.load_scene(SCENE | {"drive": drive}).drive
    # as many points to each piece, holds among them
    assert made.path.tolist() == pytest.approx([0.0, 0.5, 1.0, 1.0, 1.0, 5.0 / 3.0, 7.0 / 3.0, 3.0, 2.5, 2.0])
    assert made.time.tolist() == pytest.approx([0.0, 1.0, 2.0, 6.0, 10.0, 31.0 / 3.0, 32.0 / 3.0, 11.0, 11.25, 11.5])
    for k, time in ((0, 0.0), (1, 1.0)):
        times = [2.0, 10.0, 11.0, 11.5]
        times[k] = time
        with pytest.raises(InputError, match=rf"drive\.times\[{k}\] = {time}: must be later"):
            toolkit.load_scene(SCENE | {"drive": drive | {"times": times}})


def test_histograms_are_counted_each_time_the_slider_is_there() -> None:
    scene = SCENE | {"drive": {"turns": [2.0, 0.0], "points": 41}, "eq": {"histograms": [1.0, 2.0]}}
    assert toolkit.load_scene(scene).histogram_points().tolist() == [10, 20, 30]
    assert toolkit.load_scene(SCENE).histogram_points().size == 0
    # at rest as it begins and as it ends, and whenever it is asked for by time
    held = {"turns": [1.0, 1.0, 3.0, 1.0], "times": [2.0, 10.0, 11.0, 11.5], "points": 13}
    for eq, points in (
        ({"histograms": [1.0]}, [3, 6, 12]),
        ({"histograms": [3.0], "histogram_times": [11.0, 10.0, 14.0 / 3.0]}, [4, 6, 9]),
    ):
        assert toolkit.load_scene(SCENE | {"drive": held, "eq": eq}).histogram_points().tolist() == points
    near = r"near it are 4\.66666666667 and 7\.33333333333; all of drive\.times are"
    with pytest.raises(InputError, match=rf"^eq\.histogram_times\[1\] = 5\.0: is none of the path's points; {near}"):
        toolkit.load_scene(SCENE | {"drive": held, "eq": {"histogram_times": [2.0, 5.0]}})


def test_scene_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(to_toml(SCENE))
    for given in (file, str(file)):
        scene = toolkit.load_scene(given)
        assert scene.name == "mine" and scene.text == to_toml(SCENE)


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"a = = 1", "is not TOML: Invalid value (at line 1"), (b"\xff\xfe", "cannot be read: 'utf-8' codec")],
)
def test_broken_file_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    file = tmp_path / "broken.toml"
    file.write_bytes(content)
    with pytest.raises(InputError, match=re.escape(message)):
        toolkit.load_scene(file)


def test_unknown_name_tells_those_like_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^scene = 'gausian': .* did you mean gaussian or .*\? `mesofriction "):
        toolkit.load_scene("gausian")
    (tmp_path / "hold-100.toml").touch()
    with pytest.raises(InputError, match=r"no shipped scene; did you mean .*hold-100\.toml"):
        toolkit.load_scene(tmp_path / "hold100.toml")
    with pytest.raises(InputError, match=r"^scene = 'qq': no such file, and no shipped scene; `mesofriction scenes` "):
        toolkit.load_scene("qq")
    with pytest.raises(InputError, match=r"^scene = 3: must be a dict"):
        toolkit.load_scene(3)  # type: ignore[arg-type]


def test_dict_is_kept_as_toml_that_reads_back() -> None:
    tables = {
        "title": 'quotes " and \\ and \n and \x7f and é',
        "dotted.key": [1, 2.5, -1e-300, True, "x"],
        "inner": {"deep": {"list": [{"kind": "a", "value": 1e16}], "empty": []}, "plain": 1e-8, "none": None},
    }
    expected = copy.deepcopy(tables)
    del expected["inner"]["none"]  # type: ignore[attr-defined]
    assert tomllib.loads(to_toml(tables)) == expected
    assert toolkit.load_scene(toolkit.load_scene(SCENE)).text == to_toml(SCENE)


def test_dict_takes_numpy_numbers_and_refuses_what_toml_lacks() -> None:
    scene = toolkit.load_scene(changed("drive", {"to": np.float64(2.0), "points": np.int64(3)}))
    assert np.array_equal(scene.path, [0.0, 1.0, 2.0])
    with pytest.raises(InputError, match=r"^contacts\.thresholds\.std = .*: a scene holds numbers"):
        toolkit.load_scene(changed("contacts.thresholds.std", object()))


