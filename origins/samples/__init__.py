"""Thresholds from samples: smooth laws of given values, and the sampling error they leave."""
