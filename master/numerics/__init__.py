"""Quadrature and polynomials that know nothing of contacts: panels, tables, averages over a law."""
