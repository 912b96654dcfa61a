"""The page on rough surfaces says what the code says."""

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import origins
import toolkit
from origins.greenwood_williamson import critical_compression
from origins.quadrature import gauss, panel_edges

DOCS = Path(__file__).parent.parent / "docs"
PAGE = (DOCS / "rough-surfaces.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("rough_surfaces", DOCS / "rough_surfaces.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # a dataclass looks its module up
    sys.modules["rough_surfaces"] = module
    spec.loader.exec_module(module)
    return module


def test_table_and_picture_are_the_scripts(script: ModuleType, tmp_path: Path) -> None:
    found = script.readings()
    for line in script.table(found):
        assert line in PAGE.splitlines()
    script.draw(found, tmp_path / "again.png")
    assert (tmp_path / "again.png").stat().st_size > 50_000 and script.PICTURE.is_file()
    by_name = {reading.name: reading.propensity.critical_spring for reading in found}
    assert by_name["GW, strength"] / by_name["GW, amontons"] == pytest.approx(90, rel=0.03)
    assert by_name["GW, amontons, mixed"] / by_name["GW, amontons"] == pytest.approx(200, rel=0.03)
    for law in ("amontons", "paper"):
        assert 30 < by_name[f"Persson, {law}"] / by_name[f"GW, {law}"] < 40


def test_numbers_in_the_text() -> None:
    laws = {name: toolkit.load_scene(f"rough-{name}").contacts.thresholds for name in ("gw-amontons", "gw-mixed")}
    laws["persson"] = toolkit.load_scene("rough-persson-amontons").contacts.thresholds
    i = {name: law.interface for name, law in laws.items()}
    assert f"{i['gw-amontons'].area_fraction:.2%}" == "0.96%" and f"{i['persson'].area_fraction:.2%}" == "0.92%"

    def lighter(name: str, share: float) -> float:
        force, law = i[name].force_law, laws[name]
        goal = share * i[name].mean_force_threshold
        x = force.below.inverse(goal)
        assert x < force.at
        return float(law.cdf(x))

    assert lighter("gw-amontons", 0.1) == pytest.approx(0.2, abs=0.01) and lighter("persson", 0.1) < 0.01
    assert f"{i['gw-mixed'].plasticity_index:.1f}" == "8.5"
    assert i["gw-mixed"].plastic_fraction == pytest.approx(0.25, abs=0.01)
    for name, share in (("gw-mixed", 0.62), ("gw-amontons", 0.003)):
        law, interface = laws[name], i[name]
        moments, material = interface.moments, interface.material
        limit = critical_compression(moments.summit_radius, material.contact_modulus, material.hardness)
        # of the load, which is f_s over mu: what contacts bear that are compressed beyond the limit
        edges = panel_edges(law)
        edges = np.unique(np.append(edges, start := float(law._forward(limit))))
        x, weights = gauss(edges[:-1], edges[1:])
        force = weights * law.pdf(x) * interface.force_threshold(x)
        beyond = force[x > start].sum() / force.sum()
        assert float(f"{beyond:.{2 if beyond > 0.1 else 1}g}") == share


def test_the_example_runs() -> None:
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert code is not None
    space: dict[str, object] = {}
    exec(code[1], space)
    law = space["pc"]
    assert isinstance(law, origins.Thresholds) and law.interface is not None
    assert law.interface.separation == pytest.approx(space["h0"], rel=1e-12) and law.interface.cautions == ()
    assert isinstance(space["rough"], origins.SpectralMoments) and 0.05 < space["rough"].rms_slope < 0.5
