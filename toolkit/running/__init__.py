"""Runs: from a scene to its answers, with checkpoints and progress."""
