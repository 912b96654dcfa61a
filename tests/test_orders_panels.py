"""Order of convergence of number conservation on panels, fitted: degree + 1.

At the degree that is used, 16, errors come to round-off before the order has settled. The same code
with `DEGREE` set to 3, 4 and 5 as it is read shows the order.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import ended, slow

SCRIPT = Path(__file__).with_name("order_of_panels.py")


@pytest.mark.parametrize(
    ("degree", "counts"), [slow(3, (128, 256, 512)), slow(4, (96, 192, 384)), (5, (60, 90, 135))]
)
def test_the_order_is_one_more_than_the_degree(tmp_path: Path, degree: int, counts: tuple) -> None:
    """Breaks of thresholds of the gamma law of shape 2, whose number has a closed form."""
    words = map(str, (degree, *counts))
    done = ended([sys.executable, str(SCRIPT), *words], tmp_path)
    assert done.returncode == 0, done.stderr
    order = -np.polyfit(np.log(counts), np.log(json.loads(done.stdout)), 1)[0]
    assert abs(order - (degree + 1)) <= 0.2, order
