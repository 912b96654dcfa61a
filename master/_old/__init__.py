"""The solvers that the new folders of master have not replaced yet; README.md says what replaces which."""
