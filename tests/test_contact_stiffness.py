"""How stiff a contact is: App. A, rho c² A^(1/2) and Mindlin, what they do to thresholds, and newtons and kelvin."""

import mpmath
import numpy as np
import pytest

import origins
import toolkit
from origins.thresholds.quadrature import gauss, panel_edges

MOMENTS = origins.moments_of_summits(radius=20e-6, std=0.2e-6, density=3e9)
COMMON = {"contact_modulus": 3e9, "local_friction": 0.3, "hardness": 3e8, "shear_strength": 2e7}
AREA = np.array([1e-16, 3e-13, 2e-10])


def test_the_three_laws_as_they_are_printed() -> None:
    radius = np.sqrt(AREA / np.pi)
    assert origins.sound_stiffness(1200.0, 900.0)(AREA) == pytest.approx(
        1200 * 900**2 * np.sqrt(AREA), rel=1e-14
    )
    # Mindlin: 8 a G*, 1/G* = (2 - nu_1)/G_1 + (2 - nu_2)/G_2
    reduced = 1 / ((2 - 0.3) / 1e9 + (2 - 0.45) / 8e10)
    assert origins.mindlin_stiffness((1e9, 8e10), (0.3, 0.45))(AREA) == pytest.approx(
        8 * radius * reduced, rel=1e-14
    )
    equal = origins.mindlin_stiffness(1e9, 0.3)
    assert equal(AREA) == pytest.approx(
        1e9 * np.sqrt(AREA) * 4 / ((2 - 0.3) * np.sqrt(np.pi)), rel=1e-14
    )
    assert float(equal(1.0)) / 1e9 == pytest.approx(1.33, abs=0.005)
    # the paper's "about equal" at r_c = h is 3 to 4 times rho c² A^(1/2)
    column, sound = (
        origins.column_stiffness(2.6e9, aspect=1.0),
        origins.sound_stiffness(1000.0, 1000.0),
    )
    assert column(AREA) / sound(AREA) == pytest.approx(3.46, abs=0.006)
    # a beam of moment of inertia pi r_c⁴/4, bent by a force at its free end: 3 E I/h³
    for found, height in (
        (origins.column_stiffness(2.6e9, aspect=0.4), radius / 0.4),
        (origins.column_stiffness(2.6e9, height=3e-7), 3e-7),
    ):
        assert found(AREA) == pytest.approx(
            3 * 2.6e9 * np.pi * radius**4 / 4 / height**3, rel=1e-13
        )
        assert found(AREA) == pytest.approx(
            0.75 * np.pi * 2.6e9 * radius * (radius / height) ** 3, rel=1e-13
        )


@pytest.mark.parametrize(("law", "regime"), [("amontons", "mixed"), ("strength", "elastic")])
def test_the_coefficient_sets_the_scale_and_nothing_else(law: str, regime: str) -> None:
    options = {"model": "gw", "law": law, "pressure": 3e5, "regime": regime}
    plain, mindlin = (
        origins.from_moments(MOMENTS, material=origins.Material(**COMMON, **stiffness), **options)
        for stiffness in (
            {"shear_modulus": 1e9},
            {"contact_stiffness": origins.mindlin_stiffness(1e9, 0.3)},
        )
    )
    softer = (2 - 0.3) * np.sqrt(np.pi) / 4
    q = np.array([1e-30, 0.1, 0.9])
    assert mindlin.isf(q) == pytest.approx(softer * plain.isf(q), rel=1e-12)
    one, other = plain.interface, mindlin.interface
    assert one is not None and other is not None
    assert other.mean_stiffness == pytest.approx(one.mean_stiffness / softer, rel=1e-12)
    for name in ("friction_coefficient", "mean_force_threshold", "mean_radius", "area_fraction"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-12)
    sound = origins.Material(**COMMON, contact_stiffness=origins.sound_stiffness(1000.0, 1000.0))
    assert origins.from_moments(MOMENTS, material=sound, **options).isf(q) == pytest.approx(
        plain.isf(q), rel=1e-14
    )


def test_another_power_of_the_area_shapes_the_law() -> None:
    """k = kappa A^p under Amontons: x_s ~ delta^(3/2 - p), so P_c ~ x^(1/(3/2 - p) - 1); all of it still adds up."""
    for exponent in (0.2, 1.0):
        stiff = origins.PowerLaw(1e9 * 1e-12 ** (0.5 - exponent), exponent)
        material = origins.Material(**COMMON, contact_stiffness=stiff)
        found = origins.from_moments(
            MOMENTS, model="gw", law="amontons", material=material, pressure=3e5
        )
        assert found.onset_power == pytest.approx(1 / (1.5 - exponent) - 1, abs=1e-14)
        load, area = 4 / 3 * 3e9 * np.sqrt(20e-6) * (1e-7) ** 1.5, np.pi * 20e-6 * 1e-7
        x = 0.3 * load / float(stiff(area))
        i = found.interface
        assert i is not None and i.separation is not None
        beyond = mpmath.ncdf(-(i.separation + 1e-7) / 0.2e-6) / mpmath.ncdf(-i.separation / 0.2e-6)
        assert float(found.sf(x)) == pytest.approx(float(beyond), rel=1e-11)
        adds_up(found)


def adds_up(found: origins.Thresholds) -> None:
    """<f_s> and <k> of the record are the averages of f_s(x) and of f_s(x)/x over P_c."""
    # f_s(x)/x may begin as a root of x: in x = s^4 all of it is smooth
    edges = panel_edges(found) ** 0.25
    s, weights = gauss(edges[:-1], edges[1:])
    x = s**4
    weights = weights * 4 * s**3 * found.pdf(x)
    i = found.interface
    assert i is not None
    assert i.mean_force_threshold == pytest.approx(
        float((weights * i.force_threshold(x)).sum()), rel=1e-10
    )
    assert i.mean_stiffness == pytest.approx(
        float((weights * i.force_threshold(x) / x).sum()), rel=1e-10
    )


def test_columns_of_one_height_need_contacts_of_one_area() -> None:
    """k ~ A²: a summit pressed down would break ever earlier, so it is refused; Persson's patches have one k."""
    columns = origins.column_stiffness(2.6e9, height=3e-7)
    material = origins.Material(**COMMON, contact_stiffness=columns)
    options = {"law": "amontons", "material": material, "pressure": 3e5}
    with pytest.raises(
        origins.InputError, match=r"^material\.contact_stiffness: k ~ A.*such as a column's"
    ):
        origins.from_moments(MOMENTS, model="gw", **options)
    found = origins.from_moments(MOMENTS, model="persson", patch_area=1e-12, **options)
    assert found.interface.mean_stiffness == pytest.approx(float(columns(1e-12)), rel=1e-12)


def test_kelvin_and_joules_become_the_temperature_of_a_contact() -> None:
    material = origins.Material(**COMMON, shear_modulus=1e9)
    i = origins.from_moments(
        MOMENTS, model="gw", law="amontons", material=material, pressure=3e5
    ).interface
    assert i is not None
    assert i.temperature(kelvin=300.0) == pytest.approx(
        1.380649e-23 * 300.0 / i.mean_stiffness, rel=1e-15
    )
    assert i.temperature(energy=4e-21) == pytest.approx(4e-21 / i.mean_stiffness, rel=1e-15)
    assert i.temperature(kelvin=0.0) == 0.0


def test_a_scene_names_stiffness_and_summits() -> None:
    stiffness = {"kind": "mindlin", "shear_modulus": 1e9, "poisson_ratio": 0.3}
    tables = {
        "kind": "from-topography",
        "model": "gw",
        "law": "amontons",
        "pressure": 3e5,
        "surface": {"kind": "summits", "radius": 20e-6, "std": 0.2e-6, "density": 3e9},
        "material": COMMON | {"contact_stiffness": stiffness},
    }

    def read(**changes: object) -> origins.Thresholds:
        scene = {
            "contacts": {"thresholds": tables | changes},
            "drive": {"to": 1e-7, "points": 3},
            "master": {},
        }
        return toolkit.load_scene(scene).contacts.thresholds

    material = origins.Material(**COMMON, contact_stiffness=origins.mindlin_stiffness(1e9, 0.3))
    plain = origins.from_moments(
        MOMENTS, model="gw", law="amontons", material=material, pressure=3e5
    )
    assert read().mean() == plain.mean() and read().interface == plain.interface
    spectrum = {"kind": "spectrum", "wavevectors": [1e5, 1e6, 6e7], "power": [1e-26, 1e-26, 2e-32]}
    moments = origins.moments_of_spectrum(spectrum["wavevectors"], spectrum["power"])
    assert read(surface=spectrum).interface.moments == moments
    rope = COMMON | {"contact_stiffness": {"kind": "rope"}}
    for changes, says in (
        ({"step": 2}, "step = 2: belongs to heights"),
        ({"material": rope}, "material.contact_sti"),
    ):
        with pytest.raises(origins.InputError, match=rf"^contacts\.thresholds\.{says}"):
            read(**changes)
