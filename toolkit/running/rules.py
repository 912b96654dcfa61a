"""The other slip rules on the spring of a run: whether the verdict hangs on the rule."""

import time
from typing import Any, get_args

from origins.drive import SlipRule
from origins.errors import InputError
from toolkit.results.kinds import is_known_without_heat
from toolkit.results.records import SolvedRecord
from toolkit.scene.scene import Scene

# of the force, in mean thresholds: enough for a verdict; s for each of the other rules
_TOLERANCE, SECONDS = 1e-4, 5.0
# a first slip that lowers the force by a smaller share is told: a reset renews all contacts for a few that break
_SMALL = 0.1


def beside_other_rules(scene: Scene, solved: SolvedRecord, deadline: float | None) -> list[str]:
    """Notes on a slider that slips: the verdict of each slip rule, where they differ, and that of few contacts' slips.

    Until the first slip all rules are the same: without one there is nothing to say. Laws in time, but for heat that is
    left out, are not looked at, nor rules that the solver does not take or does not finish in some seconds. `deadline`:
    s of the monotonic clock.
    """
    import master

    drive, contacts, own = scene.drive, scene.contacts, scene.drive.slip
    # with laws in time a solve takes seconds to minutes
    followed = contacts if solved.heat_left_out is None else contacts.replace(thermal=None)
    if own is None or not solved.slips.drive.size or followed.in_time:
        return []
    verdicts, answers = {own: solved.regime.verdict}, dict[str, Any]({own: solved})
    for rule in set(get_args(SlipRule)) - {own}:
        seconds = SECONDS if deadline is None else min(SECONDS, deadline - time.monotonic())
        if seconds <= 0.0:
            break
        asked = drive.keywords() | {"slip": rule, "wall_time": seconds}
        try:
            answers[rule] = master.solve(contacts, scene.path, _TOLERANCE, **asked)
        except InputError:
            continue
        if answers[rule].success or is_known_without_heat(answers[rule]):
            verdicts[rule] = answers[rule].regime.verdict
    decided = {rule: verdicts[rule] for rule in get_args(SlipRule) if rule in verdicts}
    decided = {rule: verdict for rule, verdict in decided.items() if verdict != "undecided"}
    notes = []
    if len(set(decided.values())) > 1:
        each = ", ".join(f'{verdict} with "{rule}"' for rule, verdict in decided.items())
        notes.append(
            f"the slip rule decides: {each}; in nature mass, damping and the contacts' delay do (docs/sliders.md)"
        )
    slips = getattr(answers.get("reform-after"), "slips", None)
    if own == "reset" and slips is not None and slips.drive.size:
        fraction = float(slips.drop[0] / slips.force_before[0])
        if fraction < _SMALL:
            notes.append(
                f"the first slip is small: it lowers the force by {fraction:.2g} of it while broken contacts are out "
                '("reform-after"), and "reset" renews all contacts for it; that is no stick-slip of them all'
            )
    return notes
