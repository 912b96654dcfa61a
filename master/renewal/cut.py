"""Cut: a march that is continued from any of its moments along another motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from master.renewal import rule
from master.renewal.births import Births, Lump
from master.renewal.kernels import TARGETS, Run
from master.renewal.march import March


def cut(march: March, t: float, births: Births) -> March:
    """A march that has the contacts of this one at the time t; set its edges before it runs.

    births : along a motion that is the same up to t, of the same life and stretches
    """
    start = march.lumps[0].law
    given = births, start, np.empty(0), march.tolerance, march.grain, march.stretch, march.until
    other = March(*given)
    # the life is timeless: the kernels of one motion are those of all
    other.kernels, births.work = march.kernels, march.births.work
    other.widest = min(march.widest, march.grain)
    begun = int(np.searchsorted(march.begin, t - 1e-9 * march.grain))
    for name in ("begin", "since", "width", "breaks", "force", "wrong"):
        setattr(other, name, getattr(march, name)[:begun])
    if begun and other.reached > t:
        width = t - other.begin[-1]
        to_part = rule.values(np.append(0.0, rule.NODES) * width / other.width[-1])
        other.width[-1] = width
        other.breaks[-1] = to_part @ other.breaks[-1]
        other.force[-1] = to_part @ other.force[-1]
    past = [lump for lump in march.lumps[1:] if lump.time < t]
    other.lumps = [replace(lump, holds=True) for lump in [march.lumps[0], *past]]
    return other


def hold(march: March, begin: float, end: float) -> None:
    """Add panels from begin to end without births: broken contacts are born together at the end."""
    number, _ = march.known(np.full((1, TARGETS.size), end))
    # the march looks for breaks at the end over half of the last panel, which has to be short
    nothing, nearly = np.zeros((1, rule.DEGREE + 1)), end - min(1e-6 * march.grain, end - begin)
    late = float(march.motion.times[march.motion.leg(0.5 * (begin + end))])
    for first, last in ((begin, nearly), (nearly, end)):
        if last > first:
            run = Run(nothing, nothing, np.zeros(1))
            march.keep(first, last - first, run, 1, first - late)
    march.lumps.append(Lump(end, 1.0 - float(number[0, 0]), march.births.law))
