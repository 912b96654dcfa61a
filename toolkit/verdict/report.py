"""The command's work: the verdict on a scene into a folder, what is known of it if it is stopped."""

from collections.abc import Mapping
from contextlib import closing
from functools import partial
from typing import Any
from warnings import catch_warnings, simplefilter

from origins.laws.temperature import TooHot
from toolkit.processes.signals import finishing
from toolkit.results.folders import check_folder
from toolkit.running.progress import Progress
from toolkit.saving import save_judgement
from toolkit.scene.drive import check_machine
from toolkit.scene.scene import load_scene, read_scene
from toolkit.scene.tables import read_table
from toolkit.verdict.answers import Verdict
from toolkit.verdict.files import friction, plain
from toolkit.verdict.judge import verdict
from toolkit.verdict.picture import draw_verdict
from toolkit.verdict.sliders.budget import at_most
from toolkit.verdict.text.words import page


def report_verdict(
    name: str, changes: Mapping[str, Any], out: str | None, formats: tuple[str, ...]
) -> Verdict:
    """The verdict on the scene of this name or file, printed and written to the folder `out`, by default
    NAME-output. Raises InputError."""
    # before the contacts, which take seconds of a measured surface
    check_machine(read_table(read_scene(name, changes=changes).tables))
    scene = load_scene(name, False, changes=changes)
    folder = out or f"{scene.name}-output"
    check_folder(folder)  # before the work, not after it
    with closing(Progress("verdict", most=at_most(scene.wall_time))) as bar, catch_warnings():
        simplefilter("ignore", TooHot)  # the page says it, of the scene's own contacts
        found = verdict(scene, bar.doing, keep=True)
    with finishing(f"the answer is written to {folder}", at_once=found.stopped is not None):
        lines, draw = page(found), partial(draw_verdict, found)
        tables = lines, plain(found), friction(found)
        save_judgement(folder, "verdict", draw, *tables, formats, table="friction")
        print("\n".join([*lines, f"written to {folder}"]))
    if found.stopped is not None:
        found.stopped.add_note(f"what was known by then is written to {folder}")
        raise found.stopped
    return found
