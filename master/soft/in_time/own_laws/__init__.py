"""Contacts that follow a law of one's own under a spring: their memory follows from what the law states for a rigid
slider.

    ordered.py   its birth_threshold               E = S(largest threshold at birth that was met)
    of_life.py   the life of any other law         E of the way since the birth, step after step
    along.py     what steps resolve
"""
