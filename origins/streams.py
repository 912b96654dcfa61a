"""The key of random streams that depend on the seed and their use alone, not on the rank or the order of drawing."""

from origins.errors import refuse, whole


def key_of(seed: object) -> tuple[int, int]:
    """The two key words of a seed; InputError unless it is a whole number of at least 0 and below 2^64."""
    number = whole("seed", seed, 0)
    if number >= 1 << 64:
        refuse("seed", seed, "must be below 2^64")
    return number & 0xFFFFFFFF, number >> 32
