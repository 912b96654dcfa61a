"""Coupled contacts on a soft slider that has a mass: M X'' + γ X' = K (X_T - X) - F."""
