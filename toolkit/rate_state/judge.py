"""Rate and state of one scene, at its speed, in the scene's units."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from master import RateState
from origins.errors import InputError
from toolkit.scene.scale import Scale
from toolkit.scene.scene import Scene

# times at rest, in mean thresholds over the speed: eight decades
SHORTEST_REST, LONGEST_REST, RESTS = 1e-2, 1e6, 9
# of K*, relative to 1 + K*
TOLERANCE = 1e-3


@dataclass(frozen=True)
class Judged:
    """What rate and state says of a scene; K* is that of contacts that move forward from the scene's start.

    mean_threshold : <x_s>, a length; critical_spring : K*/(N_c <k>), and its error, NaN where it is not known
    """

    name: str
    title: str
    scale: Scale
    found: RateState
    mean_threshold: float
    critical_spring: float
    critical_spring_error: float


def judge(
    scene: Scene,
    progress: Callable[[str], None],
    known: Callable[[Callable[[], Judged]], None] = lambda so_far: None,
) -> Judged:
    """Solve velocity steps and rests of the scene's contacts at its speed. `known` is as that of master.rate_state, K*
    not being known then. Raises InputError as master.rate_state."""
    import master

    def judged(found: RateState, spring: float = np.nan, error: float = np.nan) -> Judged:
        """Of an answer and its K*."""
        title = scene.title or scene.name
        return Judged(scene.name, title, scene.scale, found, mean, spring, error)

    if not scene.contacts.in_time:
        why = "contacts: a = b = 0: their force does not depend on the speed"
        raise InputError(
            f'{why}; give them a law in time, such as [contacts.thermal] law = "eyring", width = 0.03'
        )
    contacts, velocity, mean = scene.contacts, scene.sliding, scene.contacts.mean_threshold
    rests = mean / velocity * np.geomspace(SHORTEST_REST, LONGEST_REST, RESTS)
    found = master.rate_state(
        contacts,
        velocity,
        rests=rests,
        progress=progress,
        known=lambda so_far: known(lambda: judged(so_far())),
    )
    progress("the critical spring K*")
    line = master.phase_line(contacts, velocity, tolerance=TOLERANCE)
    return judged(found, float(line.critical_spring), float(line.critical_spring_error))
