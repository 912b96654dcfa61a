"""A result as a Dataset of xarray, in the units of the result's scale."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from origins.errors import InputError
from toolkit.results.kinds import QUANTITIES
from toolkit.results.points import key_units

_NO_SERIES = {"path", "slips", "energy", "regime", "histograms", "avalanches", "breaks_per_rank"}


def as_dataset(result: Any) -> Any:
    """The arrays of a Result by name, each with its `units`: along `point`, the path's, "master_force",
    "eq_force_standard_error" and the like; along `master_slip` and `eq_slip` what slips have; along `threshold` P_c;
    along the swept quantities what a sweep has. A master equation that ends early is nan beyond. Raises InputError
    where xarray is not installed."""
    try:
        import xarray
    except ImportError as error:
        raise InputError("to_xarray: needs xarray; install mesofriction[xarray]") from error
    variables, coordinates = dict[str, Any](), dict[str, Any]()
    if result.curves:
        path = max((curve.path for curve in result.curves), key=len)
        coordinates["path"] = _array(result, "point", "path", path)
        if result.timed:
            coordinates["time"] = _array(result, "point", "time", result.time[: path.size])
        for name in ("master", "eq"):
            if (answer := getattr(result, name)) is not None:
                variables |= _of_answer(result, name, answer, path.size)
    curve, unit = result.thresholds, result.scale.length_unit
    coordinates["threshold"] = ("threshold", curve.x, {"units": unit})
    variables["density"] = ("threshold", curve.density, {"units": f"1/{unit}"})
    variables["survival"] = ("threshold", curve.survival, {"units": "1"})
    if result.sweep is not None:
        variables |= _of_sweep(result, result.sweep)
    whole = {"name": result.name, "title": result.title, "version": result.version}
    return xarray.Dataset(variables, coordinates, whole | {"scene": result.text})


def _array(result: Any, along: Any, name: str, values: Any) -> tuple[Any, Any, dict[str, str]]:
    """A variable of xarray, forces and springs in the unit of the scale."""
    scale, quantity = result.scale, QUANTITIES.get(name)
    if quantity in ("force", "spring"):
        unit = getattr(scale, f"{quantity}_unit")
        return along, getattr(scale, quantity) * np.asarray(values), {"units": unit}
    length, time = scale.length_unit, scale.time_unit
    units = {"length": length, "time": time, "speed": scale.speed_unit, "kelvin": "K"}
    units |= {"temperature": f"{length}^2", "rate": f"{length}^2/{time}"}
    return along, np.asarray(values), {"units": units.get(quantity or "", "1")}


def _of_answer(result: Any, prefix: str, answer: Any, size: int) -> dict[str, Any]:
    """The arrays of a solver's answer along its path, and those of its slips."""
    out = dict[str, Any]()
    for field in fields(answer):
        name, value = field.name, getattr(answer, field.name)
        if name in _NO_SERIES or not isinstance(value, np.ndarray):
            continue
        if value.shape[-1] == answer.path.size:
            missing = [(0, 0)] * (value.ndim - 1) + [(0, size - answer.path.size)]
            whole = np.pad(np.asarray(value, float), missing, constant_values=np.nan)
            along = ("replica", "point") if value.ndim == 2 else "point"
            out[f"{prefix}_{name}"] = _array(result, along, name, whole)
    if is_dataclass(slips := getattr(answer, "slips", None)):
        for field in fields(slips):
            if isinstance(value := getattr(slips, field.name), np.ndarray):
                own = _array(result, f"{prefix}_slip", field.name, value)
                out[f"{prefix}_slip_{field.name}"] = own
    error = getattr(answer, "force_error", None)
    if isinstance(error, float):
        own = error * result.mean_threshold * result.scale.force
        out[f"{prefix}_force"][2]["error"] = own
    return out


def _of_sweep(result: Any, sweep: Any) -> dict[str, Any]:
    """The arrays of a sweep along what it sweeps, of one over keys of the scene along its points."""
    if not sweep.smooth:
        units = sweep.units | key_units(sweep.along, result.scale)
        return {
            f"sweep_{name}": ("sweep_point", values, {"units": units.get(name) or "1"})
            for name, values in sweep.columns.items()
        }
    along = tuple(f"sweep_{name}_values" for name in sweep.along)
    out = {
        f"sweep_{name}": _array(result, along, name, value)
        for name, value in sweep.columns.items()
        if name != "force_error"
    }
    error = sweep.force_error * result.mean_threshold
    return out | {"sweep_force_error": _array(result, along, "force_standard_error", error)}
