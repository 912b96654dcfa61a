"""Contacts whose thresholds diffuse independently as they grow older: (L), (B) and Sec. V."""
