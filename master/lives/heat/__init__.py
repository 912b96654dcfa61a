"""Contacts that also break below their thresholds, at a rate: (temper1) to (temper10)."""
