"""Smooth sliding: the state that no longer depends on X, at one speed and along many."""
