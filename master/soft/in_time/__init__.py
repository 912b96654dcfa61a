"""Soft sliders whose contacts have laws that depend on time: heat, ageing, growing grains, delay."""
