"""Progress bars that appear only once a run has lasted a second; in a log file, or under mpirun, ten."""

import math
import sys
import threading
import time
from typing import Any

_PATIENCE, _LOG_PATIENCE = 1.0, 10.0


class Progress:
    """Call as progress(done, expected); on rank 0 only. It shows contacts per second and the time left."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._bar: Any = None
        self._patience = _PATIENCE if sys.stderr.isatty() else _LOG_PATIENCE

    def __call__(self, done: int, expected: int) -> None:
        if self._bar is None:
            if done >= expected or time.monotonic() - self._begun < self._patience:
                return
            from tqdm import tqdm

            pace = 0.1 * self._patience
            shown = {"unit": " contacts", "unit_scale": True, "mininterval": pace}
            self._bar = tqdm(leave=False, total=expected, initial=done, **shown)
        self._bar.total = expected
        self._bar.update(done - self._bar.n)
        if done >= expected:
            self.close()

    def close(self) -> None:
        """Take the bar away."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None


class Refinement:
    """Call as refinement(error) with the error that a solution has; it shows how many of the powers of ten from the
    first one to the tolerance are gone, and the time since it was made, also while nothing is called."""

    def __init__(self, tolerance: float) -> None:
        self._tolerance = tolerance
        self._first = self._best = math.inf
        self._bar: Any = None
        self._patience = _PATIENCE if sys.stderr.isatty() else _LOG_PATIENCE
        self._done = threading.Event()
        self._ticking = threading.Thread(target=self._tick, daemon=True)
        self._ticking.start()

    def __call__(self, error: float) -> None:
        if math.isinf(self._first):
            self._first = error
        self._best = min(self._best, error)

    def _tick(self) -> None:
        begun = time.monotonic()
        while not self._done.wait(self._patience):
            if self._bar is None:
                from tqdm import tqdm

                form = "master equation: {bar} {postfix}, {elapsed}"
                self._bar = tqdm(leave=False, total=1.0, bar_format=form, mininterval=0.0)
                self._bar.start_t -= time.monotonic() - begun
            self._bar.n, said = self._share(), f"error {self._best:.1e} of {self._tolerance:.1e} asked"
            self._bar.set_postfix_str(said if math.isfinite(self._best) else "no error estimate yet")

    def _share(self) -> float:
        if not math.isfinite(self._first) or self._first <= self._tolerance:
            return 0.0
        return min(1.0, math.log(self._first / self._best) / math.log(self._first / self._tolerance))

    def close(self) -> None:
        """Take the bar away."""
        self._done.set()
        self._ticking.join()
        if self._bar is not None:
            self._bar.close()
