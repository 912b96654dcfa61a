"""Extremes of the origins: grains, Persson, summits, islands, surfaces, samples, averages over laws."""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import origins
from origins.contacts import Contacts
from origins.thresholds.law import Array
from toolkit.stability import truths
from toolkit.stability.case import Case, CaseAnswer, Question, Truth
from toolkit.stability.thresholds import BETWEEN, FORWARD

# moduli in Pa
POLYMER = origins.Material(contact_modulus=1.75e9, shear_modulus=1.1e9, local_friction=0.4)
MakeLaw = Callable[[], origins.Thresholds]


def cases() -> list[Case | Question]:
    return [*edges(), *islands(), *units(), *of_surfaces(), *of_samples()]


def edges() -> list[Case | Question]:
    """Origins at the ends of their range."""
    group = "ends of the origins"

    above, normal = "grains a millionth above the pinning edge", "Persson, centre/width = 1e-3"

    def just_above() -> origins.Thresholds:
        return origins.grains(2.0 / 3.0 * (1.0 + 1e-6), B=1.0)

    def narrow() -> origins.Thresholds:
        return origins.persson(1e-3, 1.0)

    def mean(name: str, origin: str, law: MakeLaw, exact: Truth) -> Question:
        def ask() -> CaseAnswer:
            return CaseAnswer(law().mean(), 1e-8 * law().mean())

        return Question(group, f"{name}: <x_s>", origin, ask, lambda: exact)

    def case(name: str, law: MakeLaw, path: Array = FORWARD, truth: Any = None) -> Case:
        return Case(group, name, lambda: Contacts(law()), path, truth)

    first_order = Truth(math.sqrt(math.pi / 2.0) * 1e-6, 2e-12, "first order above the edge")
    return [
        mean(above, "grains", just_above, first_order),
        case(above, just_above),
        case("grains at the pinning edge", lambda: origins.grains(2.0 / 3.0, B=1.0)),
        mean(normal, "persson", narrow, Truth(math.gamma(1.25), 1e-6, "a Weibull law of shape 4")),
        case(normal, narrow),
        # normal to the first order of width/centre, whose square is the rest
        case(
            "Persson, centre/width = 100",
            lambda: origins.persson(100.0, 1.0),
            BETWEEN,
            nearly_normal,
        ),
        case("Persson, centre/width = 1e9", lambda: origins.persson(1e9, 1.0)),
        case(
            "summits almost out of reach, h_0 = 40 sigma_h", lambda: origins.gw_gaussian(40.0, 1.0)
        ),
        case("summits pressed in, h_0 = -3 sigma_h", lambda: origins.gw_gaussian(-3.0, 1.0)),
    ]


def islands() -> list[Case | Question]:
    """Barriers of islands: very large ones, in valleys all but level, and as ASE moves them."""
    group = "barriers of islands"
    shallow = origins.fourier_substrate([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]], [1.0, -1e-6, 1e-6])
    square = origins.square_substrate()

    def turned(atoms: int) -> Any:
        island = origins.square_island(0.9, atoms, atoms)
        island.rotate(1.0, "z")  # degrees
        return island

    def unmoved() -> Truth:
        exact = float(origins.barrier(turned(30), 0.0, square))
        return Truth(exact, 1e-10, "structure factors")

    def moved() -> CaseAnswer:
        found = origins.relaxed_barrier(turned(30), origins.substrate_calculator(square))
        return CaseAnswer(found.barrier, found.barrier_error)

    return [
        Question(
            group,
            "ten million atoms, unrotated: the barrier",
            "triangular_barrier",
            lambda: CaseAnswer(float(origins.triangular_barrier(1.0, 10_000, 1_000, 0.0)), 1e-8),
            island,
        ),
        Question(
            group,
            "one atom, valleys 1e-6 beside each other: the barrier",
            "barrier",
            lambda: CaseAnswer(float(origins.barrier(turned(1), 0.0, shallow)), 1e-12),
            # (cos u, cos v, cos(u + v)) is (-1, 1, -1) at its lowest and (-1, -1, 1) on the way
            lambda: Truth(4e-6, 1e-15, "the energies of both places"),
        ),
        Question(
            group,
            "900 atoms that ASE moves as a whole: the barrier",
            "relaxed_barrier",
            moved,
            unmoved,
        ),
    ]


def island() -> Truth:
    """2 min(|S_x|, |S_y|) with the sums over atoms taken one by one."""
    i, j = np.arange(10_000), np.arange(1_000)
    rows = 0.5 * (j % 2)  # rows of a triangular lattice are shifted by half a constant
    along = np.exp(1j * i).sum()
    s_x = abs(along * np.exp(1j * rows).sum())
    s_y = abs(np.exp(1j * math.sqrt(0.75) * j).sum()) * i.size
    return Truth(2.0 * min(s_x, s_y), 1e-7, "the sum over all atoms")


def nearly_normal(contacts: Contacts, path: np.ndarray) -> Truth:
    """F of Persson's law at 100 widths: normal, to the square of width/centre, of the width²/(2 sqrt 2 centre)."""
    normal = Contacts(origins.gaussian(1.0, 1e-4 / math.sqrt(8.0)))
    force = truths.gaussian(normal, path / contacts.mean_threshold).values
    return Truth(force, 1e-4, "a normal law")


def units() -> list[Case | Question]:
    """Laws whose unit is far from 1, near the ends of what lengths may be."""
    return [
        Case("units", f"{law.__name__}, B = {scale:g}", partial(_of_scale, law, scale), FORWARD)
        for law in (origins.gw_elastic, origins.gw_plastic)
        for scale in (1e-60, 1e60)
    ]


def _of_scale(law: Callable[[float], object], scale: float) -> Contacts:
    return Contacts(law(scale))


def of_surfaces() -> list[Case | Question]:
    """A rough polymer, barely touching and pressed until it flattens; and heights that are all but flat, or spikes."""
    # m², slope² and 1/m² along both axes, of a surface with 1 µm of roughness, slopes of 0.1
    rough = origins.SpectralMoments(1e-12, (1e-2, 1e-2), (1e10, 1e10))
    asked = {
        f"{model}, {pressure:g} Pa": partial(_pressed, rough, model, pressure)
        for model in ("gw", "persson")
        for pressure in (1e-3, 1e5, 1e9)
    }
    asked |= {
        f"64 x 64 heights, slopes of {slope:g}": partial(_measured, slope) for slope in (1e-6, 1e3)
    }
    return [Case("surfaces", name, law, FORWARD, n_contacts=20_000) for name, law in asked.items()]


def _measured(slope: float) -> Contacts:
    heights = origins.self_affine_surface((64, 64), 1e-6, hurst=0.8, rms_slope=slope, seed=1)
    how: dict[str, Any] = {"model": "gw", "law": "amontons", "material": POLYMER, "pressure": 1e3}
    law = origins.from_topography(heights, 1e-6, detrend="centre", periodic=True, **how)
    return Contacts(law)


def _pressed(rough: origins.SpectralMoments, model: str, pressure: float) -> Contacts:
    patch = 1e-14 if model == "persson" else None  # m²
    how: dict[str, Any] = {"model": model, "law": "amontons", "material": POLYMER}
    return Contacts(origins.from_moments(rough, pressure=pressure, patch_area=patch, **how))


def of_samples() -> list[Case | Question]:
    """Samples that all but agree, or lie far apart; islands that are all alike; laws that all but agree."""
    group, near = "samples and averages", np.linspace(0.95, 1.05, 20)

    def averaged() -> Contacts:
        law = origins.continuous_mixture(lambda phi: origins.gaussian(phi, 0.05), 1.0, 1.0 + 1e-6)
        return Contacts(law)

    def merged(contacts: Contacts, path: np.ndarray) -> Truth:
        # the average moves the mean by half its width, and widens the peak by 1e-12 of itself
        one = Contacts(origins.gaussian(1.0 + 5e-7, 0.05))
        return Truth(truths.gaussian(one, path).values, 1e-11, "the merged peak")

    def alike() -> Contacts:
        how: dict[str, Any] = {"sizes": [(7, 9)], "angles": [0.0], "stiffness": 1.0}
        return Contacts(origins.domains(1.0, samples=100, **how))

    def sampled(*x_s: float) -> Contacts:
        return Contacts(origins.from_samples(x_s))

    def one_value(contacts: Contacts, path: np.ndarray) -> Truth:
        return Truth(np.mod(path, 1.0), 1e-5, "the merged value")

    far, two = partial(sampled, *near, 50.0), partial(sampled, 1.0, 1.0 + 1e-6)
    return [
        Case(group, "laws 1e-6 apart", averaged, FORWARD, merged),
        Case(group, "islands that are all alike", alike, FORWARD + 0.01, truths.sawtooth),
        Case(group, "20 samples and one 50 times as large", far, FORWARD, n_contacts=20_000),
        Case(group, "two samples 1e-6 apart", two, BETWEEN, one_value),
    ]
