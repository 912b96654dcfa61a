"""Whether answers agree: the two solvers with each other, tolerances with what they reach."""
