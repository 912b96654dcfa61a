"""Laws of how contacts break below their threshold, one file each."""
