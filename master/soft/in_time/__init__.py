"""Soft sliders in steps of time: heat, ageing, growing grains, delay; re-forming backward and turns."""
