"""Thresholds from samples: smooth laws through given values, and their sampling errors."""
