"""What do many discrete contacts do? Event-driven kernels, their layout over ranks, the ensemble."""

from eq_model.ensemble import Ensemble, EnsembleResult, simulate

__all__ = ["Ensemble", "EnsembleResult", "simulate"]
