"""Which functions a graded mesh can spare."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from simulation.shape_space import Rectangle, ShapeSpace

ACROSS_STRIP = {"strip": 2, "edge": 3}
MEMBRANE_AWAY_FROM_PATCHES = 3


def thinned(space: ShapeSpace, regions: Sequence[Rectangle]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Membrane and bending functions worth keeping, (n,) each.

    A strip is thinner than a boundary layer, so low degrees across it do; in-plane motion is small
    and smooth away from the patches that cause it.
    """
    degree = space.recipe.degree
    across_x = np.array([ACROSS_STRIP.get(kind, degree) for kind in space.x.kind])
    across_y = np.array([ACROSS_STRIP.get(kind, degree) for kind in space.y.kind])
    x, y = space.centers
    bending_x = across_x[np.searchsorted(space.x.position, x) - 1]
    bending_y = across_y[np.searchsorted(space.y.position, y) - 1]
    near = np.zeros(x.size, bool)
    for region in regions:
        near |= space.inside(region, margin=space.recipe.strip)
    membrane = np.where(near, degree, MEMBRANE_AWAY_FROM_PATCHES)
    return space.up_to(membrane, membrane), space.up_to(bending_x, bending_y)
