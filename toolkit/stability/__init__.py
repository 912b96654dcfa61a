"""Numerical stability: stiff and extreme cases through both solvers, each judged by a second road."""
