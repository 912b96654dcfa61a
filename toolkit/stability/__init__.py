"""Numerical stability: stiff and extreme cases through both solvers, each judged by a second road.

In coverage.py and drawn*.py, how often the errors that solvers state hold the true one, over cases drawn at random
(`precision --coverage`).
"""
