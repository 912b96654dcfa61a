"""Re-forming: the law R of the stretch at which a broken contact forms again, where it is not simply x = 0."""

import numpy as np

from origins.errors import TEMPERATURE, positive
from origins.start import Start, gaussian_start


def boltzmann_reforming(temperature: float) -> Start:
    """R(x) ~ exp(-x²/2T), the normal law of width T^(1/2) = (k_BT/<k>)^(1/2) about x = 0 (paper, Sec. IV).

    temperature : k_BT/<k>, a length squared. With linked stiffness too the width is that of <k>: a contact's stretch
    is drawn before its threshold, on which its own k_i depends.
    Raises InputError unless it is finite and above zero.
    """
    return gaussian_start(0.0, float(np.sqrt(positive("temperature", temperature, TEMPERATURE))))
