"""The paper's own schemes, as printed: its explicit step, its friction loop, and its system of
ageing (Q15). Plain and of low order; `master.solve` is the accurate road."""
