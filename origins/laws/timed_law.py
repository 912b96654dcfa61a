"""What solvers ask of a contact's laws beside their equations: what time changes, and what goes together.

A law states each of these traits once, beside its equation. Solvers ask for the trait and never for the law's name, so
that a new law needs no change where another law is asked the same.
"""

from __future__ import annotations

from typing import ClassVar

from origins.thresholds.law import Thresholds

# The thermal closure "paper", all contacts breaking at one mean rate: no law of its own, but laws exclude it.
MEAN_RATE = "mean rate"
EXACT = 'use closure = "exact"'
LINKED = "stiffness = 'linked': not defined with"


class TimedLaw:
    """A law under which what contacts do depends on time, and not only on the way that the slider has gone.

    while_holding : whether that is so of contacts that hold; False where time matters to broken ones alone
    apart : the laws that do not go beside it, by their names in origins.contacts.LAWS or as MEAN_RATE, and for each the
        message that says why
    """

    while_holding = True

    @property
    def apart(self) -> dict[str, str]:
        """Of a law that all others may stand beside: none."""
        return {}


class ChangingThresholds(TimedLaw):
    """A law by which the threshold of a contact changes while the contact holds: the contact has a memory of its own.

    A solver has a life, a memory under a spring and a kernel for each such law, by its class: LIVES in
    master/survival/make.py, MEMORIES in master/soft/in_time/changing.py, KERNELS in eq_model/laws/settings.py.

    law : its name in Contacts.laws and in messages
    first_pinning_time : time after a break, and after the delay, until a new contact can hold; `waiting` says why
    older_at_start : whether contacts of the start are older than those that have just formed, and live longer
    keeps_tail : whether strong contacts stay strong, so that a heavy tail of P_c makes the kinetic force infinite
    """

    law: ClassVar[str]
    first_pinning_time: float = 0.0
    waiting = ""
    older_at_start = False
    keeps_tail = False

    def __str__(self) -> str:
        """The law in words, for a list of the laws that contacts have."""
        raise NotImplementedError

    def largest_threshold(self, fresh: float, share: float, duration: float) -> float:
        """The largest threshold up to the time `duration`, but for this share of the contacts; `fresh`: that at t = 0
        (lengths)."""
        raise NotImplementedError

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """About the threshold that decides how far the oldest contacts are stretched at the time `duration`; `fresh`:
        their mean threshold at t = 0 (lengths)."""
        raise NotImplementedError

    @property
    def further_laws(self) -> dict[str, Thresholds]:
        """Laws of thresholds that contacts have beside P_c, by the names of the parameters that gave them."""
        return {}
