"""From lengths, in which both solvers give forces, to the units of the user: newtons, pascals, or N_c<k>."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from origins.contacts import Contacts
from origins.thresholds.law import Thresholds

# SI prefixes by powers of ten, as far as friction needs them
PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
# units that take a prefix
PREFIXED = ("N", "N/m", "N/m³", "m", "s", "Pa", "m/s")
# units of a scene without SI units, in words
_OWN = "length", "time", "length/time"
_IN_WORDS = {unit: f"units of {unit.replace('/', ' per ')}" for unit in _OWN}
# of the largest of some forces: a smaller one of them is round-off, and none
ROUNDING = 1e-12
# first digits of an uncertainty below which a value has one digit more
FINER = 3.55
SI, SHARED = "SI", "N_c<k>"  # what a scene's `units` may be


class Unit(NamedTuple):
    """A unit of forces: its `size` as F/(N_c <k>), a length, and its name."""

    size: float
    name: str


@dataclass(frozen=True)
class Scale:
    """What a force F/(N_c <k>), a length, and a spring K/(N_c <k>), a pure number, are in the user's units.

    force : factor of forces; force_unit : its unit, "N" with an area, "Pa" (per area) for a surface without one, else
        "N_c<k>·length" (of a surface "N_c<k>·m")
    spring : factor of springs; spring_unit : "N/m", "N/m³" (per area) or "N_c<k>"
    length_unit, time_unit : "m" and "s" for a surface, and of samples whose unit is given, else "length" and "time"
    load : the normal force in the unit of forces; None where there is none
    contacts : N_c on the area; None without one
    """

    force: float = 1.0
    force_unit: str = "N_c<k>·length"
    spring: float = 1.0
    spring_unit: str = "N_c<k>"
    length_unit: str = "length"
    time_unit: str = "time"
    load: float | None = None
    contacts: float | None = None

    @property
    def speed_unit(self) -> str:
        """Of velocities: "m/s" for a surface."""
        return f"{self.length_unit}/{self.time_unit}"

    def speed(self, velocity: float) -> str:
        """A velocity as it is told: in m/s, and a number alone where lengths have a unit of their own."""
        return written(velocity, self.speed_unit if self.length_unit == "m" else "")

    @property
    def damping_unit(self) -> str:
        """Of N_c<k> times a time, where `spring` is N_c<k>."""
        return {"N/m": "N s/m", "N/m³": "N s/m³"}.get(
            self.spring_unit, f"{SHARED} {self.time_unit}"
        )

    def over(self, other: "Scale") -> "Scale":
        """The same, but forces and springs over N_c<k> of the contacts of `other`, which is in the same unit."""
        if not (self.in_si and other.in_si):
            return self
        shared = replace(self, force=self.force / other.force, force_unit=f"{SHARED}·m")
        shared = replace(shared, spring=self.spring / other.spring, spring_unit=SHARED)
        return shared if self.load is None else replace(shared, load=self.load / other.force)

    @property
    def in_si(self) -> bool:
        """Whether forces are in newtons or pascals."""
        return self.force_unit in ("N", "Pa")

    def of_errors(self, mean_threshold: float) -> "Unit":
        """In which unit errors of forces are told: newtons or pascals, else mean thresholds."""
        if self.in_si:
            return Unit(1.0 / self.force, self.force_unit)
        return Unit(mean_threshold, "<x_s>")

    def error(self, error: float, mean_threshold: float) -> str:
        """An error of a force, given in mean thresholds as tolerances are, in words: in newtons or pascals first where
        they are known."""
        shared = f"{error:.1e} of <x_s>"
        if not (self.in_si and np.isfinite(error)):
            return shared
        return (
            f"{written(error * mean_threshold * self.force, self.force_unit, digits=2)} ({shared})"
        )


def scale_of(contacts: Contacts, area: float | None, units: str = SI) -> Scale:
    """The units of these contacts on a nominal `area` in m² (None: not known); `units` as a scene has it."""
    surface = contacts.interface
    if surface is None:
        return without_stiffness(contacts.thresholds.in_metres)
    return of_surface(
        surface.contact_density, surface.mean_stiffness, surface.pressure, area, units
    )


def length_unit_of(thresholds: Thresholds) -> str:
    """Of the lengths of a law: "m" of a surface's, with a stated interface, or of samples in a unit; else "length"."""
    in_metres = thresholds.interface is not None or thresholds.in_metres
    return "m" if in_metres else "length"


def without_stiffness(in_metres: bool) -> Scale:
    """The units of contacts whose <k> is not known: metres and seconds, or units of their own."""
    if not in_metres:
        return Scale()
    return Scale(force_unit="N_c<k>·m", length_unit="m", time_unit="s")


def of_surface(
    density: float | None,
    stiffness: float,
    pressure: float | None,
    area: float | None,
    units: str = SI,
) -> Scale:
    """The units of a surface with so many contacts per area (1/m²), <k> (N/m) under a nominal pressure (Pa); a density
    or a pressure of None is not known."""
    if density is None:
        return without_stiffness(in_metres=True)
    together = density * stiffness  # N/m for each m²
    if units == SHARED:
        load = None if pressure is None else pressure / together
        number = None if area is None else density * area
        return Scale(1.0, "N_c<k>·m", 1.0, "N_c<k>", "m", "s", load, number)
    if area is None:
        return Scale(together, "Pa", together, "N/m³", "m", "s", load=pressure, contacts=None)
    each, load = together * area, None if pressure is None else pressure * area
    return Scale(each, "N", each, "N/m", "m", "s", load, density * area)


def written(value: float, unit: str, uncertainty: float = 0.0, digits: int = 3) -> str:
    """A value with an SI prefix before its unit, to the digit of its uncertainty, with two digits at least and
    at most so many; units that take no prefix are written as powers of ten, nan as "not known", inf as "infinite"."""
    unit = _IN_WORDS.get(unit, unit)
    if np.isnan(value):
        return "not known"
    if not np.isfinite(value):
        return "infinite" if value > 0.0 else f"{value:g} {unit}".strip()
    significant = digits
    for _ in range(2):  # 0.9999 is cut to 1.00, which has a digit more before the same uncertainty
        if value and 0.0 < uncertainty < np.inf:
            left = _significant_digits(value, uncertainty)
            significant = int(np.clip(left, min(2, digits), digits))
        value = _cut(value, significant)
    if unit not in PREFIXED or not value:
        return f"{_rounded(value, significant)} {unit}".strip()
    power = _power_of(value, unit)
    return f"{_rounded(value / 10.0**power, significant)} {PREFIXES[power]}{unit}"


def _power_of(value: float, unit: str) -> int:
    """The power of ten of the prefix of a value, which is not 0; 0 of units that take none."""
    if unit not in PREFIXED:
        return 0
    power = int(3 * np.floor((np.log10(abs(value)) + 1e-9) / 3))
    # of a second more than 1,000 stay seconds
    return min(max(power, -15), 0 if unit == "s" else 12)


def prefixed_like(value: float, like: float, unit: str, digits: int = 2) -> str:
    """A value with the prefix of another of its sentence, as the 0.14 mm by which 4.82 mm scatter; with its own where
    it is less than a thousandth in that."""
    power = _power_of(like, unit) if like else 0
    if unit not in PREFIXED or not 1e-3 <= abs(value) / 10.0**power < np.inf:
        return written(value, unit, digits=digits)
    return f"{_rounded(value / 10.0**power, digits)} {PREFIXES[power]}{unit}"


def guarded(value: float, unit: str, uncertainty: float, vague: bool = False) -> str:
    """As `written`, of a value whose uncertainty is told elsewhere, 3 or 4 digits: to that of the uncertainty, and one
    more where this begins with 1, 2 or 3. With two digits two values that are nearly alike may seem 4 % apart. Those
    that are `vague` have two."""
    if not (value and 0.0 < uncertainty < np.inf):
        return written(value, unit)
    more = uncertainty < FINER * 10.0 ** np.floor(np.log10(uncertainty))
    digits = int(np.clip(_significant_digits(value, uncertainty) + more, 3, 4))
    return written(value, unit, digits=2 if vague else digits)


def _significant_digits(value: float, uncertainty: float) -> int:
    """How many digits of the value its uncertainty leaves; 0 or less where that is larger."""
    return int(np.floor(np.log10(abs(value))) - np.floor(np.log10(uncertainty))) + 1


def spoken(value: float, unit: str) -> str:
    """As `written`, and of thresholds in a unit of their own as "0.3 units of time"."""
    return f"{value:.3g} {_IN_WORDS[unit]}" if unit in _IN_WORDS else written(value, unit)


def with_uncertainty(value: float, error: float, unit: str, digits: int = 4) -> str:
    """As `with_scatter`, with a bound of its error, which is rounded up: 251 ± 10 mN of 0.2512 N known to 9.1 mN; that
    of one replica is unknown."""
    if error == np.inf:
        return f"{written(value, unit, error, digits)} (error unknown)"
    return _with_one_prefix(value, error, rounded_up(error), unit, digits)


def rounded_up(error: float, digits: int = 1) -> float:
    """A finite error with so many digits, none below it: 0.024 becomes 0.03 with one, as a bound that is told too small
    is wrong."""
    if not error > 0.0:
        return error
    power = float(np.floor(np.log10(error))) - (digits - 1)
    # a digit that a sum of floating point exceeds by its rounding stays
    return float(f"{np.ceil(error / 10.0**power * (1.0 - 1e-9)):.0f}e{power:.0f}")


def with_error(value: float, error: float, digits: int) -> str:
    """Value and error, rounded up, as text, both with one power of ten where they have any: the value to `digits` or to
    the first digit of the error, and to the second where it is of the size of the first; without an error of 0."""
    if not (np.isfinite(value) and 0.0 < error < np.inf):
        return f"{value:.{digits}g}" + " ± inf" * bool(np.isfinite(value) and error == np.inf)
    magnitude = np.floor(np.log10(abs(value) or error))
    said, of_error = rounded_up(error), 1
    if error < abs(value) and magnitude == np.floor(np.log10(said)):
        said, of_error = rounded_up(error, digits=2), 2
    last = int(np.floor(np.log10(said))) - of_error + 1  # power of ten of the last digit
    if magnitude - last + 1 >= digits:
        return f"{value:.{digits}g} ± {said:.{of_error}g}"
    return _beside(value, said, last, power_of_size(max(abs(value), said)))


def power_of_size(size: float) -> int:
    """The power of ten to take out of a number: 0 where it is short without."""
    return 0 if 1e-3 <= size < 1e6 else int(np.floor(np.log10(size)))


def _beside(value: float, error: float, last: int, power: int, unit: str = "") -> str:
    """Value and error, rounded to the digit of 10^`last`, in multiples of 10^`power`, which `unit` stands for."""
    each = (round(one / 10.0**last) * 10.0**last / 10.0**power for one in (value, error))
    both = " ± ".join(f"{one:,.{max(power - last, 0)}f}" for one in each)
    return f"({both})e{power:+03d}" if power and not unit else f"{both}{unit}"


def with_scatter(value: float, error: float, unit: str, digits: int = 4) -> str:
    """A value with its error, both with one prefix, such as 251.2 ± 0.3 mN: to the first digit of the error, and to its
    second where the value has no digit before that. An error that would be a second digit behind `digits`, numerical as
    a rule, is left out."""
    return _with_one_prefix(value, error, error, unit, digits)


def _with_one_prefix(value: float, error: float, told: float, unit: str, digits: int) -> str:
    """The value to the digit of its error, with the error that is `told` of it, rounded up or not."""
    if not (np.isfinite(value) and max(10.0**-digits * abs(value), 1e-300) <= error < np.inf):
        return written(value, unit, error, digits)
    last = int(np.floor(np.log10(error)))  # power of ten of the last digit
    if value and np.floor(np.log10(abs(value))) <= last:
        last -= 1
        told = told if told == error else rounded_up(error, digits=2)
    larger = max(abs(value), told, 10.0**last)
    if unit in PREFIXED:
        # of what is rounded up to a power of ten that has a prefix
        power = _power_of(_cut(larger, int(np.floor(np.log10(larger))) - last + 1), unit)
        return _beside(value, told, last, power, f" {PREFIXES[power]}{unit}")
    unit = _IN_WORDS.get(unit, unit)
    return f"{_beside(value, told, last, power_of_size(larger))} {unit}".strip()


def of_contacts(number: float, digits: str = ",.0f") -> str:
    """So many contacts, or 1 contact, as text; `digits`: how the number is written."""
    return f"{number:{digits}} contact{'s' * (number != 1.0)}"


def in_three_digits(number: float) -> str:
    """A number of contacts in three digits: how many an area holds hangs on how its surface is read."""
    return f"{float(f'{number:.3g}'):,.0f}"


def told_contacts(number: float) -> str:
    """So many contacts, or 1 contact, in three digits, such as 518,000 contacts."""
    return f"{in_three_digits(number)} contact{'s' * (number != 1.0)}"


def _cut(value: float, digits: int) -> float:
    """The value rounded to so many significant digits; 0 or less leave it as it is."""
    return float(f"{value:.{digits - 1}e}") if digits > 0 else value


def _rounded(value: float, digits: int) -> str:
    """The value to so many significant digits, in plain digits where these are few."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e6:
        # 1e-9 over its prefix may be a last bit below 1
        places = digits - 1 - int(np.floor(np.log10(abs(value)) + 1e-12)) if value else 0
        return f"{round(value, places):,.{max(places, 0)}f}"
    return f"{value:.{digits - 1}e}"
