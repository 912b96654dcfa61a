"""Errors of number conservation on panels of a lower degree, for tests/test_orders_panels.py, which runs this file:

    python order_of_panels.py DEGREE COUNT...

prints the largest error of the number of breaks for each count of panels, as JSON. `master.numerics.polynomials` is
loaded with `DEGREE` set so; thresholds follow the gamma law of shape 2, whose number of breaks has a closed form.
"""

import json
import sys
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from types import CodeType
from typing import Any

RULE, TOLD = "master.numerics.polynomials", b"\nDEGREE = 16\n"
END = 8.0


class OtherDegree(SourceFileLoader):
    """Loads a module as it is but for its degree; compiled code that is kept has the usual one, and is left alone."""

    degree: int

    def get_code(self, fullname: str) -> CodeType:
        source = self.get_data(self.path)
        if source.count(TOLD) != 1:
            raise SystemExit(f"{self.path} does not state its degree once")
        return self.source_to_code(
            source.replace(TOLD, b"\nDEGREE = %d\n" % self.degree), self.path
        )


class FindsRule:
    """Finds the module of polynomials where it is, for a loader with this degree."""

    def __init__(self, degree: int) -> None:
        self.degree = degree

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        found = PathFinder.find_spec(name, path, target) if name == RULE else None
        if found is not None and found.origin is not None:
            found.loader = loader = OtherDegree(name, found.origin)
            loader.degree = self.degree
        return found


def errors(degree: int, counts: list[int]) -> list[float]:
    """The largest error of the number of breaks over ten places of each panel, for each count of panels."""
    sys.meta_path.insert(0, FindsRule(degree))
    import numpy as np
    import scipy.stats

    from master.motion import Motion
    from master.numerics.polynomials import DEGREE
    from master.renewal.births import Births
    from master.renewal.march import March
    from master.rigid import breaks_until
    from master.survival.life import ColdLife
    from origins import Contacts
    from origins.start import SingleStart

    if degree != DEGREE:
        raise SystemExit(f"{RULE} has degree {DEGREE}, not {degree}")
    contacts = Contacts(scipy.stats.gamma(2.0, scale=0.5))
    life, motion = ColdLife(contacts), Motion(np.array([0.0, END]), np.array([0.0, END]))
    births = Births(life, SingleStart(0.0), motion, 0.0, 1e-15)
    found = []
    for count in counts:
        edges = np.linspace(0.0, END, count + 1)
        march = March(births, contacts.start, edges, 1e9, END).run()
        if march.solved.count != count:
            raise SystemExit(f"{march.solved.count} panels where {count} were asked for")
        at = (edges[:-1, None] + END / count * np.linspace(0.05, 0.95, 10)).ravel()
        exact = at - (1.0 - np.exp(-4.0 * at)) / 4.0
        found.append(float(np.abs(breaks_until(march, at) - exact).max()))
    return found


if __name__ == "__main__":
    first, *rest = map(int, sys.argv[1:])
    print(json.dumps(errors(first, rest)))
