"""Thresholds of grains that coalesce in a lubricant film (Lifshitz and Slyozov)."""
