"""Named laws: a scene's table with a `kind` becomes the call of one function.

A kind is one word here. Its keys are the function's parameters, so scenes and functions always agree.
"""

import inspect
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from origins.errors import InputError, must_be, positive, refuse
from origins.roughness.stated import BOLTZMANN
from toolkit.scene.tables import CELSIUS, GROWTHS, did_you_mean, what_is_meant, with_unit


def _origins(kinds: str, pattern: str = "{}") -> dict[str, str]:
    """The functions of origins that are named after these kinds."""
    return {kind: f"origins:{pattern.format(kind.replace('-', '_'))}" for kind in kinds.split()}


_OWN = "toolkit.scene.kinds:"
THRESHOLDS = _origins("identical gaussian rectangular mixture gw-elastic gw-plastic gw-gaussian")
THRESHOLDS |= _origins("persson lubricated grains growing-grains") | {"domains": f"{_OWN}domains"}
THRESHOLDS |= {
    "from-samples": "toolkit.scene.samples:from_samples",
    "from-topography": f"{_OWN}from_topography",
}
START = _origins("gaussian", "{}_start") | {"identical": f"{_OWN}identical_start"}
REFORMING = START | _origins("boltzmann", "{}_reforming")
SURFACES = {"scan": f"{_OWN}open_scan", "self-affine": f"{_OWN}generate"}
SURFACES |= _origins("spectrum summits", "moments_of_{}")
STIFFNESSES = _origins("sound mindlin column", "{}_stiffness") | {"power-law": "origins:PowerLaw"}
_SHAPES = "triangular square rectangular hexagonal circular irregular"
ISLANDS = _origins(_SHAPES, "{}_island") | {"file": f"{_OWN}island_of_file"}
SUBSTRATES = _origins("square hexagonal", "{}_substrate") | {"fourier": f"{_OWN}fourier_substrate"}

# keys whose value is a table: its kinds, or the one function it calls
CONTACTS: dict[str, Mapping[str, str] | str] = {
    "interface": "origins:StatedInterface",  # first: temperatures in kelvins need it
    **GROWTHS,
    "start": START,
    "reforming": REFORMING,
    "thermal": "origins:Thermal",
    "ageing": "origins:Ageing",
    "delay": "origins:Delay",
}
_TABLES: dict[str, Mapping[str, str] | str] = {
    "final": THRESHOLDS,
    "surface": SURFACES,
    "material": "origins:Material",
    "contact_stiffness": STIFFNESSES,
    "island": ISLANDS,
    "substrate": SUBSTRATES,
}

# keys that each of these functions needs, and that are one of the words that stand elsewhere
_WORDS = {
    "origins:Thermal": {"law": "origins.laws.thermal:RATE_LAWS"},
    f"{_OWN}from_topography": {
        "model": "origins.roughness.from_surface:MODELS",
        "law": "origins.roughness.from_surface:LAWS",
    },
}

# k_BT/<k> in m² and K, beyond those of any contact: a larger temperature is in another unit than it seems
_LARGEST, _HOTTEST = 1e-3, 1e6


class _Usual(NamedTuple):
    """Unit of a key, and the range of its values as a rule."""

    unit: str
    low: float
    high: float

    def missed(self, value: float) -> float:
        """By which factor a value is outside the range; below 1 within."""
        return max(value / self.high, self.low / value)


# what the law "eyring" takes in place of its width
_ACTIVATION = {
    "kelvin": _Usual("K", 1.0, 3e3),
    "shear_strength": _Usual("Pa", 1e5, 1e11),
    "activation_volume": _Usual("m³", 1e-30, 1e-25),
}
# of what is given in SI units, to contacts whose <k> is not known
NEEDS_STIFFNESS = (
    "needs <k> in N/m, which a rough surface knows; else state it in [contacts.interface]"
)

# how messages write None, True and False, as Python has them, and as TOML says the same
_TOML = {" = None: is missing; ": ": is missing; ", " = None: ": ": is missing; "}
_TOML |= {" = True: ": " = true: ", " = False: ": " = false: "}


def build(
    kinds: Mapping[str, str] | str,
    table: object,
    where: str,
    folder: Path,
    comm: Any = None,
    thresholds: Any = None,
) -> Any:
    """The result of calling the function of the table's kind with the other keys; a single name in `kinds` is called.

    Tables within it, such as the components of a mixture, are built first. A function with a parameter `folder` is
    given `folder`, to which the scene's file names are relative, one with a parameter `comm` the communicator whose
    ranks, all of which must call, share its work, and one with a parameter `thresholds` those of the scene.

    Raises InputError with the path of the bad key, counted from `where`.
    """
    call = _called(kinds, table, where)
    parameters, arguments = call.keys, call.arguments
    given = {"folder": folder, "comm": comm, "thresholds": thresholds}  # not for a scene to say
    given = {key: value for key, value in given.items() if key in call.given}
    with inside(where, {key: key for key in (*parameters, *arguments)}):
        for key, value in arguments.items():
            if key in _TABLES:
                arguments[key] = build(_TABLES[key], value, key, folder, comm)
            elif key == "components":
                if not isinstance(value, list) or not value or not isinstance(value[0], Mapping):
                    hint = 'must be a list of tables, such as [{kind = "identical", value = 0.9}]'
                    refuse(key, value, hint)
                arguments[key] = [
                    build(THRESHOLDS, part, f"{key}[{k}]", folder, comm)
                    for k, part in enumerate(value)
                ]
        try:
            return call.function(**arguments, **given)
        except InputError:
            raise
        # numpy's, of numbers near the ends of floating point
        except (ArithmeticError, ValueError) as error:
            hint = "some of its numbers are too large or too small; are they in the right unit?"
            raise InputError(f"{call.title}: {hint}") from error


class _Call(NamedTuple):
    """The call that a scene's table stands for: the kind, or "it"; the function; by name the parameters that are keys,
    and the names of those that are not; and the table without its kind."""

    title: str
    function: Callable[..., Any]
    keys: dict[str, inspect.Parameter]
    given: set[str]
    arguments: dict[str, Any]


def _called(kinds: Mapping[str, str] | str, table: object, where: str) -> _Call:
    """The call of the table; InputError for an unknown kind, an unknown key or a missing one."""
    if not isinstance(table, Mapping):
        refuse(where, table, "must be a table")
    place, title, arguments = kinds, "it", dict(table)
    if not isinstance(kinds, str):
        title = arguments.pop("kind", None)
        if title is None:
            raise InputError(f"{where}.kind: is missing; must be one of {', '.join(kinds)}")
        if not isinstance(title, str) or title not in kinds:
            meant = did_you_mean(title, kinds)
            refuse(f"{where}.kind", title, f"{meant}must be one of {', '.join(kinds)}")
        place = kinds[title]
    function = named(str(place))
    keys = dict(inspect.signature(function).parameters)
    given = {key for key in ("folder", "comm", "thresholds") if keys.pop(key, None) is not None}
    others = [name for name, one in keys.items() if one.kind is one.VAR_KEYWORD]
    for name in others:  # the function takes further keys, and refuses unknown ones itself
        del keys[name]
    takes = f"{title} takes {', '.join(keys)}"
    for key, value in arguments.items():
        if key not in keys and (not others or key == "kind"):  # no function means a kind
            meant = what_is_meant(key, keys)
            if where.endswith("surface") and key in ("step", "detrend", "patch_area", "pressure"):
                meant = "it stands beside surface, not in it; "
            refuse(f"{where}.{key}", value, f"unknown key; {meant}{takes}")
    for key, parameter in keys.items():
        if parameter.default is parameter.empty and key not in arguments:
            raise InputError(f"{where}.{key}: is missing; {_choice(str(place), key)}{takes}")
    return _Call(title, function, keys, given, arguments)


def _choice(place: str, key: str) -> str:
    """For a message: the words or kinds of table among which this key of the function is, or its unit; else ""."""
    if words := _WORDS.get(place, {}).get(key):
        return f"{must_be(named(words))}; "
    if isinstance(kinds := _TABLES.get(key), Mapping):
        return f"must be a table whose kind is one of {', '.join(kinds)}; "
    return with_unit(key)


def named(place: str) -> Any:
    """What has this name, such as "origins:Thermal"."""
    module, name = place.split(":")
    return getattr(import_module(module), name)


def with_defaults(kinds: Mapping[str, str] | str, table: object, where: str) -> dict[str, Any]:
    """The table with the default of every key that it does not give, None where the key is left out; those within it,
    too. Raises InputError as `build` does for its keys; values are not checked."""
    call = _called(kinds, table, where)
    out: dict[str, Any] = {} if isinstance(kinds, str) else {"kind": call.title}
    for key in {**call.keys, **call.arguments}:
        value = call.arguments[key] if key in call.arguments else call.keys[key].default
        if value is not None and key in _TABLES:
            value = with_defaults(_TABLES[key], value, f"{where}.{key}")
        elif key == "components" and isinstance(value, list):
            value = [
                with_defaults(THRESHOLDS, part, f"{where}.components[{k}]")
                for k, part in enumerate(value)
            ]
        out[key] = value
    return out


def without_kelvin(table: Mapping[str, Any], where: str, surface: Any) -> Mapping[str, Any]:
    """The table with its `temperature` as k_BT/<k>, a length squared, where it is given as { kelvin = 300.0 }: for
    contacts whose stiffness in N/m is known by their interface `surface`. Raises InputError for others, and for a
    number that can only be meant in joules."""
    if where == "contacts.thermal" and "kelvin" in table and table.get("law") != "eyring":
        hint = 'write temperature = { kelvin = ... }; the law "eyring" alone takes kelvin itself'
        refuse(f"{where}.kelvin", table["kelvin"], hint)
    if table.get("law") == "eyring" and "temperature" in table:
        hint = 'of the law "eyring" write kelvin, shear_strength and activation_volume, or width'
        refuse(f"{where}.temperature", table["temperature"], hint)
    given, where = table.get("temperature"), f"{where}.temperature"
    degrees = given.get("kelvin") if isinstance(given, Mapping) else given
    if isinstance(degrees, int | float) and degrees <= 0.0:
        hint = f"must be above zero; for T = 0 leave [contacts.thermal] out; {CELSIUS}"
        refuse(f"{where}{'.kelvin' * isinstance(given, Mapping)}", degrees, hint)
    if isinstance(given, int | float) and surface is not None:  # whole numbers of TOML, too
        joules, kelvin = given / BOLTZMANN, given / surface.temperature(kelvin=1.0)
        if 1.0 < joules < 1e4 < kelvin:  # plausible temperatures, in K
            hint = f"is k_BT/<k> in m², and would be {kelvin:.2g} K; if joules are meant, write temperature ="
            refuse(where, given, f"{hint} {{ kelvin = {joules:.4g} }}")
        if given > _LARGEST and kelvin > _HOTTEST:
            hint = f"is k_BT/<k> in m², and would be {kelvin:.2g} K; did you mean temperature ="
            refuse(where, given, f"{hint} {{ kelvin = {given:g} }}")
    if isinstance(given, str) and "kelvin" not in table:
        needs = f", which {NEEDS_STIFFNESS}" * (surface is None)
        hint = f"the square of a length, or {{ kelvin = 300.0 }}{needs}"
        refuse(where, given, f"must be a number, k_BT/<k>, {hint}")
    if not isinstance(given, Mapping):
        return table
    if set(given) != {"kelvin"}:
        refuse(where, dict(given), f"must be k_BT/<k>, or {{ kelvin = 300.0 }}; {CELSIUS}")
    if surface is None:
        refuse(
            f"{where}.kelvin",
            given["kelvin"],
            f"{NEEDS_STIFFNESS}; or k_BT/<k>, the square of a length",
        )
    with inside(where, {"kelvin": "kelvin"}):
        return {**table, "temperature": surface.temperature(kelvin=given["kelvin"])}


def with_width(table: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """The table of the law "eyring" with `width`, k_BT/(τ_s V*), in place of `kelvin`, `shear_strength` and
    `activation_volume` (K, Pa, m³), where they are given; other tables as they are. Raises InputError for some of the
    three alone, beside a width, and for values that are not above zero."""
    given = {name: table[name] for name in _ACTIVATION if name in table}
    if table.get("law") != "eyring" or not given:
        return table
    if "width" in table:
        hint = f"stands beside {', '.join(given)}, which give it; leave it or them out"
        refuse(f"{where}.width", table["width"], hint)
    for name, (unit, *_) in _ACTIVATION.items():
        if name not in given:
            others = f"beside {', '.join(given)} it is needed, in {unit}"
            raise InputError(f"{where}.{name}: is missing; {others}; or give width alone")
        if isinstance(given[name], bool) or not isinstance(given[name], int | float):
            refuse(f"{where}.{name}", given[name], f"must be a number, in {unit}")
        positive(f"{where}.{name}", given[name])
    width = BOLTZMANN * given["kelvin"] / (given["shear_strength"] * given["activation_volume"])
    if not 1e-6 <= width <= 1.0:
        hint = f"makes k_BT/(shear_strength x activation_volume) = {width:.3g}, which must be 1e-6 to 1"
        odd = max(_ACTIVATION, key=lambda name: _ACTIVATION[name].missed(given[name]))
        refuse(f"{where}.{odd}", given[odd], f"{hint}; is it in {_ACTIVATION[odd].unit}?")
    rest = {name: value for name, value in table.items() if name not in _ACTIVATION}
    return rest | {"width": width}


@contextmanager
def inside(where: str, keys: Mapping[str, str]) -> Iterator[None]:
    """Put `where` before the message of any InputError raised within, and replace an argument's name by its key.

    An argument that is None is reported as a missing key, and True is written true.
    """
    try:
        yield
    except InputError as error:
        message = str(error)
        for python, toml in _TOML.items():
            message = message.replace(python, toml, 1)
        found = re.match(r"(\w+)([\w.\[\]]*(?: = |: ).*)", message)
        if found and found[1] in keys:
            raise InputError(f"{where}.{keys[found[1]]}{found[2]}") from error
        raise InputError(f"{where}: {message}") from error
