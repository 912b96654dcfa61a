"""The rigid slider whose force stands for that of a scene without a forward path of its own."""

from dataclasses import replace

import numpy as np

from origins.drive import Drive
from toolkit.scene.scene import Scene
from toolkit.scene.tables import MasterTable

FURTHEST, POINTS, RIGID = (
    4.0,
    201,
    MasterTable(tolerance=1e-3),
)  # mean thresholds, points, and what is asked of it


def on_rigid_slider(scene: Scene) -> Scene:
    """The scene with a rigid slider that moves by a few mean thresholds at the same speed, without its own solvers."""
    # close to 0 too, as lengths that differ much are drawn on a logarithmic axis
    path = np.union1d(np.linspace(0.0, FURTHEST, POINTS), np.geomspace(1e-3, FURTHEST, POINTS // 4))
    drive = Drive(path * scene.contacts.mean_threshold, scene.sliding)
    return replace(scene, master=RIGID, eq=None, sweep=None, grid=None, given_drive=drive)
