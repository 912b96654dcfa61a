"""Cut: a march that is continued from any of its moments along another motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from master.renewal import rule
from master.renewal.births import Births
from master.renewal.kernels import TARGETS
from master.renewal.lumps import Lump
from master.renewal.march import March
from master.renewal.run import Run

# Width, in grains, of the last panel of a time in which no contact is born.
SHORT = 1e-6


def cut(march: March, t: float, births: Births) -> March:
    """A march that has the contacts of this one at the time t; set its edges before it runs.

    births : along a motion that is the same up to t, of the same life and stretches
    """
    start = march.lumps[0]
    other = March(births, start.law, np.empty(0), march.tolerance, march.grain, march.stretch)
    other.kernels, other.until = march.kernels.along(births), march.until
    other.allowed = min(march.allowed, march.grain)
    births.work = march.births.work
    begun = int(np.searchsorted(march.begin, t - 1e-9 * march.grain))
    other.begin, other.width = march.begin[:begun], march.width[:begun]
    other.since = march.since[:begun]
    other.breaks, other.force = march.breaks[:begun], march.force[:begun]
    other.wrong = march.wrong[:begun]
    if begun and other.reached > t:
        width = t - other.begin[-1]
        to_part = rule.values(np.append(0.0, rule.NODES) * width / other.width[-1])
        other.width[-1] = width
        other.breaks[-1] = to_part @ other.breaks[-1]
        other.force[-1] = to_part @ other.force[-1]
    past = [lump for lump in march.lumps[1:] if lump.time < t]
    other.lumps = [replace(lump, holds=True) for lump in [start, *past]]
    return other


def hold(march: March, begin: float, end: float) -> None:
    """Add panels from begin to end without births: broken contacts are born together at the end."""
    number, _ = march.known(np.full((1, TARGETS.size), end))
    # the march looks for breaks at the end over half of the last panel, which has to be short
    nothing, nearly = np.zeros((1, rule.DEGREE + 1)), end - min(SHORT * march.grain, end - begin)
    late = float(march.motion.times[march.motion.leg(0.5 * (begin + end))])
    for first, last in ((begin, nearly), (nearly, end)):
        if last > first:
            run = Run(nothing, nothing, np.zeros(1))
            march.keep(first, last - first, run, 1, first - late)
    march.lumps.append(Lump(end, 1.0 - float(number[0, 0]), march.births.law))
