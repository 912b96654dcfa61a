"""Stick-slip: how prone contacts are to it, and how fast a start is forgotten."""
