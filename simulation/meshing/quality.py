"""Quality of cells, by their Jacobian."""

import numpy as np

from analysis.arrays import Real
from simulation.meshing.plate_mesh import PlateMesh
from simulation.shell.mapping import map_cells

POINTS_ALONG_SIDE = 5
"""Points along a side of a cell at which its Jacobian is evaluated."""


def jacobian_ratio(mesh: PlateMesh) -> Real:
    """Smallest over largest Jacobian of every cell, (cells,): 1 for parallelograms, below 0 for inverted ones."""
    side = np.linspace(-1.0, 1.0, POINTS_ALONG_SIDE)
    square = np.stack(np.meshgrid(side, side), axis=0).reshape(2, -1)
    half = 0.5 * (square + 1.0)
    found = []
    for triangles, places in ((False, square), (True, half[:, half.sum(axis=0) < 1.0 + 1e-9])):
        if len(mesh.triangles if triangles else mesh.quads):
            jacobian = map_cells(mesh, places, triangles)[1]
            det = jacobian[..., 0, 0] * jacobian[..., 1, 1] - jacobian[..., 0, 1] * jacobian[..., 1, 0]
            found.append(det.min(axis=1) / np.maximum(np.abs(det).max(axis=1), 1e-300))
    return np.concatenate(found)
