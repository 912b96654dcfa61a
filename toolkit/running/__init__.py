"""Runs: from a scene to its answers, with checkpoints, ranks, signals and progress."""
