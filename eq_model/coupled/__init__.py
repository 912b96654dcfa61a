"""Coupled contacts: N of them on one soft slider, which a spring pulls (paper Sec. III E)."""
