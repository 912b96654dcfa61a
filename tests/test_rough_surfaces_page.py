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
from origins.roughness.greenwood_williamson import critical_compression
from origins.thresholds.quadrature import gauss, panel_edges

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

    # the patches are as large as the advice has it
    assert i["persson"].patch_area == pytest.approx(i["gw-amontons"].mean_area, rel=1e-3)

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


@pytest.mark.parametrize("law", ["amontons", "paper"])
def test_stress_above_the_hardness(law: str) -> None:
    """Persson's share of area and load above H, by sums over the stresses as (PcPersson) has them."""
    i = toolkit.load_scene(f"rough-persson-{law}").contacts.thresholds.interface
    width, hardness = i.material.contact_modulus * np.sqrt(i.moments.m2), i.material.hardness
    edges = np.unique(np.append(np.linspace(0.0, 10.0 * width, 101), hardness))
    s, weights = gauss(edges[:-1], edges[1:])
    density = weights * (np.exp(-(((s - i.pressure) / width) ** 2)) - np.exp(-(((s + i.pressure) / width) ** 2)))
    area, load = (part[edges[:-1] >= hardness].sum() / part.sum() for part in (density, s * density))
    assert i.plastic_fraction == pytest.approx(area, rel=1e-6)
    assert f"{100 * area:.1f} %\nof the area" in PAGE and f"{100 * load:.1f} % of the load" in PAGE
    assert any("plastic" in line for line in i.cautions)


@pytest.mark.parametrize(("law", "exponent"), [*(("amontons", e) for e in (1.0, 1.4, 1.5)), ("strength", 1.0)])
def test_how_steep_a_stiffness_may_be(law: str, exponent: float) -> None:
    material = origins.Material(
        contact_modulus=2e9, local_friction=0.4, shear_strength=1e7, contact_stiffness=origins.PowerLaw(1e9, exponent)
    )
    moments = origins.moments_of_summits(radius=1.1e-6, std=30e-9, density=2.1e12)
    asked = {"model": "gw", "law": law, "material": material, "pressure": 1e6}
    if (law, exponent) in (("amontons", 1.0), ("amontons", 1.4)):
        assert origins.from_moments(moments, **asked).mean() > 0.0
    else:
        with pytest.raises(origins.InputError, match=r"material\.contact_stiffness"):
            origins.from_moments(moments, **asked)


def test_the_example_runs() -> None:
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert code is not None
    space: dict[str, object] = {}
    exec(code[1], space)
    law = space["pc"]
    assert isinstance(law, origins.Thresholds) and law.interface is not None
    assert law.interface.separation == pytest.approx(space["h0"], rel=1e-12) and law.interface.cautions == ()
    assert isinstance(space["rough"], origins.SpectralMoments) and 0.05 < space["rough"].rms_slope < 0.5


def test_the_page_prints_newtons_as_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    part = PAGE.split("## In newtons")[1]
    code, shown = (re.search(rf"```{kind}\n(.*?)```", part, re.DOTALL)[1] for kind in ("python", "text"))
    exec(compile(code, "rough-surfaces.md", "exec"), {})
    assert capsys.readouterr().out == shown
