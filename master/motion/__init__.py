"""How the slider moves, and the moves of contacts between their birth and a later moment."""
