"""The command `mesofriction rate-state`: a, b and D_c of a scene's contacts, beside the law of rate and state."""
