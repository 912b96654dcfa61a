"""Coupled contacts: N of them on one soft slider, which a spring pulls (paper Sec. III D)."""

from eq_model.coupled.ensemble import SLIP_FRACTION, CoupledEnsemble
from eq_model.coupled.result import CoupledResult, CoupledSlips

__all__ = ["SLIP_FRACTION", "CoupledEnsemble", "CoupledResult", "CoupledSlips"]
