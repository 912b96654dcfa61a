"""Order of convergence of number conservation on panels, fitted: degree + 1.

At the degree that is used, 16, errors come to round-off before the order has settled. The same code
with `DEGREE` set to 3, 4 and 5 as it is read shows the order.
"""

import json
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
TOLD = "\nDEGREE = 16\n"
LOWER = """
import json, sys, types
from pathlib import Path

name, degree, counts = "master.numerics.polynomials", *json.loads(sys.argv[1])
rule = sys.modules[name] = types.ModuleType(name)
text = Path(sys.argv[2]).read_text(encoding="utf-8")
exec(text.replace("\\nDEGREE = 16\\n", f"\\nDEGREE = {degree}\\n"), rule.__dict__)

import numpy as np
import scipy.stats

import master.numerics
master.numerics.polynomials = rule
from master.survival.life import ColdLife
from master.motion import Motion
from master.renewal.births import Births
from master.renewal.march import March
from master.rigid import breaks_until
from origins import Contacts
from origins.start import SingleStart

END = 8.0
contacts = Contacts(scipy.stats.gamma(2.0, scale=0.5))
life, motion = ColdLife(contacts), Motion(np.array([0.0, END]), np.array([0.0, END]))
births = Births(life, SingleStart(0.0), motion, 0.0, 1e-15)
errors = []
for count in counts:
    edges = np.linspace(0.0, END, count + 1)
    march = March(births, contacts.start, edges, 1e9, END, life.largest_stretch).run()
    assert len(march.width) == count
    at = (edges[:-1, None] + END / count * np.linspace(0.05, 0.95, 10)).ravel()
    exact = at - (1.0 - np.exp(-4.0 * at)) / 4.0
    errors.append(np.abs(breaks_until(march, at) - exact).max())
print(json.dumps(errors))
"""


@pytest.mark.parametrize(
    ("degree", "counts"),
    [
        (3, (128, 256, 512)),
        pytest.param(4, (96, 192, 384), marks=pytest.mark.slow),
        (5, (80, 120, 180)),
    ],
)
def test_the_order_is_one_more_than_the_degree(python, degree: int, counts: tuple) -> None:
    """Breaks of thresholds of the gamma law of shape 2, whose number has a closed form."""
    rule = ROOT / "master" / "numerics" / "polynomials.py"
    assert rule.read_text(encoding="utf-8").count(TOLD) == 1
    done = python(LOWER, json.dumps([degree, counts]), str(rule))
    assert done.returncode == 0, done.stderr
    order = -np.polyfit(np.log(counts), np.log(json.loads(done.stdout)), 1)[0]
    assert abs(order - (degree + 1)) <= 0.2, order
