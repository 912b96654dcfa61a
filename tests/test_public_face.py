"""What users have: names, commands, keys and kinds of scenes; what is imported for it, and what is not."""

import json
import re
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from conftest import ended

from toolkit.command import COMMANDS
from toolkit.scene import laws, tables
from toolkit.scene.scene import shipped_scenes

NAMES = {
    "origins": "Ageing Bootstrapped Contacts Delay DomainSamples Drive GrainContact GrainGrowth InputError "
    "Interface Material PowerLaw RelaxedBarrier SpectralMoments Start Substrate Thermal "
    "Thresholds barrier boltzmann_reforming bootstrap bootstrap_laws circular_island "
    "column_stiffness continuous_mixture domains film_growth fourier_substrate from_moments "
    "from_samples from_topography gaussian gaussian_start grains growing_grains gw_elastic "
    "gw_gaussian gw_plastic harmonic_bonds hexagonal_island hexagonal_substrate identical "
    "irregular_island lubricated mindlin_stiffness mixture moments_of_spectrum moments_of_summits "
    "persson pressure_of_separation rectangular rectangular_island relaxed_barrier "
    "resolution_study self_affine_surface separation_of_pressure sound_stiffness spectral_moments "
    "square_island square_substrate structure_factors substrate_calculator triangular_barrier "
    "triangular_island triangular_structure_factors",
    "eq_model": "Ensemble EnsembleResult simulate",
    "master": "CriticalVelocity DecoherenceSpectrum KineticCurve PhaseLine Propensity Solution SteadyState "
    "critical_velocity decoherence_spectrum kinetic_curve phase_line propensity solve "
    "steady_state",
    "toolkit": "__version__ load load_scene plot run save",
}
KEYS = {
    "ContactsTable": "thresholds strengthening start thermal ageing delay reforming stiffness",
    "DriveTable": "points to from turns times hold_scale velocity spring mass damping slip area",
    "EqTable": "contacts replicas seed tolerance wall_time histograms histogram_times",
    "MasterTable": "tolerance",
    "RangeTable": "from to points spacing",
    "SceneTable": "contacts drive title master eq sweep",
    "SweepTable": "velocity temperature kelvin rate delay critical_spring",
}
KINDS = {
    "thresholds": "identical gaussian rectangular mixture gw-elastic gw-plastic gw-gaussian persson lubricated "
    "grains growing-grains domains from-samples from-topography",
    "start": "identical gaussian",
    "reforming": "identical gaussian boltzmann",
    "surfaces": "scan self-affine spectrum summits",
    "stiffnesses": "sound mindlin column power-law",
    "islands": "triangular square rectangular hexagonal circular irregular",
    "substrates": "square hexagonal fourier",
}
REST = {
    "commands": "run thresholds compare precision scenes",
    "scenes": "ageing ageing-paper delay friction-loop gaussian grains growing-grains gw-elastic "
    "gw-gaussian gw-gaussian-mixed gw-plastic identical kinetic-force lubricated one-peak persson "
    "persson-wide rectangular reforming rotated-domains rough-gw-amontons rough-gw-mixed "
    "rough-gw-paper rough-gw-strength rough-persson-amontons rough-persson-paper samples "
    "slide-hold-slide stick-slip thermal-paper thermal-soft two-peaks",
}


@pytest.mark.parametrize("room", NAMES)
def test_public_names_are_there(room: str) -> None:
    module = import_module(room)
    assert [name for name in NAMES[room].split() if not hasattr(module, name)] == []
    assert set(NAMES[room].split()) <= set(module.__all__)


@pytest.mark.parametrize("table", KEYS)
def test_keys_of_scenes_are_there(table: str) -> None:
    assert set(KEYS[table].split()) <= set(getattr(tables, table).__struct_encode_fields__)


def test_kinds_commands_and_shipped_scenes_are_there() -> None:
    for name, kinds in KINDS.items():
        assert set(kinds.split()) <= set(getattr(laws, name.upper()))
    assert set(REST["commands"].split()) <= set(COMMANDS)
    assert set(REST["scenes"].split()) <= set(shipped_scenes())


# -- imports ---------------------------------------------------------------------------------------

HEAVY = ["numba", "ase", "mpi4py", "matplotlib", "SurfaceTopography", "scipy.stats", "h5py"]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """By what was done, one after another in one process: the modules that are there then."""
    code = """
import json, sys, tomllib
told = {}
def done(name):
    told[name] = sorted(sys.modules)
from toolkit.command import main
for words in ("--help", "--version", "run --help"):
    try:
        main(words.split())
    except SystemExit:
        done(words)
import origins
done("origins")
from toolkit import commands
done("commands")
laws = [origins.gaussian(1.0, 0.1, form='paper', upper=3.0), origins.from_samples([0.5, 1.0, 1.5])]
law = origins.mixture(laws, [0.5, 0.5])
law.isf(law.sf([0.5, 1.0])); law.std(); law.rvs(3)
done("laws")
import eq_model, master, toolkit
done("rooms")
from toolkit.scene.scene import SHIPPED
for name in ("gaussian", "thermal-soft", "growing-grains", "stick-slip", "samples", "kinetic-force"):
    tables = tomllib.loads((SHIPPED / f"{name}.toml").read_text())
    tables.pop("eq", None)
    assert toolkit.run(tables).success
    done(name)
print(json.dumps(told))
"""
    done = ended([sys.executable, "-c", code], tmp_path_factory.mktemp("empty"))
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_help_imports_no_package_and_what_is_not_named_is_not_imported(told: Any) -> None:
    for name, modules in told.items():
        assert not set(HEAVY) & set(modules), name
        if name.startswith(("--", "run")):
            assert not {"numpy", "scipy", "msgspec", "origins"} & set(modules)
        parts = ["interpolate", "integrate", "sparse", "signal"]
        parts += ["special"] if name != "laws" else []
        if name in ("origins", "commands", "laws"):
            assert not {f"scipy.{part}" for part in parts} & set(modules)


@pytest.mark.parametrize("room", ["origins", "eq_model", "master"])
def test_rooms_keep_their_arrows(room: str) -> None:
    """Origins imports no other room; the two solvers import it alone, and never each other, in functions neither."""
    rooms = r"^ *(?:from|import) (origins|eq_model|master|toolkit)\b"
    files = (Path(__file__).parents[1] / room).rglob("*.py")
    found = {name for file in files for name in re.findall(rooms, file.read_text(), re.MULTILINE)}
    assert found == {"origins", room}
