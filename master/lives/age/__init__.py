"""Contacts whose thresholds diffuse as they grow older: (L), (B) and Sec. V, each by itself."""
