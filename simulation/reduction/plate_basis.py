"""From the declaration of a plate to its reduced model, and the basis that the reduction with effects extends."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix

from analysis.channel import Footprint
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.reduction.basis_training import BasisTraining
from simulation.reduction.footprint_reduction import reduce_with_footprints
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.assembly import SELECTING_FORCES, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.shell_model import ShellModel


@dataclass(frozen=True)
class PlateBasis:
    """Selected finite-element functions of a plate, and reduction vectors over them.

    Attributes
    ----------
    kept : (5, N) ndarray of bool
        See `simulation.shell.assembly.Choice`.
    dropped : float
        Likewise.
    vectors : (n, r) ndarray
        Orthonormal in the mass: the coordinates of the plain reduced model.
    error : float
        See `ReducedModel.error`.
    """

    kept: NDArray[np.bool_]
    dropped: float
    vectors: NDArray[np.float64]
    error: float

    def fits(self, mass: csr_matrix) -> bool:
        """Whether the vectors are those of a plate with this mass matrix."""
        vectors = self.vectors
        if len(vectors) != mass.shape[0]:
            return False
        return bool(np.allclose(vectors.T @ (mass @ vectors), np.eye(vectors.shape[1]), atol=1e-8))


def plain_reduction(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    *,
    attached: Sequence[Footprint] = (),
    footprints: Sequence[Footprint] = (),
    driven: Sequence[int] = (),
    points: ArrayLike | None = None,
    field_certified: bool = True,
    fineness: Fineness | None = None,
    training: BasisTraining | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[ShellModel, ReducedModel, PlateBasis]:
    """Mesh, assemble and reduce a plate as declared.

    Parameters
    ----------
    patches : sequence of Patch
        Voltages and charges keep this order.
    box : MaterialBox
        Ranges of the materials.
    band : (float, float)
        Hz.
    attached : sequence of Footprint
        Discs of strings and cables: responses to forces there are used in the selection of functions.
    footprints : sequence of Footprint
        Of transducers.
    driven : sequence of int
        Indices in `footprints`.
    points : (K, 2) array_like, optional
        Points at which the deflection is computed, m.
    field_certified : bool
        Whether the deflection there is included in the error.
    progress : callable, optional
        Called with the stage's name and the share done.

    Returns
    -------
    ShellModel
        The full model.
    ReducedModel
    PlateBasis

    Raises
    ------
    GeometryError
        Where no good mesh is found.
    ValueError
        For an invalid box or band, or a plate with neither patch nor force.
    RuntimeError
        If the tolerance cannot be reached.
    """
    report = progress or (lambda stage, share: None)
    model = assemble_for(
        plate,
        patches,
        box,
        band,
        footprints=footprints[:SELECTING_FORCES],
        attached=attached,
        fineness=fineness,
        progress=lambda share: report("assembling the plate", share),
    )
    reduced, vectors = reduce_with_footprints(
        model,
        box,
        band,
        footprints,
        driven,
        points=points,
        field_certified=field_certified,
        training=training,
        progress=progress,
    )
    return model, reduced, PlateBasis(model.unknowns.kept, model.dropped, vectors, reduced.error)
