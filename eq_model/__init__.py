"""What do many discrete contacts do? Event-driven kernels, their layout over ranks, the ensemble."""

from eq_model.coupled import CoupledEnsemble, CoupledResult, CoupledSlips
from eq_model.ensemble import Ensemble, simulate
from eq_model.ensemble_result import EnsembleResult

__all__ = ["CoupledEnsemble", "CoupledResult", "CoupledSlips", "Ensemble", "EnsembleResult", "simulate"]
