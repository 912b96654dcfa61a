"""Run a scene: each solver it names, and no other."""

from collections.abc import Callable, Mapping
from os import PathLike
from typing import Any

import toolkit
from toolkit import laws
from toolkit.interfaces import of_interface, remarks
from toolkit.results import Result, Simulated, Solved, ageing_record, sample_curve, soft_record
from toolkit.scene import EqTable, MasterTable, Scene, load_scene


def run(
    scene: Scene | Mapping[str, Any] | str | PathLike[str],
    comm: Any = None,
    progress: Callable[[int, int], None] | None = None,
) -> Result:
    """Solve what the scene asks for.

    Parameters
    ----------
    scene : dict, path or name of a shipped scene
    comm : mpi4py communicator, optional
        Sampling of thresholds and the ensemble's work are shared among its ranks, all of which must call; None: this
        process alone.
        Every rank gets the whole result.
    progress : callable, optional
        Called as progress(done, total) after each block of the ensemble, with this rank's contacts.

    Raises InputError for a scene that cannot be run.
    """
    scene = load_scene(scene, comm=comm)
    interface = scene.contacts.interface
    master = None if scene.master is None else _solve(scene, scene.master)
    eq = None if scene.eq is None else _simulate(scene, scene.eq, comm, progress)
    return Result(
        name=scene.name,
        title=scene.title,
        text=scene.text,
        version=toolkit.__version__,
        mean_threshold=scene.contacts.mean_threshold,
        thresholds=sample_curve(scene.contacts.thresholds),
        master=master,
        eq=eq,
        notes=tuple(remarks(scene.contacts.thresholds) + _beside(scene)),
        interface=None if interface is None else of_interface(interface),
    )


def _beside(scene: Scene) -> list[str]:
    """What the numbers of the surface leave out of the contacts."""
    contacts = scene.contacts
    laws_of = {"temperature": contacts.thermal, "ageing": contacts.ageing, "delay": contacts.delay}
    there = [name for name, law in {**laws_of, "re-forming": contacts.reforming}.items() if law is not None]
    if contacts.interface is None or not there:
        return []
    return [f"F_k/load and the stress of the surface are those of its thresholds alone, without {', '.join(there)}"]


def _solve(scene: Scene, asked: MasterTable) -> Solved:
    import master

    drive, contacts, path, tolerance = scene.drive, scene.contacts, scene.path, asked.tolerance
    paced: dict[str, Any] = {"velocity": drive.velocity, "time": drive.time}
    with laws.inside("master", {"tolerance": "tolerance"}):
        if drive.spring is None:
            solved: Any = master.solve(contacts, path, tolerance, **paced)
            return ageing_record(solved) if hasattr(solved, "mass_defect") else solved
        return soft_record(master.solve(contacts, path, tolerance, **paced, spring=drive.spring, slip=drive.slip))


def _simulate(scene: Scene, asked: EqTable, comm: Any, progress: Callable[[int, int], None] | None) -> Simulated:
    import eq_model

    with laws.inside("eq", {"n_contacts": "contacts", "n_replicas": "replicas", "seed": "seed"}):
        ensemble = eq_model.Ensemble(
            scene.contacts,
            scene.path,
            n_contacts=asked.contacts,
            n_replicas=asked.replicas,
            seed=asked.seed,
            comm=comm,
        )
        for done, total in ensemble:
            if progress is not None:
                progress(done, total)
        return ensemble.result()
