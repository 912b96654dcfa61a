"""A progress bar that appears only once a run has lasted a second."""

import time
from typing import Any

_PATIENCE = 1.0


class Progress:
    """Call as progress(done, total); on rank 0 only."""

    def __init__(self) -> None:
        self._begun = time.monotonic()
        self._bar: Any = None

    def __call__(self, done: int, total: int) -> None:
        if self._bar is None:
            if done >= total or time.monotonic() - self._begun < _PATIENCE:
                return
            from tqdm import tqdm

            self._bar = tqdm(total=total, initial=done, unit=" contacts", unit_scale=True, leave=False)
        self._bar.update(done - self._bar.n)
        if done >= total:
            self._bar.close()
