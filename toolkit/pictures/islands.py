"""The barriers of islands against the angles at which they lie."""

from pathlib import Path
from typing import Any

import numpy as np

from origins.domains.domain_samples import DomainSamples
from toolkit.pictures.axes import INK

_SHOWN = 20_000  # islands, as many as a picture can show


def save_barriers(domains: DomainSamples, path: Path) -> None:
    """Barrier of each island that was drawn, against its angle in degrees, as a PNG; larger islands darker."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    angles, few = np.degrees(domains.angles[:_SHOWN]), domains.n_atoms[:_SHOWN]
    style: dict[str, Any] = {"s": 3.0, "lw": 0.0, "rasterized": True}
    if few.min() == few.max():
        axes.scatter(angles, domains.barriers[:_SHOWN], color=INK["thresholds"], **style)
        axes.set_title(f"{few[0]} atoms")
    else:
        shown = axes.scatter(angles, domains.barriers[:_SHOWN], c=few, cmap="viridis_r", **style)
        figure.colorbar(shown, label="atoms")
    axes.set(xlabel="angle (degrees)", ylabel=r"barrier $\epsilon_a$ (energy)", ylim=(0.0, None))
    figure.savefig(path, dpi=150, format="png")
