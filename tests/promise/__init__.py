"""Seeded cases of every kind for the promise on force_error, and references from another tree.

PYTHONPATH=.:tests, as for the oracle; see promise.references.
"""
