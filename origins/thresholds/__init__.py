"""Laws P_c(x) of breaking thresholds: the methods of every law, and the families of laws."""
