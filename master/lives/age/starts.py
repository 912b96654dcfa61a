"""How many stretches stand for a law of stretches, at which contacts that age are born."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from master.lives.stretch_rule import StretchRule, stretch_rule
from origins import Contacts
from origins.start import Start

Array = npt.NDArray[np.float64]

# Numbers of stretches, tried one after the other: with the last of them a start across 0, where
# survivals bend, is good to some 1e-8.
COUNTS = (6, 9, 13, 19, 28)


class StretchRules:
    """Gauss rules for laws of stretches, with as many nodes as the survivals ask for.

    Parameters
    ----------
    contacts : Contacts
    accuracy : float
        Error of the share that holds that is aimed at.
    shares : callable
        What holds, at many moments, of contacts born at the stretches of a rule: array of any
        length, the same for every rule.

    Attributes
    ----------
    error : float
        By what the rules' shares changed last.
    """

    def __init__(
        self, contacts: Contacts, accuracy: float, shares: Callable[[StretchRule], Array]
    ) -> None:
        self._most, self._accuracy, self._shares = (
            contacts.thresholds.support()[1],
            accuracy,
            shares,
        )
        self.error = 0.0
        self._known: list[tuple[Start, StretchRule]] = []

    def of(self, born: Start) -> StretchRule:
        """The rule for stretches of the law `born`; the same object has the same rule."""
        for known, rule in self._known:
            if known is born:
                return rule
        rule = stretch_rule(born, self._most, COUNTS[0])
        if rule.stretch.size > 1:
            before, missed = self._shares(rule), np.inf
            for count in COUNTS[1:]:
                rule = stretch_rule(born, self._most, count)
                now = self._shares(rule)
                missed, before = float(np.abs(now - before).max()), now
                if missed <= self._accuracy:
                    break
            self.error = max(self.error, missed)
        self._known.append((born, rule))
        return rule
