"""What is left, after any motion, of contacts born at one moment: one file a law."""
