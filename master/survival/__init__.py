"""Survival and force, after any motion, of contacts born at one instant: one file for each law."""
