"""The numbers of rate and state, a, b and D_c, of contacts whose force depends on time.

In reading order: `result.py`, what is found; `estimate.py`, which asks for all of it; `speeds.py`, F_k at many speeds;
`traces.py`, the force after velocity steps and rests; `reading.py`, a, b and D_c read from these; `law.py`, the law
that they fit; `rests.py`, healing; and `critical_spring.py`, on which spring steady sliding gets unstable, by the
solved answer of the force to a small step.
"""
