"""Temperatures that are too high or too low for some thresholds, often as their unit is another one."""

from __future__ import annotations

from origins.thresholds.law import Thresholds


class TooHot(UserWarning):
    """The temperature is far above all barriers, as if it were given in kelvins."""


def too_hot(temperature: float, thresholds: Thresholds) -> str:
    """A warning for a temperature k_BT/<k> (a length squared) at which no contact holds; "" for a lower one."""
    ratio = temperature / thresholds.moment(2)
    if not ratio > 100.0:  # barriers are then below k_BT/200
        return ""
    kelvin = ": of kelvins write temperature = { kelvin = 300.0 }" if thresholds.interface else ""
    return (
        f"the temperature is {ratio:.3g} <x_s^2>: barriers are {0.5 / ratio:.1g} k_BT, so that contacts break as often "
        f"as they attempt, whatever their stretch and threshold; it is k_BT/<k>, a length squared{kelvin}"
    )


def too_cold(temperature: float, thresholds: Thresholds) -> str:
    """Why a temperature k_BT/<k> (a length squared) is too low for these thresholds; "" where it is high enough."""
    mean, least, unit = thresholds.mean(), 1e-20, ""
    if not temperature < least * mean**2:
        return ""
    if thresholds.interface is not None:
        unit = f" are the surface's lengths, <x_s> = {mean:.2g} m, in their unit?"
    measured = f"k_BT/<k> = {temperature:.1g} is {temperature / mean**2:.1g} of <x_s>²;{unit}"
    return f"{measured} below {least:g} of it contacts break at their thresholds: leave thermal out"
