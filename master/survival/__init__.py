"""Survival and force, after any motion, of contacts born at one moment: one file for each law."""
