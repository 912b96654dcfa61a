"""A progress bar that appears only once a run has lasted a second; in a log file, or under mpirun, ten."""

import sys
import time
from typing import Any

_PATIENCE, _LOG_PATIENCE = 1.0, 10.0


class Progress:
    """Call as progress(done, total); on rank 0 only."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._bar: Any = None
        self._patience = _PATIENCE if sys.stderr.isatty() else _LOG_PATIENCE

    def __call__(self, done: int, total: int) -> None:
        if self._bar is None:
            if done >= total or time.monotonic() - self._begun < self._patience:
                return
            from tqdm import tqdm

            pace = 0.1 * self._patience
            shown = {"total": total, "initial": done, "unit": " contacts", "unit_scale": True, "mininterval": pace}
            self._bar = tqdm(leave=False, **shown)
        self._bar.update(done - self._bar.n)
        if done >= total:
            self._bar.close()
