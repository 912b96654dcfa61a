"""Contacts that form, each with a stretch and a larger threshold: their tables, and compiled draws of rows."""

from functools import cache
from types import SimpleNamespace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from eq_model.compiling import compiled, inlined, unsigned, whole
from eq_model.draws.quantiles import beyond, draw_values, quantile
from eq_model.draws.streams import LANES, STARTS, THRESHOLDS, draw, uniform, words_at
from eq_model.draws.tables import DEEPEST, FAR, Table, make_table
from origins import Contacts
from origins.errors import InputError
from origins.start import Start

_STRETCHES, _BEYOND = np.int64(16), np.int64(32)  # added to a purpose, for words of other uses
_OTHERS = 8  # added to a purpose: words that replace rejected ones
LEVEL_UNIT = 2.0**-40  # exposures (ln e) are drawn as whole multiples of this
_FAINTEST, _LEAST = 1e-290, 1e-300  # least survival at the stretches of birth; and in a table


class Births(NamedTuple):
    """The laws of contacts that form, in whole units."""

    thresholds: Table
    stretches: Table  # used if `drawn`
    single: np.int64  # the stretch of all contacts, if not `drawn`
    drawn: bool
    top: np.int64  # upper end of the thresholds: larger stretches are drawn again
    purpose: np.int64  # of the random words


# runs with many seeds share the tables of the same contacts
_KNOWN: WeakKeyDictionary[Contacts, dict[str, Table]] = WeakKeyDictionary()


def tables_of(contacts: Contacts) -> dict[str, Table]:
    """Tables (lengths) of "thresholds" and, unless these are single values, "start" and "reforming"; made once.

    Raises InputError where they cannot be certified, and where stretches reach so far that the
    survival of the thresholds is below 1e-290.
    """
    if contacts not in _KNOWN:
        laws = laws_of(contacts)
        rare = min(_survival(name, law, contacts) for name, law in laws.items())
        found = {"thresholds": make_table(contacts.thresholds, max(DEEPEST * rare, _LEAST))}
        spread = ((name, law) for name, law in laws.items() if not law.is_single)
        _KNOWN[contacts] = found | {name: make_table(law, name=name) for name, law in spread}
    return _KNOWN[contacts]


def laws_of(contacts: Contacts) -> dict[str, Start]:
    """Laws of the stretches at which contacts form: at X = 0, and later on unless they re-form relaxed."""
    again = contacts.reforming
    return {"start": contacts.start} | ({"reforming": again.law} if again else {})


def births_of(contacts: Contacts, unit: float) -> tuple[Births, Births]:
    """Births at X = 0 and later on, in whole multiples of the length `unit`."""
    tables = {name: table.in_units(unit) for name, table in tables_of(contacts).items()}
    top = np.int64(min(contacts.thresholds.support()[1] / unit, float(FAR)))

    def make(name: str, purpose: np.int64) -> Births:
        law, own = laws_of(contacts).get(name), tables.get(name, tables["thresholds"])
        single = np.int64(round(law.mean() / unit) if law else 0)
        return Births(tables["thresholds"], own, single, name in tables, top, purpose)

    return make("start", STARTS), make("reforming", THRESHOLDS)


@cache
def exposures() -> Table:
    """Table of ln e, e of the exponential law of mean 1: contacts break where the integral of their rate is e."""
    law = SimpleNamespace(
        cdf=lambda x: -np.expm1(-np.exp(x)),
        sf=lambda x: np.exp(-np.exp(x)),
        ppf=lambda q: np.log(-np.log1p(-np.asarray(q))),
        isf=lambda q: np.log(-np.log(q)),
    )
    return make_table(law, name="what contacts bear")


def _survival(name: str, law: Start, contacts: Contacts) -> float:
    """Survival of the thresholds where the stretches of `law` reach furthest."""
    thresholds, furthest = contacts.thresholds, max(abs(law.span[0]), abs(law.span[1]))
    upper = thresholds.support()[1]
    if furthest >= upper:
        # stretches beyond the largest threshold are cut off, but the others may come close to it
        return max(float(thresholds.sf(np.nextafter(upper, 0.0))), _FAINTEST)
    survival = float(thresholds.sf(furthest))
    if survival < _FAINTEST:
        deepest = float(thresholds.isf(_FAINTEST))
        raise InputError(
            f"{name}: reaches |x| = {furthest:g}, where the survival of the thresholds is below 1e-290; "
            f"use stretches that contacts can have reached, below {deepest:.6g}"
        )
    return survival


@inlined
def draw_round(n, turn, stream, births, room):  # type: ignore[no-untyped-def]
    """Draw the words of n lanes for the four rows of a round."""
    draw(n, turn, stream, births.purpose, room.words)
    if births.drawn:
        draw(n, turn, stream, births.purpose + _STRETCHES, room.others)


@inlined
def form_row(n, row, turn, stream, births, room, x, r):  # type: ignore[no-untyped-def]
    """Thresholds x and stretches r of n contacts that form: P_c conditional on x_s > |r|."""
    table, purpose = births.thresholds, births.purpose
    draw_values(n, row, turn, stream, purpose, room.words, table, room, x)
    if births.drawn:
        own, stretches = purpose + _STRETCHES, births.stretches
        draw_values(n, row, turn, stream, own, room.others, stretches, room, r)
        for i in range(unsigned(n)):
            attempt = 0
            while abs(r[i]) >= births.top:
                attempt += 1
                word, fine, _, _ = words_at(i, turn + (attempt << 48), stream, own + _OTHERS + row)
                r[i] = quantile(word, fine, stretches)
    else:
        for i in range(unsigned(n)):
            r[i] = births.single
    few = False
    for i in range(unsigned(n)):
        few |= x[i] < abs(r[i])
    if few:
        for i in range(n):
            if x[i] < abs(r[i]):
                a, b, c, d = words_at(i, turn, stream, purpose + _BEYOND + row)
                x[i] = beyond(abs(r[i]), uniform(a, b), uniform(c, d), table, room)


@compiled
def form_all(count, stream, births, room):  # type: ignore[no-untyped-def]
    """Thresholds and stretches of `count` contacts, shape (2, count)."""
    out = np.empty((2, -(-count // LANES) * LANES), whole)
    for part in range(whole(out.shape[1] // LANES)):
        x, r = out[0, part * LANES : (part + 1) * LANES], out[1, part * LANES : (part + 1) * LANES]
        turn, row = part >> whole(2), part & whole(3)
        if row == 0:
            draw_round(whole(LANES), turn, stream, births, room)
        form_row(whole(LANES), row, turn, stream, births, room, x, r)
    return out[:, :count]
