"""The numbers of rate and state, a, b and D_c, of contacts whose force depends on time."""
