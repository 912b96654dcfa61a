"""F_k(v) at many speeds in one call, against single steady states."""

import numpy as np
import pytest

import master
from origins import Contacts, Delay, InputError, Thermal, gaussian, identical, rectangular

SPEEDS = np.geomspace(1e-6, 1e4, 200)


@pytest.mark.parametrize("law", ["soft", "stiff"])
@pytest.mark.parametrize("temperature", [0.001, 0.1])
@pytest.mark.parametrize("more", [{}, {"stiffness": "linked"}, {"delay": Delay(0.1)}])
def test_every_speed_is_the_steady_state_at_that_speed(law: str, temperature: float, more) -> None:
    contacts = Contacts(gaussian(1.0, 0.05), thermal=Thermal(law, temperature), **more)
    curve = master.kinetic_curve(contacts, SPEEDS)
    for i in (3, 60, 120, 190):
        steady = master.steady_state(contacts, velocity=float(SPEEDS[i]))
        assert curve.force[i] == pytest.approx(steady.force, rel=1e-9)
        assert abs(curve.force[i] - steady.force) <= curve.force_error[i] + steady.force_error
        assert curve.holding[i] == pytest.approx(steady.holding, rel=1e-9)
    assert (curve.force_error <= 1e-9 * curve.force).all()


def test_laws_summed_speed_by_speed_and_laws_without_speed() -> None:
    few = np.array([0.1, 1.0, 10.0])
    for thresholds in (identical(1.0), rectangular(0.5, 1.5)):
        for more in ({"thermal": Thermal("soft", 0.1, closure="paper")}, {"delay": Delay(0.1)}, {"reforming": 0.1}, {}):
            contacts = Contacts(thresholds, **more)
            curve = master.kinetic_curve(contacts, few)
            single = [master.steady_state(contacts, velocity=float(v)).force for v in few]
            np.testing.assert_allclose(curve.force, single, rtol=1e-12)
    with pytest.raises(InputError, match="velocity"):
        master.kinetic_curve(Contacts(gaussian(1.0, 0.1)), [1.0, 0.0])
