"""The command's work: rate and state of a scene into a folder, what is known of it if it is stopped."""

from collections.abc import Callable, Sequence
from contextlib import closing

from origins.errors import InputError
from toolkit.judge.files import save_judgement
from toolkit.processes.signals import Terminated, TimeIsUp
from toolkit.rate_state.files import answers, plain
from toolkit.rate_state.judge import Judged, judge
from toolkit.rate_state.picture import draw_rate_state
from toolkit.rate_state.words import page
from toolkit.results.folders import check_folder
from toolkit.running.progress import Progress
from toolkit.running.solvers import within
from toolkit.scene.scene import Scene

# s that the shipped scene takes in all, some half of them for its steps (docs/commands.md)
_SCENE = 70.0


def _too_late(begun: Sequence[str]) -> str:
    """Which part was not solved as the time was over, before which nothing is known, and what others take."""
    at = f"it ended in its {begun[-1]}, before which nothing is known; " * bool(begun)
    return (
        f"{at}the scene rate-state takes some {_SCENE:.0f} s in all, and heat of a surface minutes"
    )


def report_rate_state(scene: Scene, folder: str, formats: Sequence[str]) -> Judged:
    """Rate and state of the scene, with its files in `folder`, which is checked before the work. Once the steps are
    solved, an interrupt, or the end of `wall_time`, leaves there what is known. Raises InputError."""
    check_folder(folder)
    so_far, begun = list[Callable[[], Judged]](), list[str]()

    def save(found: Judged) -> None:
        tables = page(found), plain(found), answers(found)
        save_judgement(folder, "rate-state", lambda: draw_rate_state(found), *tables, formats)

    try:
        with closing(Progress("rate-state")) as bar, within(scene.deadline(), scene, "all of it"):

            def doing(what: str) -> None:
                begun.append(what)
                bar.doing(what)

            found = judge(scene, doing, so_far.append)
    except (KeyboardInterrupt, Terminated, InputError) as stop:
        if not so_far:
            if isinstance(stop, InputError) and isinstance(stop.__context__, TimeIsUp):
                raise InputError(f"{stop}; {_too_late(begun)}") from stop
            raise
        save(so_far[0]())
        said = f"what is known so far is written to {folder}"
        if isinstance(stop, InputError):
            raise InputError(f"{stop}; {said}") from stop
        stop.add_note(said)
        raise
    save(found)
    return found
