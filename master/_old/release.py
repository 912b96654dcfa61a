"""What a break does to the force, on a slider that moves steadily forward.

A broken contact waits while the slider moves by d = v tau, forms again at a stretch r, and breaks once more: at a
travel s after the last break it then bore x = r + s - d; where stiffnesses differ its own is k times the mean one.
With p(s) the law of s, r_f(s) and r_k(s) the force k x and the stiffness k released,

    F' = (stiffness of all that hold) - (force released) + (force that births bring).
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from master._old.first import FirstBreaks
    from master._old.piecewise import Piecewise

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Release:
    """The measures r_f and r_k beside p, lengths in one unit.

    Attributes
    ----------
    delay : float
        d.
    birth, widest : float
        Mean r, and the largest |r| there is.
    birth_force, birth_stiffness : float
        Means of k r and of k at a birth.
    stiffness : float
        k of a contact per length of its threshold; 0 where all are equally stiff.
    born : FirstBreaks or None
        Breaks after births at other stretches than 0.
    relaxed : Piecewise or None
        r_k of relaxed births at a temperature, where stiffnesses differ.
    """

    delay: float = 0.0
    birth: float = 0.0
    widest: float = 0.0
    birth_force: float = 0.0
    birth_stiffness: float = 1.0
    stiffness: float = 0.0
    born: "FirstBreaks | None" = None
    relaxed: "Piecewise | None" = None
    unit: float = 1.0

    @property
    def plain(self) -> bool:
        """Whether contacts form again at once, relaxed, and all are equally stiff: then r_f = s p is all it takes."""
        return self.born is None and self.delay == 0.0 and self.stiffness == 0.0

    def densities(self, x: Array, p: Array) -> list[Array]:
        """r_f, and where stiffnesses differ r_k, at travels x after a break, where breaks have the density p."""
        s = x - self.delay
        if self.born is not None:
            rows = [self.born.rate(s)]
            return rows if self.born.stiffness is None else [*rows, self.born.stiffness(s)]
        if not self.stiffness:
            return [p * s]
        stiff = p * (self.stiffness * s) if self.relaxed is None else self.relaxed(s * self.unit) * self.unit
        return [stiff * s, stiff]

    def stiffness_at(self, x: Array) -> Array:
        """k of those contacts that break right at their threshold, at a travel x after the last break."""
        return self.stiffness * (x - self.delay + self.birth) if self.stiffness else np.ones(np.shape(x))

    def force_at(self, x: Array) -> Array:
        """k x of the same."""
        return (x - self.delay + self.birth) * self.stiffness_at(x)

    def slope_at(self, x: Array) -> Array:
        """Slope of `force_at`."""
        return 2.0 * self.stiffness_at(x) if self.stiffness else np.ones(np.shape(x))


PLAIN = Release()
