"""Thresholds of rough surfaces: Greenwood and Williamson's contact, Persson's, measured and made heights."""
