"""Slip rules under which sliders of the area's contacts do the same as under another, and are not followed again."""

from collections.abc import Iterable
from dataclasses import replace

from origins.contacts import Contacts
from toolkit.verdict.sliders.records import Behaviour, Finite

# of a force: two that differ by less are one
ONE_FORCE = 1e-6
# slip rules that renew contacts after a slip
RENEWING = {"reset", "reform-after"}


def told_by_another_rule(
    one: Behaviour, before: Iterable[tuple[Behaviour, Finite]], contacts: Contacts
) -> Finite | None:
    """What the contacts of the area do under the rule of `one`, by those followed `before` under another, each beside
    what infinitely many do; None where none tells it.

    Where nobody slips no rule acts. Contacts that break by heat or grow are dear, and count so; others are followed
    under each rule, as on soft springs small avalanches raise the force of those that re-form at once. Where each slip
    leaves no force all contacts have broken in it, and begin anew by both rules, if they do not wait.
    """
    for other, seen in before:
        if other.kind != one.kind or other.heat_left_out != one.heat_left_out:
            continue
        known = seen.kind in ("smooth", "unknown")  # nor would there be time for them
        nobody = known and one.kind == "smooth" and not (seen.slips or one.slips or other.slips)
        emptied = (one.after, other.after, seen.after, seen.after_error) == (0.0, 0.0, 0.0, 0.0)
        alike = abs(one.before - other.before) <= ONE_FORCE * abs(other.before)
        renewed = {one.rule, other.rule} == RENEWING and not contacts.waiting_time
        slips = seen.kind == one.kind == "stick-slip" and emptied and alike and renewed
        if slips or (nobody and contacts.held_in_time and not seen.rises):
            return replace(seen, rule=one.rule)
    return None
