"""The paper's own schemes, as nearly as printed as is stable: its explicit step, its friction loop, and its system
of ageing (Q15). They are of low order; `master.solve` is the accurate method."""
