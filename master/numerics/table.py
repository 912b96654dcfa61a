"""Table: functions of one number, kept as polynomials on panels that are halved as needed."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from master.numerics import polynomials
from origins.thresholds.law import Array
from origins.thresholds.numerical import clipped

# Coefficients of a panel's polynomial.
SIZE = 12
# Most new panels that are halved together, and most halvings of one: more would only resolve rounding.
MOST_TOGETHER, DEPTH = 1024, 50
# Halving reduces the last coefficients below this part of themselves, unless they are rounding.
HALVED_TO = 0.3


class Table:
    """Functions of one number x >= 0, a length or a time, polynomials between edges; 0 beyond the last.

    function : takes x of shape (panels, nodes), each row within one panel, and gives an array of
        shape (functions, panels, nodes)
    edges : sorted; the functions may jump or bend there; equal ones count once
    accuracy : a panel is halved while one of its last two coefficients is larger
    shortest : length of the shortest panel
    at_ends : allowed error of a polynomial at the ends of its panel, in units of the accuracy, which finds a fall
        between an end and the first node; 0: not checked
    size : number of coefficients of the polynomials
    looser : takes values, as `function` gives them, and the panels' widths; returns the factor on the
        accuracy on each panel, shape (panels,), or (functions, panels)
    rounding : in units of the accuracy: panels whose last coefficients are below it are halved only while that helps

    begin, end, widths, edges : of the panels; edges has one entry more
    error : largest error at the ends of panels, where polynomials are off most; unchecked, last coefficient
    tails : array of shape (functions, panels), the larger of the last two coefficients
    """

    def __init__(
        self,
        function: Callable[[Array], Array],
        edges: Array,
        accuracy: float,
        shortest: float,
        at_ends: float = 0.0,
        size: int = SIZE,
        looser: Callable[[Array, Array], Array] | None = None,
        rounding: float = 0.0,
    ) -> None:
        """Halve the panels until polynomials give the function to the accuracy; the arguments are those above."""
        gauss, to_ends = polynomials.gauss(size), polynomials.gauss(size).at(np.array([0.0, 1.0]))
        edges = np.unique(edges)  # a panel without a width would stand before its neighbour
        low, high = np.asarray(edges[:-1], dtype=float), np.asarray(edges[1:], dtype=float)
        places = np.concatenate([[0.0], gauss.nodes, [1.0]]) if at_ends > 0.0 else gauss.nodes
        kept, self.error, before = [], 0.0, np.full(low.size, np.inf)
        for _ in range(DEPTH):
            # rounding may put the last place beyond the panel's end
            x = np.minimum(low[:, None] + (high - low)[:, None] * places, high[:, None])
            values = function(x)
            series = (values[..., 1:-1] if at_ends > 0.0 else values) @ gauss.series
            tail = wrong = np.abs(series[..., -2:]).max(axis=2)
            if at_ends > 0.0:
                wrong = np.abs(values[..., 1:-1] @ to_ends - values[..., [0, -1]]).max(axis=2)
                tail = np.maximum(tail, wrong / at_ends)
            tail = (tail / looser(values, high - low) if looser else tail).max(axis=0)
            # nodes nearer to each other than 1e-15 of their place coincide by rounding
            rough = (tail > accuracy) & (high - low > np.maximum(shortest, 1e-15 * np.abs(high)))
            rough &= (tail > rounding * accuracy) | (tail < HALVED_TO * before)
            rough &= low.size <= MOST_TOGETHER + edges.size
            kept.append((low[~rough], high[~rough], series[:, ~rough].transpose(2, 0, 1)))
            self.error = max(self.error, float(wrong[:, ~rough].max(initial=0.0)))
            low, high, before = low[rough], high[rough], np.tile(tail[rough], 2)
            if not low.size:
                break
            middle = low + 0.5 * (high - low)
            low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
        begin, end, parts = (np.concatenate(part, axis=-1) for part in zip(*kept, strict=True))
        order = np.argsort(begin)
        self.begin, self.end = begin[order], end[order]
        self.edges, self.widths = np.append(self.begin, self.end[-1]), self.end - self.begin
        # shape (size, functions, n)
        self._parts = np.ascontiguousarray(parts[..., order])
        self.tails: Array = np.abs(self._parts[-2:]).max(axis=0)

    def __call__(self, x: Array) -> Array:
        """Values of the functions, shape (functions, *x.shape)."""
        panel = np.maximum(np.searchsorted(self.begin, x, "right") - 1, 0)
        inside = x < self.end[-1]
        distance = np.where(inside, x, self.begin[-1]) - self.begin[panel]
        z, parts = 2.0 * distance / self.widths[panel] - 1.0, self._parts.take(panel, axis=2)
        return np.asarray(legendre.legval(z, parts, tensor=False) * inside)

    def near(self, function: int, value: float, rounding: float) -> npt.NDArray[np.bool_]:
        """On which panels this function is the value, to such a rounding; shape (panels,)."""
        parts = self._parts[:, function]
        return np.asarray(np.abs(parts[0] - value) + np.abs(parts[1:]).sum(axis=0) <= rounding)

    def lines(self, rounding: float) -> npt.NDArray[np.bool_]:
        """On which panels all functions are lines, to a rounding of their largest coefficient; shape (panels,)."""
        size = np.abs(self._parts)
        return np.asarray((size[2:].sum(axis=0) <= rounding * size.max(axis=0)).all(axis=0))

    def integrals(self) -> Array:
        """Integral of each function over all panels, shape (functions,)."""
        return np.asarray(self._parts[0] @ self.widths)

    def missed(self) -> Array:
        """Errors of the integrals, shape (functions,): Gauss nodes integrate polynomials of twice the degree exactly,
        and up to there the coefficients are taken to keep the decay that the last four show."""
        size = np.abs(self._parts)
        last, fall_of_two = polynomials.last_and_fall(np.moveaxis(size, 0, -1))
        rounding = np.finfo(float).eps * size.max(axis=0)
        return np.asarray(
            (last * fall_of_two ** (self._parts.shape[0] // 2) + rounding) @ self.widths
        )

    def up_to(self, x: Array) -> Array:
        """Integral of the first function from the first edge to x, same shape as x."""
        whole = np.append(0.0, np.cumsum(self.widths * self._parts[0, 0]))
        panel = clipped(np.searchsorted(self.begin, x, "right") - 1, 0, self.begin.size - 1)
        distance = np.minimum(x, self.end[panel]) - self.begin[panel]
        # the mean up to x keeps its digits where x is close to an edge, unlike the integral
        gauss = polynomials.gauss(self._parts.shape[0])
        integral = legendre.legint(self._parts[:, 0], lbnd=-1.0)
        grown = legendre.legval(2.0 * gauss.nodes - 1.0, integral)
        mean = (0.5 * grown / gauss.nodes) @ gauss.series
        z = 2.0 * distance / self.widths[panel] - 1.0
        return np.asarray(
            whole[panel] + distance * legendre.legval(z, mean.T[:, panel], tensor=False)
        )
