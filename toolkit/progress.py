"""A progress bar that appears only once a run has lasted a second; in a log file, or under mpirun, ten."""

import sys
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
