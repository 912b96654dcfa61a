"""Scenes of islands: structures from files, islands whose atoms follow, what their peaks do, and a picture."""

from pathlib import Path

import ase.io
import numpy as np
import pytest
from scipy import stats
from scipy.optimize import brentq

import origins
import toolkit
from origins.errors import InputError
from toolkit.scene.interfaces import longest_slip, of_islands
from toolkit.scene.scene import load_scene

SMALL = {"kind": "triangular", "lattice_constant": 2.5, "n_i": 2, "n_j": 2}


def scene(**table: object) -> dict:
    thresholds = {"kind": "domains", "stiffness": 1.0, "samples": 200, **table}
    return {
        "contacts": {"thresholds": thresholds},
        "drive": {"to": 0.5, "points": 6},
        "eq": {"contacts": 1000, "replicas": 1, "seed": 1},
    }


def thresholds_of(**table: object) -> origins.Thresholds:
    return load_scene(scene(**table), solved=False).contacts.thresholds


@pytest.mark.parametrize("ending", ["xyz", "cif", "vasp"])
def test_any_structure_that_ase_reads(tmp_path: Path, ending: str) -> None:
    island = origins.triangular_island(2.5, 5, 4)
    island.numbers[:] = 18
    island.set_cell([30.0, 30.0, 10.0])
    ase.io.write(tmp_path / f"island.{ending}", island)
    table = {"kind": "file", "file": str(tmp_path / f"island.{ending}")}
    law = thresholds_of(island=table)
    same = origins.domains(2.5, sizes=[(5, 4)], stiffness=1.0, samples=200)
    assert law.mean() == pytest.approx(same.mean(), rel=1e-6)
    assert law.domains.n_atoms[0] == 20


def test_islands_whose_atoms_follow() -> None:
    rigid = origins.triangular_barrier(2.5, 2, 2, 0.3)
    soft = thresholds_of(island=SMALL, bonds=5.0, angles=[0.3]).domains.barriers
    stiff = thresholds_of(island=SMALL, bonds=200.0, angles=[0.3]).domains.barriers
    assert np.array_equal(soft, np.tile(soft[:1], 200))
    assert 5.0 * abs(stiff[0] - rigid) < abs(soft[0] - rigid)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            {"island": {"kind": "file", "file": "no.xyz"}},
            r"island.file = 'no.xyz': no such file in",
        ),
        (
            {"island": {"kind": "file", "file": __file__}},
            r"island.file = .*: is no structure that ASE reads",
        ),
        ({"island": {"kind": "file", "file": 3}}, r"island.file = 3: must be a name"),
        ({"island": SMALL, "bonds": 0.0, "angles": [0.0]}, r"bonds = 0.0: must be above zero"),
        (
            {"island": SMALL, "bonds": 1.0},
            r"bonds = 1.0: makes islands of your own flexible, at listed",
        ),
        (
            {"sizes": [[2, 2]], "lattice_constant": 2.5, "bonds": 1.0, "angles": [0.0]},
            r"bonds = 1.0: makes",
        ),
    ],
)
def test_refusals(table: dict, message: str) -> None:
    with pytest.raises(InputError, match=rf"^contacts.thresholds.{message}") as caught:
        thresholds_of(**table)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("spring", [1.0, 10.0, 100.0])
def test_the_slip_at_a_peak_in_closed_form(spring: float) -> None:
    """P_c = 1/(2 (1 - x)^(1/2)): int_0^X x P_c = 2/3 - (1 - X)^(1/2) (X + 2)/3, and the slip ends beyond 1."""
    onset = brentq(lambda x: 0.5 * x - (1.0 + spring) * np.sqrt(1.0 - x), 0.0, 1.0)
    end = onset + np.sqrt(1.0 - onset) * (onset + 2.0) / 3.0 / (1.0 + spring)
    law = origins.mixture([stats.beta(1, 0.5)], [1.0])
    assert longest_slip(law, np.ones(1), spring) == pytest.approx(
        end - onset, rel=1e-2
    )  # told to two digits


def test_the_result_says_what_peaks_do_and_draws_the_barriers(tmp_path: Path) -> None:
    result = toolkit.run(scene(island=SMALL))
    assert sum("K* is infinite" in note and "K = 100 N<k>" in note for note in result.notes) == 1
    toolkit.save(result, tmp_path / "out")
    assert (tmp_path / "out" / "barriers.png").stat().st_size > 10_000
    smoothed = thresholds_of(lattice_constant=2.5, mean_atoms=20.0)
    assert "K* hangs on the smoothing" in of_islands(smoothed)[0]
    assert of_islands(thresholds_of(island=SMALL, angles=[0.1, 0.2])) == []
    assert of_islands(origins.gaussian(1.0, 0.1)) == []
