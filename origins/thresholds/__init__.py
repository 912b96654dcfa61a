"""Laws P_c(x) of breaking thresholds: what every law answers, and the families of them."""
