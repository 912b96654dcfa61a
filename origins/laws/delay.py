"""Delay: how long a broken contact stays out before it forms again (paper, App. on delay effects)."""

from dataclasses import dataclass

from origins.errors import non_negative
from origins.laws.timed_law import TimedLaw


@dataclass(frozen=True)
class Delay(TimedLaw):
    """A broken contact carries no force for a time τ_m and then forms again (paper, Eq. Q5adelay).

    At a speed v the slider moves by v τ_m meanwhile. Of N contacts the fraction C/(C + v τ_m) holds in smooth sliding,
    C being the mean way between a contact's birth and its break.

    time : τ_m; 0: no delay.

    Raises InputError unless it is finite and not negative.
    """

    time: float

    while_holding = False

    def __post_init__(self) -> None:
        non_negative("time", self.time)
