"""Processes that run together or are ended from outside: ranks, signals, time limits."""
