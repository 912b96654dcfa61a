"""A soft slider: a spring between the drive and the slider, and what its slips do."""
