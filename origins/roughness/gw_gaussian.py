"""Greenwood-Williamson thresholds for Gaussian heights, without units (paper, Sec. VI A)."""

import numpy as np

from origins.errors import between, finite, one_of, positive, refuse
from origins.roughness.greenwood_williamson import REGIMES, compressions
from origins.roughness.power_law import Bend, PowerLaw
from origins.thresholds.law import Thresholds
from origins.thresholds.powered import Powered

# b of x_s ~ delta^b, elastic and plastic, for k ~ A^(1/2)
EXPONENTS = {"paper": (0.75, 0.5), "amontons": (1.0, 0.5), "strength": (0.5, 0.5)}
_DEEPEST, _HIGHEST = -1e3, 1e6
_SHORTEST, _LONGEST = 1e-150, 1e150  # lengths whose squares are still finite


def gw_gaussian(
    separation: float,
    scale: float,
    law: str = "paper",
    regime: str = "elastic",
    plasticity_index: float | None = None,
) -> Thresholds:
    """Summits of Gaussian heights under a flat: S(x) = Phi_c[(h0 + delta(x))/sigma_h]/Phi_c[h0/sigma_h].

    A contact compressed by delta breaks at x_s = scale (delta/sigma_h)^b:

        law         elastic   plastic
        paper        3/4       1/2
        amontons      1        1/2
        strength     1/2       1/2

    Light load, h0 >> sigma_h, is the exponential case, S(x) = exp[-(h0/sigma_h)(x/scale)^(1/b)] up to
    (sigma_h/h0)²: the paper's law gives (GW3) and (GW4), gw_elastic and gw_plastic with B = h0/sigma_h/scale^(1/b).

    Parameters
    ----------
    separation : float
        h0/sigma_h, from the summits' mean plane, from -1e3 to 1e6. Below 0 the load is heavy; below about -3 every
        summit touches, and the model hardly applies. separation_of_pressure finds it from a load.
    scale : float
        Threshold of a contact compressed by sigma_h, a length, from 1e-150 to 1e150.
    law : "paper", "amontons" or "strength"
        As in from_topography.
    regime : "elastic", "plastic" or "mixed"
        "mixed": contacts compressed beyond sigma_h (9 pi/(4 psi))², where Hertz' mean pressure is the hardness, are
        plastic. x_s is continuous there; P_c jumps up, by 3/2 under the law "paper" and by 2 under "amontons".
    plasticity_index : float
        psi = (E*/Y)(sigma_h/r)^(1/2), Y = H/3; needed for the regime "mixed", and only there.

    Raises InputError for values outside these. For summits in metres and newtons see from_moments.
    """
    z = finite("separation", separation)
    if not _DEEPEST <= z <= _HIGHEST:
        refuse(
            "separation",
            separation,
            f"is h0/sigma_h and must lie between {_DEEPEST:g} and {_HIGHEST:g}",
        )
    scale = between("scale", scale, _SHORTEST, _LONGEST, "choose another unit of length")
    elastic, plastic = EXPONENTS[one_of("law", law, tuple(EXPONENTS))]
    if one_of("regime", regime, REGIMES) != "mixed":
        if plasticity_index is not None:
            refuse(
                "plasticity_index",
                plasticity_index,
                'belongs to regime = "mixed" alone; leave it out',
            )
        return Powered(
            compressions(1.0, z), PowerLaw(scale, elastic if regime == "elastic" else plastic)
        )
    if plasticity_index is None:
        refuse(
            "plasticity_index",
            plasticity_index,
            'regime = "mixed" needs it, such as plasticity_index = 5.0',
        )
    with np.errstate(over="ignore"):
        at = float(np.float64(2.25 * np.pi / positive("plasticity_index", plasticity_index)) ** 2)
    if not 0.0 < at < np.inf:
        return gw_gaussian(z, scale, law, "plastic" if at == 0.0 else "elastic")
    # `scale` is the coefficient of the part that includes delta = sigma_h
    other = scale * at ** (elastic - plastic if at > 1.0 else plastic - elastic)
    first, second = (scale, other) if at > 1.0 else (other, scale)
    return Powered(
        compressions(1.0, z), Bend(PowerLaw(first, elastic), PowerLaw(second, plastic), at)
    )
