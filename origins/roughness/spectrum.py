"""Spectral moments of a surface from its power spectrum (paper, Eq. PcPersson2)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.special import exprel

from origins.errors import finite_array, refuse
from origins.roughness.power_law import Array
from origins.roughness.spectral_moments import SpectralMoments


def moments_of_spectrum(
    wavevectors: npt.ArrayLike, power: npt.ArrayLike, convention: str = "isotropic"
) -> SpectralMoments:
    """Profile moments m0, m2, m4 of an isotropic surface from its power spectrum (paper, Eq. PcPersson2).

    Between two points the spectrum is the power law through both, integrated exactly; beyond the first and the last
    it is zero. h'_rms² = 2 m2 and m4 depend mostly on the largest wavevectors: state where the spectrum was cut.

    Parameters
    ----------
    wavevectors : array of shape (n,), n >= 2
        q = 2 pi/wavelength in 1/m, rising, above zero.
    power : array of shape (n,)
        Above zero; leave empty bins out.
    convention : "isotropic" or "profile"
        "isotropic", in m⁴: C(q) = ∫ d²x <h(x)h(0)> e^(-iqx), the paper's, so that <h²> = ∫ q C dq/(2 pi); then
        m2 = ∫ q³ C dq/(4 pi), which is the paper's R, and m4 = (3/8) ∫ q⁵ C dq/(2 pi). Spectra with the factor
        1/(2 pi)² in their definition, like Persson's, must be multiplied by (2 pi)².
        "profile", in m³: C(q) = ∫ dx <h(x)h(0)> e^(-iqx) of line scans, so that m_n = ∫_0 q^n C dq/pi.

    Raises InputError for arrays that are not these.
    """
    q, c = finite_array("wavevectors", wavevectors), finite_array("power", power)
    if q.size < 2:
        refuse("wavevectors", wavevectors, "must hold at least two points")
    if c.size != q.size:
        refuse("power", c, f"must hold one value for each of the {q.size} wavevectors")
    for name, values in (("wavevectors", q), ("power", c)):
        bad = np.flatnonzero(values <= 0.0)
        if bad.size:
            refuse(f"{name}[{bad[0]}]", values[bad[0]], "must be above zero; leave empty bins out")
    fallen = np.flatnonzero(np.diff(q) <= 0.0)
    if fallen.size:
        refuse(f"wavevectors[{fallen[0] + 1}]", q[fallen[0] + 1], "must rise from point to point")
    if convention == "isotropic":
        m0, m2, m4 = (_integral(q, c, n + 1) / (2.0 * np.pi) for n in (0, 2, 4))
        # averages of cos² and of cos⁴ over all directions
        m2, m4 = m2 / 2.0, 3.0 * m4 / 8.0
    elif convention == "profile":
        m0, m2, m4 = (_integral(q, c, n) / np.pi for n in (0, 2, 4))
    else:
        refuse("convention", convention, 'must be "isotropic" (m⁴) or "profile" (m³)')
    return SpectralMoments(m0=m0, m2_axes=(m2, m2), m4_axes=(m4, m4))


def _integral(q: Array, c: Array, order: int) -> float:
    """Integral of q^order C(q), C a power law between neighbours."""
    rise = np.log(q[1:] / q[:-1])
    step = np.log(c[1:] / c[:-1]) + (order + 1) * rise
    return float((c[:-1] * q[:-1] ** (order + 1) * rise * exprel(step)).sum())
