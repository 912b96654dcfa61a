"""What solvers ask of a contact's laws beside their equations: what time changes, and what goes together.

A law states each of these traits once, beside its equation. Solvers ask for the trait and never for the law's name, so
that a new law needs no change where another law is asked the same.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NoReturn

from origins.errors import InputError
from origins.thresholds.law import Thresholds

# The thermal closure "paper", all contacts breaking at one mean rate: no law of its own, but laws exclude it.
MEAN_RATE = "mean rate"
EXACT = 'use closure = "exact"'
LINKED = "stiffness = 'linked': not defined with"
# The share of the contacts above a typical threshold.
HALF = 0.5


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


class ChangingThresholds(TimedLaw, ABC):
    """A law by which the threshold of a contact changes while the contact holds: the contact has a memory of its own.

    It stands in place of thresholds in origins.Contacts, but for Ageing, which stands beside them. A solver has a life
    and a kernel for each such law, by its class: LIVES in master/survival/make.py, KERNELS in
    eq_model/laws/settings.py. Under a spring the life is asked, too, but for the quicker memories of MEMORIES in
    master/soft/in_time/changing.py.

    law : its name in Contacts.laws and in messages
    at_start : P_c of all contacts at X = 0
    first_pinning_time : time after a break, and after the delay, until a new contact can hold; `waiting` says why
    older_at_start : whether contacts of the start are older than those that have just formed, and live longer
    begins_as_start : whether contacts that form later have thresholds from at_start, and keep them in a slip that takes
        no time; False where the law does not say
    keeps_tail : whether strong contacts stay strong, so that a heavy tail of P_c makes the kinetic force infinite
    """

    law: ClassVar[str]
    at_start: Thresholds
    first_pinning_time: float = 0.0
    waiting = ""
    older_at_start = False
    begins_as_start = False
    keeps_tail = False
    # what each object has to have before its methods are called, where it gets that, and the class that says so
    _to_state: ClassVar[tuple[str, ...]] = ("law", "at_start")
    _stated_where: ClassVar[str] = "set them in the class or in its __init__"
    _stated_by: ClassVar[str] = "ChangingThresholds"

    @property
    def apart(self) -> dict[str, str]:
        """See TimedLaw: all that a life, a memory or a kernel would have to know of."""
        there = f"contacts.{self.law}: its solvers take no"
        names = ("thermal", "ageing", "reforming", "stiffness")
        return {name: f"{there} {name} beside it; leave one out" for name in names}

    def __str__(self) -> str:
        """The law in words, for a list of the laws that contacts have."""
        return f"thresholds that change by {self.law}"

    def check_stated(self) -> None:
        """InputError where a subclass has set no value for what is needed before its methods are called."""
        lacking = [name for name in self._to_state if not hasattr(self, name)]
        if lacking:
            self._refuse(f"not set: {', '.join(lacking)}; {self._stated_where}")
        if not isinstance(self.at_start, Thresholds):
            self._refuse(
                "at_start must be a law of origins; write origins.Contacts(law).thresholds"
            )

    @abstractmethod
    def largest_threshold(self, fresh: float, share: float, duration: float) -> float:
        """The largest threshold up to the time `duration`, but for this share of the contacts; `fresh`: that at t = 0
        (lengths)."""

    def typical_threshold(self, fresh: float, duration: float) -> float:
        """About the threshold that decides how far the oldest contacts are stretched at the time `duration`; `fresh`:
        their mean threshold at t = 0 (lengths)."""
        return self.largest_threshold(fresh, HALF, duration)

    @property
    def further_laws(self) -> dict[str, Thresholds]:
        """Laws of thresholds that contacts have beside P_c, by the names of the parameters that gave them."""
        return {}

    def _refuse(self, fault: str) -> NoReturn:
        """InputError for a law that is not what its class says; it is named by `law`, as its repr says nothing."""
        named = getattr(self, "law", type(self).__name__)
        raise InputError(f"thresholds ({named}): {fault}; see origins.{self._stated_by}")
