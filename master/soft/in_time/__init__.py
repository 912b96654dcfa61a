"""Soft sliders whose contacts have laws that tell time: heat, ageing, growing grains, delay."""
