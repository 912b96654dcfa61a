"""What do many discrete contacts do? Compiled loops over contacts, spread over threads and ranks."""

from eq_model.ensemble import CoupledEnsemble, Ensemble
from eq_model.result import (
    CoupledResult,
    CoupledSlips,
    Energy,
    EnsembleResult,
    HeavyResult,
    HeavySlips,
)
from eq_model.simulate import simulate

__all__ = ["CoupledEnsemble", "CoupledResult", "CoupledSlips", "Energy", "Ensemble"]
__all__ += ["EnsembleResult", "HeavyResult", "HeavySlips", "simulate"]
