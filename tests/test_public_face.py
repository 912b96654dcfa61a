"""Nothing that users of version 0.1.0 have is lost: public names, commands, the keys and kinds of scenes."""

from importlib import import_module

import pytest

from toolkit.command import COMMANDS
from toolkit.scene import laws, tables
from toolkit.scene.scene import shipped_scenes

NAMES = {
    "origins": "Ageing Bootstrapped Contacts Delay DomainSamples Drive GrainContact GrainGrowth "
    "InputError Interface Material PowerLaw RelaxedBarrier SpectralMoments Start "
    "Substrate Thermal Thresholds barrier boltzmann_reforming bootstrap bootstrap_laws "
    "circular_island column_stiffness continuous_mixture domains film_growth "
    "fourier_substrate from_moments from_samples from_topography gaussian gaussian_start "
    "grains growing_grains gw_elastic gw_gaussian gw_plastic harmonic_bonds "
    "hexagonal_island hexagonal_substrate identical irregular_island lubricated "
    "mindlin_stiffness mixture moments_of_spectrum moments_of_summits persson "
    "pressure_of_separation rectangular rectangular_island relaxed_barrier "
    "resolution_study self_affine_surface separation_of_pressure sound_stiffness "
    "spectral_moments square_island square_substrate structure_factors "
    "substrate_calculator triangular_barrier triangular_island "
    "triangular_structure_factors",
    "eq_model": "Ensemble EnsembleResult simulate",
    "master": "CriticalVelocity DecoherenceSpectrum KineticCurve PhaseLine Propensity Solution "
    "SteadyState critical_velocity decoherence_spectrum kinetic_curve phase_line "
    "propensity solve steady_state",
    "toolkit": "__version__ load load_scene plot run save",
}
KEYS = {
    "ContactsTable": "thresholds start thermal ageing delay reforming stiffness",
    "DriveTable": "points to from turns times hold_scale velocity spring slip",
    "EqTable": "contacts replicas seed tolerance wall_time histograms histogram_times",
    "MasterTable": "tolerance",
    "RangeTable": "from to points spacing",
    "SceneTable": "contacts drive title master eq sweep",
    "SweepTable": "velocity temperature kelvin rate delay critical_spring",
}
KINDS = {
    "thresholds": "identical gaussian rectangular mixture gw-elastic gw-plastic gw-gaussian persson "
    "lubricated grains growing-grains domains from-samples from-topography",
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
    "gw-gaussian gw-gaussian-mixed gw-plastic identical kinetic-force lubricated one-peak "
    "persson persson-wide rectangular reforming rotated-domains rough-gw-amontons rough-"
    "gw-mixed rough-gw-paper rough-gw-strength rough-persson-amontons rough-persson-paper "
    "samples slide-hold-slide stick-slip thermal-paper thermal-soft two-peaks",
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
    known = {
        "thresholds": laws.THRESHOLDS,
        "start": laws.START,
        "reforming": laws.REFORMING,
        "surfaces": laws.SURFACES,
        "stiffnesses": laws.STIFFNESSES,
        "islands": laws.ISLANDS,
        "substrates": laws.SUBSTRATES,
    }
    for name, kinds in KINDS.items():
        assert set(kinds.split()) <= set(known[name])
    assert set(REST["commands"].split()) <= set(COMMANDS)
    assert set(REST["scenes"].split()) <= set(shipped_scenes())
