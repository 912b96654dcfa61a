"""The version of this package, where each of its files may read it."""

__version__ = "0.1.0"
