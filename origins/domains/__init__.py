"""Thresholds of crystalline domains that slide over a crystal: islands, substrates and barriers."""
