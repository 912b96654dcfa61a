"""What do many discrete contacts do? Event-driven kernels, their layout over ranks, the ensemble."""

from eq_model.ensemble import Ensemble, simulate
from eq_model.ensemble_result import EnsembleResult

__all__ = ["Ensemble", "EnsembleResult", "simulate"]
