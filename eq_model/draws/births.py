"""Contacts that form, each with a stretch and a larger threshold: their tables, and compiled draws of rows."""

from functools import cache
from types import SimpleNamespace
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from eq_model.compiling import inlined, unsigned
from eq_model.draws.quantiles import beyond, draw_values, quantile
from eq_model.draws.streams import STARTS, THRESHOLDS, uniform, words_at
from eq_model.draws.tables import DEEPEST, FAR, Table, make_table
from origins import Contacts
from origins.errors import InputError
from origins.start import Start

LEVEL_UNIT = 2.0**-40  # exposures (ln e) are drawn as whole multiples of this


class Births(NamedTuple):
    """The laws of contacts that form, in whole units."""

    thresholds: Table
    stretches: Table  # used if `drawn`
    single: np.int64  # the stretch of all contacts, if not `drawn`
    drawn: bool
    largest: np.int64  # upper end of the thresholds: larger stretches are drawn again
    purpose: np.int64  # of the random words


# runs with many seeds share the tables of the same contacts
_known: WeakKeyDictionary[Contacts, dict[str, Table]] = WeakKeyDictionary()


def tables_of(contacts: Contacts) -> dict[str, Table]:
    """Tables (lengths) of "thresholds" and, unless these are single values, "start" and "reforming"; made once.

    Raises InputError where they cannot be certified, and where stretches reach so far that the
    survival of the thresholds is below 1e-290.
    """
    if contacts not in _known:
        laws, thresholds = laws_of(contacts), contacts.thresholds
        furthest = max(abs(end) for law in laws.values() for end in law.span)
        # stretches beyond the largest threshold are drawn again, but the others may come close to it
        largest = thresholds.support()[1]
        rarest = float(thresholds.sf(min(furthest, np.nextafter(largest, 0.0))))
        if rarest < 1e-290 and furthest < largest:
            raise InputError(
                f"{' or '.join(laws)}: reaches |x| = {furthest:g}, where the survival of the thresholds is below "
                f"1e-290; use stretches that contacts can have reached, below {thresholds.isf(1e-290):.6g}"
            )
        found = {"thresholds": make_table(thresholds, max(DEEPEST * rarest, 1e-300))}
        spread = ((name, law) for name, law in laws.items() if not law.is_single)
        _known[contacts] = found | {name: make_table(law, name=name) for name, law in spread}
    return _known[contacts]


def laws_of(contacts: Contacts) -> dict[str, Start]:
    """Laws of the stretches at which contacts form: at X = 0, and later on unless they re-form relaxed."""
    again = contacts.reforming
    return {"start": contacts.start} | ({"reforming": again.law} if again else {})


def births_of(contacts: Contacts, unit: float) -> tuple[Births, Births]:
    """Births at X = 0 and later on, in whole multiples of the length `unit`."""
    tables = {name: table.in_units(unit) for name, table in tables_of(contacts).items()}
    largest = np.int64(min(contacts.thresholds.support()[1] / unit, float(FAR)))

    def make(name: str, purpose: np.int64) -> Births:
        law, stretches = laws_of(contacts).get(name), tables.get(name, tables["thresholds"])
        single = np.int64(round(law.mean() / unit) if law else 0)
        return Births(tables["thresholds"], stretches, single, name in tables, largest, purpose)

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
    return make_table(law).in_units(LEVEL_UNIT)


@inlined
def draw_stretches(n, row, turn, stream, births, scratch, r):  # type: ignore[no-untyped-def]
    """Stretches r at which n contacts form."""
    if not births.drawn:
        for i in range(unsigned(n)):
            r[i] = births.single
        return
    purpose, table = births.purpose + 16, births.stretches
    draw_values(n, row, turn, stream, purpose, table, scratch.stretches, scratch, r)
    for i in range(unsigned(n)):
        attempt = 0
        while abs(r[i]) >= births.largest:
            attempt += 1
            word, further, _, _ = words_at(i, turn + (attempt << 48), stream, purpose + 8 + row)
            r[i] = quantile(word, further, table)


@inlined
def draw_thresholds(n, row, turn, stream, births, scratch, r, x):  # type: ignore[no-untyped-def]
    """Thresholds x of n contacts that form at stretches r: P_c conditional on x_s > |r|."""
    purpose, table = births.purpose, births.thresholds
    draw_values(n, row, turn, stream, purpose, table, scratch.thresholds, scratch, x)
    below = False
    for i in range(unsigned(n)):
        below |= x[i] < abs(r[i])
    if below:
        for i in range(n):
            if x[i] < abs(r[i]):
                a, b, _, _ = words_at(i, turn, stream, purpose + 32 + row)
                x[i] = beyond(abs(r[i]), uniform(a, b), table, scratch.survival)
