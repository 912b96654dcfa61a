"""Scene files: what their tables and keys say, checked, and turned into calls."""
