"""Profile spectral moments of a surface, by differences of neighbours or from its spectrum, and its summits."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy

from origins.errors import InputError, one_of, positive, positive_array, refuse, whole
from origins.roughness.surface import as_topography, detrended

# rms slope above which heights cannot be meant: of real surfaces it is below 1, rarely some 3 at the finest steps
_STEEPEST = 10.0
# zeros that look like filled gaps: at least this share of the heights, and so many times the next frequent value
_ZEROS, _ODD = 1e-3, 10.0
_BANDWIDTH_LIMIT = 0.8968  # below it McCool's summit variance is negative


@dataclass(frozen=True)
class SpectralMoments:
    """Moments of the profiles along both axes, and the summits of the isotropic Gaussian surface that has them.

    m0 : mean square height about the trend, m².
    m2_axes, m4_axes : mean square slope and curvature (1/m²) of profiles along both axes.
    m2_cross : mean product of the slopes along both axes, which is not 0 where ridges lie along a diagonal.
    step, pixel_size : pixels between the neighbours that were differenced, and their distances (m) along both axes.
    size : lengths of the scan along both axes, m; where there was no scan all three are None.
    missing_fraction, used_fraction : of the points, those missing; of the curvature stencils, those without such.
    zero_fraction : of the points, those of height exactly 0 where they are so many that gaps may be filled with 0.
    """

    m0: float
    m2_axes: tuple[float, float]
    m4_axes: tuple[float, float]
    step: int | None = None
    pixel_size: tuple[float, float] | None = None
    missing_fraction: float = 0.0
    used_fraction: float = 1.0
    size: tuple[float, float] | None = None
    zero_fraction: float = 0.0
    m2_cross: float = 0.0

    def __post_init__(self) -> None:
        if not self.bandwidth > _BANDWIDTH_LIMIT:
            hint = "a Gaussian surface has at least 1.5; remove less trend or use a larger scan"
            raise InputError(f"heights: alpha = m0 m4/m2² is {self.bandwidth:.4g}, and {hint}")

    @property
    def unevenness(self) -> float:
        """Root mean square slope along the steepest direction, over that across it; 1 where slopes are isotropic."""
        (along, across), cross = self.m2_axes, self.m2_cross
        least, most = np.linalg.eigvalsh([[along, cross], [cross, across]])
        return float(np.sqrt(most / max(least, np.finfo(float).tiny)))

    @property
    def m2(self) -> float:
        """Mean square profile slope, averaged over both axes: half the surface's."""
        return 0.5 * (self.m2_axes[0] + self.m2_axes[1])

    @property
    def m4(self) -> float:
        """Mean square profile curvature, averaged over both axes, in 1/m²."""
        return 0.5 * (self.m4_axes[0] + self.m4_axes[1])

    @property
    def rms_height(self) -> float:
        """Root mean square height about the trend, m0^(1/2), in metres."""
        return float(np.sqrt(self.m0))

    @property
    def rms_slope(self) -> float:
        """Root mean square slope of the surface, h'_rms = (2 m2)^(1/2)."""
        return float(np.sqrt(2.0 * self.m2))

    @property
    def bandwidth(self) -> float:
        """Nayak's alpha = m0 m4/m2²."""
        return self.m0 * self.m4 / self.m2**2

    @property
    def summit_radius(self) -> float:
        """Mean radius of curvature of the summits, r = 0.375 (pi/m4)^(1/2), in metres (McCool 1986)."""
        return float(0.375 * np.sqrt(np.pi / self.m4))

    @property
    def summit_density(self) -> float:
        """Summits per area, (m4/m2)/(6 pi 3^(1/2)), in 1/m² (McCool 1986)."""
        return float(self.m4 / self.m2 / (6.0 * np.pi * np.sqrt(3.0)))

    @property
    def summit_std(self) -> float:
        """Standard deviation of the summits' heights, (m0 (1 - 0.8968/alpha))^(1/2), in metres (McCool 1986)."""
        return float(np.sqrt(self.m0 * (1.0 - _BANDWIDTH_LIMIT / self.bandwidth)))

    @property
    def summit_offset(self) -> float:
        """Height of the summits' mean plane above the surface's, 4 (m0/(pi alpha))^(1/2), in metres."""
        return float(4.0 * np.sqrt(self.m0 / (np.pi * self.bandwidth)))


def moments_of_summits(radius: float, std: float, density: float) -> SpectralMoments:
    """The isotropic Gaussian surface whose summits have this radius (m), height spread (m) and density (1/m²), by
    McCool's relations. Raises InputError for values not above zero."""
    m4 = np.pi * (0.375 / positive("radius", radius)) ** 2
    m2 = float(m4 / (6.0 * np.pi * np.sqrt(3.0) * positive("density", density)))
    m0 = positive("std", std) ** 2 + _BANDWIDTH_LIMIT * m2 * m2 / m4
    return SpectralMoments(m0=float(m0), m2_axes=(m2, m2), m4_axes=(float(m4), float(m4)))


def spectral_moments(
    heights: object,
    pixel_size: object = None,
    *,
    detrend: str = "curvature",
    step: int = 1,
    periodic: bool = False,
) -> SpectralMoments:
    """Profile spectral moments m0, m2, m4 of a scan (J. McCool, Wear 107, 37, 1986), by differences of neighbours.

    Both axes are averaged over the same points: those whose differences along both contain no missing point.

    heights : metres, shape (n_x, n_y), NaN or masked where missing; or a SurfaceTopography topography, with its unit.
    pixel_size : metres, one number or (dx, dy); left out for a topography object, which has it.
    detrend : least-squares trend removed first, "curvature", "tilt" or "centre".
    step : neighbours are `step` pixels apart. m0 is the same.
    periodic : whether the surface continues on its opposite side, as generated ones do; only with detrend="centre".

    Raises InputError for a flat surface, for one too small for the step, where missing points leave less than
    half of the curvature stencils, for rms slopes above 10, as of heights in another unit, and where alpha is below
    0.8968, so that no Gaussian surface has such moments.
    """
    surface = as_topography(heights, pixel_size)
    if periodic and detrend != "centre":
        refuse("detrend", detrend, 'for a periodic surface write detrend = "centre"')
    step, shape = whole("step", step, 1), surface.heights.shape
    if min(shape) < 2 * step + 1:
        refuse("step", step, f"the scan of {shape} points needs 2 step + 1 along each axis")
    h = detrended(surface.heights, detrend)
    # what is beyond the ends of a scan is missing, too
    wide = h if periodic else np.pad(h, (0, step), constant_values=np.nan)
    behind, ahead = (np.stack([np.roll(wide, by, axis) for axis in (0, 1)]) for by in (step, -step))
    # slopes between neighbours; and about a point, at which alone those along both axes may be multiplied
    differences = (ahead - wide, ahead - 2.0 * wide + behind, 0.5 * (ahead - behind))
    # a point counts only where both axes have a difference
    slopes, curvatures, centred = (d[:, np.isfinite(d).all(axis=0)] for d in differences)
    missing = float(np.isnan(h).mean())
    used = curvatures.shape[1] / math.prod(n if periodic else n - 2 * step for n in shape)
    if used < 0.5:
        hint = f"missing points ({missing:.1%}) leave {used:.1%} of the curvature stencils, less than half"
        refuse("heights", h, f"{hint}; fill them in or cut out a part that is whole")
    dx, dy = surface.pixel_size
    apart, size = (step * dx, step * dy), (shape[0] * dx, shape[1] * dy)
    m2 = ((slopes**2).mean(axis=1) / np.square(apart)).tolist()
    cross = float(centred.prod(axis=0).mean()) / (apart[0] * apart[1])
    m4 = ((curvatures**2).mean(axis=1) / np.square(apart) ** 2).tolist()
    m0, slope = float(np.nanmean(h**2)), math.sqrt(sum(m2))
    if slope > _STEEPEST:
        hint = _why_so_steep(surface.heights, size)
        raise InputError(
            f"heights: their rms slope is {slope:.3g}, that of surfaces below 1: {hint}"
        )
    zeros = _filled_zeros(surface.heights)
    return SpectralMoments(
        m0, tuple(m2), tuple(m4), step, apart, missing, used, size, zeros, m2_cross=cross
    )


def _why_so_steep(heights: npt.NDArray[np.float64], size: tuple[float, float]) -> str:
    """The likely reason of slopes that no surface has: a value that fills gaps, or the unit of heights, or of the
    scan's size (m), which are told as they were read."""
    measured = heights[np.isfinite(heights)]
    for end in (measured.min(), measured.max()):
        rest = measured[measured != end]
        # a single value far beyond all others is no height
        if rest.size and np.abs(rest - end).min() > np.ptp(rest):
            many = measured.size - rest.size
            hint = "give missing points as NaN, and sizes in the unit of heights"
            read = f"heights of {end:.6g} (with the surface's unit and scale)"
            return f"{many} {read} may be a fill value; {hint}"
    read = f"read as {np.ptp(measured):.3g} m of height on {size[0]:.3g} m x {size[1]:.3g} m"
    return f"{read}: are heights and sizes in one unit, and is it the one declared (surface.unit)?"


def _filled_zeros(heights: npt.NDArray[np.float64]) -> float:
    """The share of heights that are exactly 0, where no other value is nearly as frequent; else 0."""
    zeros = int((heights == 0.0).sum())
    if zeros < max(_ZEROS * heights.size, 4):
        return 0.0
    others = np.unique(heights[np.isfinite(heights) & (heights != 0.0)], return_counts=True)[1]
    return zeros / heights.size if zeros > _ODD * others.max(initial=0) else 0.0


def moments_of_spectrum(
    wavevectors: npt.ArrayLike, power: npt.ArrayLike, convention: str = "isotropic"
) -> SpectralMoments:
    """Profile moments m0, m2, m4 of an isotropic surface from its power spectrum (paper, Eq. PcPersson2).

    Between two points the spectrum is the power law through both, integrated exactly; elsewhere it is zero.

    wavevectors, power : q = 2 pi/wavelength in 1/m, shape (n,), n >= 2, rising, and C(q), shape (n,); all above zero.
    convention : "isotropic", in m⁴: C(q) = ∫ d²x <h(x)h(0)> e^(-iqx), the paper's, so that <h²> = ∫ q C dq/(2 pi);
        then m2 = ∫ q³ C dq/(4 pi), which is the paper's R, and m4 = (3/8) ∫ q⁵ C dq/(2 pi). Spectra with the factor
        1/(2 pi)² in their definition, like Persson's, must be multiplied by (2 pi)².
        "profile", in m³: C(q) = ∫ dx <h(x)h(0)> e^(-iqx) of line scans, so that m_n = ∫_0 q^n C dq/pi.
    Raises InputError for arrays that are not these.
    """
    q, c = positive_array("wavevectors", wavevectors), positive_array("power", power)
    if q.size < 2 or c.size != q.size:
        refuse("power", c, f"must hold one value for each of {q.size} wavevectors, at least two")
    if not (np.diff(q) > 0.0).all():
        refuse("wavevectors", q, "must rise from point to point")
    # integrals of q^order C(q), C a power law between neighbours
    isotropic = one_of("convention", convention, ("isotropic", "profile")) == "isotropic"
    orders, rise = np.arange(0.0, 5.0, 2.0)[:, None] + isotropic, np.log(q[1:] / q[:-1])
    growth = np.log(c[1:] / c[:-1]) + (orders + 1.0) * rise
    pieces = c[:-1] * q[:-1] ** (orders + 1.0) * rise * scipy.special.exprel(growth)
    sums = pieces.sum(axis=1) / np.pi
    # averages of cos² and of cos⁴ over all directions
    m0, m2, m4 = (sums * [0.5, 0.25, 0.1875] if isotropic else sums).tolist()
    return SpectralMoments(m0=m0, m2_axes=(m2, m2), m4_axes=(m4, m4))
