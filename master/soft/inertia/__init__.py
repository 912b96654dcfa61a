"""A soft slider with a mass, M X'' + γ X' = K (X_T - X) - F."""
