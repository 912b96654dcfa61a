"""What do many discrete contacts do? Event-driven kernels, their layout over ranks, the ensemble."""

from eq_model.coupled import CoupledEnsemble, CoupledResult, CoupledSlips
from eq_model.ensemble import Ensemble
from eq_model.ensemble_result import EnsembleResult
from eq_model.simulate import simulate

__all__ = [
    "CoupledEnsemble",
    "CoupledResult",
    "CoupledSlips",
    "Ensemble",
    "EnsembleResult",
    "simulate",
]
