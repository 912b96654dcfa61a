"""What sliders do: those of infinitely many contacts, and those of as many as the area holds."""
