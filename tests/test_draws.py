"""Draws of whole rows against their plain twin, a word at a time, and against the law's own quantiles."""

import numpy as np
import pytest
import scipy.stats
from conftest import slow

import origins
from eq_model.compiling import compiled
from eq_model.draws.births import births_of, draw_values, make_scratch, plain_values
from eq_model.draws.streams import LANES, ROW, make_stream, words_at
from eq_model.draws.tables import FAR

LAWS = {
    "gaussian": origins.gaussian(1.0, 0.2),
    "gap": origins.mixture(
        [scipy.stats.uniform(0.5, 0.1), scipy.stats.uniform(2.0, 1.0)], [0.3, 0.7]
    ),
    "atoms": origins.mixture([origins.identical(0.8), origins.identical(1.2)], [0.5, 0.5]),
    "heavy tail": scipy.stats.lomax(2.5),
}


@compiled
def _row(row, turn, stream, births, scratch, out, further):  # type: ignore[no-untyped-def]
    purpose, table, words = births.purpose, births.thresholds, scratch.thresholds
    draw_values(LANES, row, turn, stream, purpose, table, words, scratch, out)
    for i in range(LANES):
        further[i] = words_at(i, turn, stream, purpose + 4 + row)[0]


@pytest.mark.parametrize("name", [slow(name, when=name == "gap") for name in LAWS])
def test_rows_are_those_of_the_plain_twin(name: str) -> None:
    contacts = origins.Contacts(LAWS[name])
    unit = 2.0**-28 * contacts.mean_threshold
    births, stream, scratch = births_of(contacts, unit)[0], make_stream(7, 3), make_scratch()
    out, further = np.zeros(LANES, np.int64), np.zeros(LANES, np.uint32)
    words, bits, values = [], [], []
    for k in range(40):
        _row(np.int64(k % 4), np.int64(k // 4), stream, births, scratch, out, further)
        row = k % 4 * ROW
        words.append(scratch.thresholds[row : row + LANES].copy())
        bits.append(further.copy())
        values.append(out.copy())
    word, more, drawn = (np.concatenate(rows) for rows in (words, bits, values))
    assert plain_values(word, more, births.thresholds) == drawn.tolist()
    assert np.sum((word & 0x7FFFFFFF) < 1 << 20) > 3  # values that the quick cells do not contain
    assert abs(drawn).max() < FAR

    # the law's own quantiles of the same random numbers; where a law jumps those beside
    law, v = contacts.thresholds, ((word & 0x7FFFFFFF) + 0.5) * 2.0**-32
    for side, tail, inverse in ((0, law.cdf, law.ppf), (1, law.sf, law.isf)):
        on = word >> 31 == side
        x, share = drawn[on] * unit, v[on]
        near = np.abs(tail(x) - share) < 1e-6 * share + 2.0 * unit * law.pdf(x)
        # a tail's v has further bits than the word
        tails = share < 2.0**-11
        beside = np.abs(x - inverse(share)) < 4.0 * unit
        assert (near | tails | beside).all()
