"""How the slider moves, and what contacts born at one moment have gone through by another."""
