"""The oracle: calls of master, and what commit ee6a1b9 answered to them before the rebuild.

`answers.npz` holds each call as a text, such as `force(Contacts(gaussian(1, 0.2)), [0, 1], 1e-6)`,
with its answer. `calls` answers such texts, and `judge` compares answers.
"""
