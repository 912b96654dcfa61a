"""The command's work: rate and state of a scene into a folder, what is known of it if it is stopped."""

import re
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from itertools import pairwise

from origins.errors import InputError
from toolkit.processes.signals import Terminated, TimeIsUp
from toolkit.rate_state.files import answers, plain
from toolkit.rate_state.judge import Judged, judge
from toolkit.rate_state.picture import draw_rate_state
from toolkit.rate_state.words import page
from toolkit.results.folders import check_folder
from toolkit.running.progress import Progress
from toolkit.running.solvers import within
from toolkit.saving import save_judgement
from toolkit.scene.scene import Scene
from toolkit.verdict.sliders.budget import Budget

# s in which the command can work, where the scene gives no wall_time; what is known then is its answer
WORK = 120.0


def _where(begun: Sequence[tuple[float, str]]) -> str:
    """In which part the time was over, and what the longest of those like it that were solved took."""
    kinds = [re.sub(r"\d+", "", what) for _, what in begun]
    took = [after - at for (at, _), (after, _) in pairwise(begun)]
    alike = [each for each, kind in zip(took, kinds, strict=False) if kind == kinds[-1]]
    each = f", where one before took {max(alike):.2g} s" if alike else ""
    return f"it ended in its {begun[-1][1]}{each}"


def _cut(judged: Judged, wall_time: float | None, where: str) -> Judged:
    """What is known after the wall time, without one after WORK, which says so."""
    over = f"{WORK:.0f} s of work were over" if wall_time is None else "wall_time is over"
    longer = f"gives it {'half an hour' if wall_time is None else 'ten times as long'}"
    seconds = 1800.0 if wall_time is None else 10.0 * wall_time
    message = f"{judged.found.message}; {over}{where}; --set wall_time={seconds} {longer}"
    return replace(judged, found=replace(judged.found, success=False, message=message))


def report_rate_state(scene: Scene, folder: str, formats: Sequence[str]) -> Judged:
    """Rate and state of the scene, with its files in `folder`, which is checked before the work. Once the first steps
    are solved, an interrupt leaves there what is known, and what is known at the end of `wall_time`, or else of WORK,
    is the answer. Raises InputError."""
    check_folder(folder)
    so_far, begun = list[Callable[[], Judged]](), list[tuple[float, str]]()
    own = Budget(WORK, strict=False)

    def remaining() -> float:
        """How many s are left of WORK, and as many again until something is known."""
        return own.remaining() if so_far else WORK

    more = remaining if scene.wall_time is None else None
    deadline = scene.deadline() or time.monotonic() + own.remaining()

    def save(found: Judged) -> None:
        tables = page(found), plain(found), answers(found)
        save_judgement(folder, "rate-state", lambda: draw_rate_state(found), *tables, formats)

    try:
        with closing(Progress("rate-state")) as bar, within(deadline, scene, "all of it", more):

            def doing(what: str) -> None:
                begun.append((time.monotonic(), what))
                bar.doing(what)

            found = judge(scene, doing, so_far.append)
    except (KeyboardInterrupt, Terminated, InputError) as stop:
        late = isinstance(stop, InputError) and isinstance(stop.__context__, TimeIsUp)
        where = f"; {_where(begun)}" if late and begun else ""
        if not so_far:
            if where:
                raise InputError(f"{stop}{where}, before which nothing is known") from stop
            raise
        if late:
            found = _cut(so_far[0](), scene.wall_time, where)
            save(found)
            return found
        save(so_far[0]())
        said = f"what is known so far is written to {folder}"
        if isinstance(stop, InputError):
            raise InputError(f"{stop}; {said}") from stop
        stop.add_note(said)
        raise
    save(found)
    return found
