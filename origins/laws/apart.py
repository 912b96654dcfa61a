"""Laws of a contact that do not go together, and why."""

from collections.abc import Set
from typing import NamedTuple

from origins.errors import InputError

MEAN_RATE = "mean rate"  # the thermal closure "paper", which is no law of its own
GROWTH = "growth"  # of thresholds, by grains or by strengthening


class Apart(NamedTuple):
    """Two laws that do not go together, and why; names of LAWS, the mean rate or growth."""

    one: str
    other: str
    reason: str


_LINKED = "stiffness = 'linked': not defined with"
_EXACT = 'use closure = "exact"'
_APART = (
    Apart(
        "stiffness",
        MEAN_RATE,
        f'{_LINKED} thermal closure = "paper", one mean rate for all contacts; {_EXACT}',
    ),
    Apart(
        "stiffness",
        "ageing",
        f'{_LINKED} ageing: nothing says whether k_i follows the threshold; use "independent"',
    ),
    Apart(
        "stiffness",
        "grains",
        f'{_LINKED} thresholds that grow: <x_s> at birth is 0; use "independent"',
    ),
    Apart(
        "stiffness",
        "strengthening",
        f'{_LINKED} thresholds that grow: nothing says whether k_i grows, too; use "independent"',
    ),
    Apart(
        GROWTH,
        MEAN_RATE,
        f'thermal: closure = "paper" averages over one P_c, and each age has another; {_EXACT}',
    ),
    Apart(
        "ageing",
        MEAN_RATE,
        f'thermal: closure = "paper" averages over one P_c, and contacts that age have none; {_EXACT}',
    ),
    Apart(
        GROWTH,
        "ageing",
        "ageing: thresholds that grow with their age do age, by a law of their own; leave one out",
    ),
    Apart(
        "grains",
        "reforming",
        "reforming: contacts form again as their grains pin, where all thresholds are 0; leave it out",
    ),
    Apart(
        "strengthening",
        "reforming",
        "reforming: contacts whose thresholds grow are taken as they form again relaxed alone; leave it out",
    ),
)


def refuse_apart(laws: Set[str]) -> None:
    """InputError, with the reason, where two of these laws do not go together: names of origins.contacts.LAWS, the
    mean rate or growth."""
    for apart in _APART:
        if laws >= {apart.one, apart.other}:
            raise InputError(apart.reason)
