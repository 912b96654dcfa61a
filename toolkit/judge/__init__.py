"""Judgements: comparison of scenes, numbers of threshold laws, error against run time."""
