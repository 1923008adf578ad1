"""Which functions a graded mesh can spare."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from simulation.mesh import MeshLines, MeshRecipe
from simulation.shape_space import Rectangle, ShapeSpace


@dataclass(frozen=True)
class Degrees:
    """Highest degree worth keeping, by where an element lies along an axis.

    Attributes
    ----------
    bulk : int
        Between the strips.
    strip, edge : int
        Across the strips that patch edges and plate edges draw over the whole plate.
    layer : int
        Across the strips where they lie beside a patch.
    """

    bulk: int
    strip: int
    edge: int
    layer: int

    def along(
        self, lines: MeshLines, place: NDArray[np.float64], near: NDArray[np.bool_], recipe: MeshRecipe
    ) -> NDArray[np.int_]:
        """Degree of every element, (elements,), given its midpoint and whether a patch is near.

        `recipe.degree` belongs to elements as long as its spacing; half the length makes up for one degree.
        """
        full = recipe.degree
        index = np.searchsorted(lines.position, place) - 1
        kind, length = lines.kind[index], np.diff(lines.position)[index]
        halvings = np.round(np.log2(recipe.spacing / length)).astype(int)
        degree = np.where(near, full, min(self.bulk, full))
        degree = np.minimum(degree, np.maximum(full - halvings, LEAST))
        degree = np.where(kind == "strip", np.where(near, self.layer, self.strip), degree)
        return np.asarray(np.where(kind == "edge", self.edge, degree))


LEAST = 3
"""Degree kept in the shortest elements between strips."""

MEMBRANE = Degrees(bulk=5, strip=2, edge=2, layer=4)
BENDING = Degrees(bulk=12, strip=2, edge=4, layer=5)


def thinned(space: ShapeSpace, regions: Sequence[Rectangle]) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Membrane and bending functions worth keeping, (n,) each.

    Away from the patches a strip is far thinner than anything that happens along it, and in-plane
    motion is small and smooth. Beside a patch both matter: with degree 2 across those strips a
    patch-to-patch transfer is 0.3 % off, with degree 3 for the membrane in the bulk another 0.3 %;
    these tables cost 0.06 % of rms, for 43 % of the unknowns.
    """
    near = np.zeros(space.centers.shape[1], bool)
    for region in regions:
        near |= space.inside(region, margin=space.recipe.strip)
    x, y = space.centers
    membrane, bending = (
        space.up_to(table.along(space.x, x, near, space.recipe), table.along(space.y, y, near, space.recipe))
        for table in (MEMBRANE, BENDING)
    )
    return membrane, bending
