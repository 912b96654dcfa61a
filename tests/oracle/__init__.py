"""The oracle: answers of the solvers as they were before they were rebuilt, and their judge.

`cases` lists calls of the public face of master, `answers.npz` holds what commit ee6a1b9 answered
to them, and `judge` writes such files and compares them; it says how it is run.
"""
