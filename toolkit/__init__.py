"""The four rooms put to work: scene files, runs, result files, pictures, the command line."""

__version__ = "0.1.0"
