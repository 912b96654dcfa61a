"""Heat that the master equation left out of a run: what it changes in F_k, beside the bound of its solver."""

from typing import Any

from origins.errors import InputError
from toolkit.results.of_heat import OF_RIGID, raised
from toolkit.results.records import SolvedRecord
from toolkit.scene.scene import Scene


def with_change_of_f_k(scene: Scene, solved: SolvedRecord) -> str:
    """The solver's note; where it is of heat that was left out, with what that changes in F_k at the drive's speed, as
    the bound may be a hundred times as large. The note alone where the drive has no one speed, or F_k no answer."""
    import master

    note, contacts = solved.note or "", scene.contacts
    velocity = scene.drive.velocity
    if solved.heat_left_out is None or scene.drive.time is not None:
        return note
    try:
        warm: Any = master.steady_state(contacts, velocity=velocity)
        cold: Any = master.steady_state(contacts.replace(thermal=None), velocity=velocity)
    except InputError:
        return note
    error = (warm.force_error + cold.force_error) * contacts.mean_threshold
    if abs(warm.force - cold.force) <= error:
        return f"{note}; it changes F_k{OF_RIGID} by less than its numerical error"
    return f"{note}; it {raised(warm.force, cold.force, scene.scale)}"
