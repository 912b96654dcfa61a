"""The command `mesofriction`: subcommands are functions of toolkit.commands."""

import atexit
import gc
import os
import sys
from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:  # else imported in functions, so that `main` catches an interrupt
    import argparse

    from toolkit.processes.signals import Launch

COMMANDS = {
    "run": "solve a scene: F(X) with its error and run time, result files and a picture",
    "thresholds": "picture and table of a scene's P_c(x)",
    "compare": "how prone to stick-slip each of several scenes is: one table, one picture",
    "verdict": "does this interface, on this machine, stick and slip? one page, one picture, in SI units",
    "rate-state": "a, b and D_c of rate and state for a scene's contacts, and how well that law holds",
    "precision": "what precision costs: true error against run time of each method, of a scene",
    "cost": "what a scene imports, builds and runs, its start-up and memory, and what it leaves out",
    "stability": "stiff and extreme cases through both solvers, or each number of a scene pushed by decades: a table",
    "scenes": "list the scenes that are shipped",
    "figures": "draw the paper's figures, each with a number beside an exact one; all take some 30 s",
    "show": "print a scene with all its defaults, as TOML that runs",
    "copy": "copy a shipped scene into a file of your own; an existing file is never overwritten",
}


def main(words: list[str] | None = None) -> int:
    """Run the command and return its exit status: 0 done, 1 a solver or the program failed, 2 bad input, 130
    interrupted, 141 nobody reads its output, 143 terminated."""
    # these cover the time of the imports, before there is a run to end
    try:
        from toolkit.processes.signals import Terminated, terminable

        try:
            with terminable():
                try:
                    return _run(sys.argv[1:] if words is None else words)
                finally:
                    sys.stdout.flush()
        except Terminated:
            print("mesofriction: terminated; nothing was written", file=sys.stderr, flush=True)
            return 143
    except KeyboardInterrupt:
        print("mesofriction: interrupted; nothing was written", file=sys.stderr, flush=True)
        return 130
    except BrokenPipeError:  # `head` has read enough; Python shall not complain about the rest
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141


def _run(words: list[str]) -> int:
    from contextlib import redirect_stderr, redirect_stdout

    from toolkit.processes.signals import read_environment

    # numpy reads it: matrices are small here, and BLAS's threads would cost more than they save
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    # else Python would search all memory for what to free, just before all of it is freed
    atexit.register(gc.freeze)
    launched = read_environment()
    if launched.rank == 0:
        return _execute(_parse(words), launched)
    with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):  # rank 0 prints for all
        with redirect_stderr(nowhere):
            parsed = _parse(words)
        return _execute(parsed, launched)


def _parse(words: list[str]) -> "argparse.Namespace":
    """The command line as arguments; each command imports what it needs."""
    import argparse

    from toolkit.version import __version__

    class Parser(argparse.ArgumentParser):
        """One that tells a mistake in one line."""

        def error(self, message: str) -> NoReturn:
            self.exit(2, f"mesofriction: {message}; {self.prog} --help says more\n")

    purpose = "Friction at the mesoscale, from thresholds to sliding."
    parser = Parser(prog="mesofriction", description=purpose)
    parser.add_argument("--version", action="version", version=f"mesofriction {__version__}")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, purpose in COMMANDS.items():
        own = subparsers.add_parser(name, help=purpose, description=purpose)
        if name == "scenes":
            continue
        if name == "figures":
            explained = "labels or numbers, such as A08c, A02 (all that begin so), fig10; all where it is left out"
            own.add_argument("figure", metavar="FIGURE", nargs="*", help=explained)
            _written_to(own, "paper-figures")
            continue
        many, folder = {
            "compare": ("+", "compare-output"),
            "precision": ("?", "NAME-output, or coverage-output"),
            "stability": ("?", "NAME-output, or stability-output"),
        }.get(name, (None, "NAME-output"))
        scene = "a scene file, or the name of a shipped scene"
        if name == "stability":
            scene += "; left out, the shipped table of extreme cases"
        own.add_argument("scene", metavar="SCENE", nargs=many, help=scene)
        if name == "copy":
            explained = "the file to write, or a folder for it (default: ./SCENE.toml)"
            own.add_argument("file", metavar="FILE", nargs="?", help=explained)
            continue
        change: Any = {"metavar": "KEY=VALUE", "action": "append", "default": [], "dest": "changes"}
        explained = "another value for a key of the scene, as TOML: --set drive.spring='\"50 N/m\"'; repeatable"
        own.add_argument("--set", help=explained, **change)
        if name in ("show", "cost"):
            continue
        _written_to(own, folder)
        if name == "precision":
            explained = "without a scene: how often error bars hold the true error, over cases drawn at random"
            own.add_argument("--coverage", action="store_true", help=explained)
            whole: Any = {"type": int, "metavar": "NUMBER"}
            own.add_argument("--cases", help="of --coverage (default: 1000)", **whole)
            own.add_argument("--seed", help="of --coverage (default: 1)", **whole)
        if name == "run":
            kept = "how often a long ensemble writes what it has found into DIR, from which the same command goes on"
            seconds: Any = {"metavar": "SECONDS", "type": float, "default": 60.0}
            own.add_argument("--checkpoint", help=f"{kept} (default: 60)", **seconds)
            explained = "tell work, time and error by small pilots; write nothing"
            own.add_argument("--dry-run", action="store_true", help=explained)
    if words and not words[0].startswith("-") and words[0] not in COMMANDS:
        from toolkit.scene.tables import did_you_mean

        hint = f"{did_you_mean(words[0], COMMANDS)}mesofriction --help lists the commands"
        parser.exit(2, f"mesofriction: {words[0]}: unknown command; {hint}\n")
    parsed, left = parser.parse_known_args(words)
    if left:
        parser.exit(2, f"mesofriction: {_of_words_left(words, left, parsed.command)}\n")
    if getattr(parsed, "out", None) == "":  # as of a variable of the shell that is not set
        parser.exit(2, "mesofriction: --out = '': names no folder; name one, or leave it out\n")
    return parsed


def _of_words_left(words: list[str], left: list[str], command: str) -> str:
    """What to write instead of words that belong to nothing, such as a unit that the shell took for another word."""
    from toolkit.scene.drive import MACHINE_UNITS

    for place, word in enumerate(words[:-2]):
        begin, following = words[place + 1], words[place + 2]
        two = " ".join(words[place + 2 : place + 4])
        unit = two if two in MACHINE_UNITS else following
        if word == "--set" and "=" in begin and unit in MACHINE_UNITS:
            key, _, value = begin.partition("=")
            text = f"--set {key}='\"{value} {unit}\"'"
            return f"{unit}: is apart from {begin}; a value with a blank is text, write {text}"
    return f"{' '.join(left)}: not known here; mesofriction {command} --help says what is"


def _written_to(own: "argparse.ArgumentParser", folder: str) -> None:
    """The options of a command that writes pictures, by default into this folder."""
    explained = f"folder for what is written (default: ./{folder})"
    own.add_argument("--out", metavar="DIR", help=explained)
    explained = "formats of pictures beside PNG: pdf, svg, or pdf,svg"
    own.add_argument("--format", metavar="FORMATS", help=explained)


def _execute(parsed: "argparse.Namespace", launched: "Launch") -> int:
    from importlib import import_module

    commands = import_module("toolkit.commands")
    from toolkit.processes.ranks import end_together, on_root

    name = parsed.command.replace("-", "_")
    command = getattr(commands, name)
    if name not in commands.ON_ONE_RANK:
        return end_together(lambda comm: int(command(parsed, comm)), launched)
    # the other ranks take part: imports of rank 0 may start MPI, which all ranks must start together
    return end_together(lambda comm: on_root(comm, lambda: int(command(parsed))), launched)


if __name__ == "__main__":
    sys.exit(main())
