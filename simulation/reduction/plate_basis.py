"""From the declaration of a plate to its reduced model, with forces and measured motions beside its patches."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_matrix

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.experiment import Patch, Plate
from analysis.material import MaterialBox
from simulation.reduction.basis_key import BasisTraining
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.assembly import SELECTING_FORCES, assemble_for
from simulation.shell.fineness import Fineness
from simulation.shell.points import footprint_points
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


def reduce_with_footprints(
    model: ShellModel,
    box: MaterialBox,
    band: tuple[float, float],
    footprints: Sequence[Footprint],
    driven: Sequence[int] = (0,),
    *,
    points: ArrayLike | None = None,
    field_certified: bool = True,
    training: BasisTraining | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[ReducedModel, Real]:
    """Reduce as `simulation.reduction.vectors.reduce.reduce` does, with the footprints of transducers.

    Forces on the `driven` footprints and on those with a mass are trained and certified like patches, and so are
    all others if they are few; for a laser's many points the field is certified instead.

    Parameters
    ----------
    model : ShellModel
        Of n unknowns.
    band : (float, float)
        Hz.
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
    reduced : ReducedModel
    vectors : (n, r) ndarray
        Orthonormal in the mass.

    Raises
    ------
    ValueError
        For an invalid box or band, or a plate with neither patch nor force.
    RuntimeError
        If the tolerance cannot be reached.
    """
    if not footprints:
        return reduce(
            model, box, band, points=points, field_certified=field_certified, training=training, progress=progress
        )
    trained = [
        k for k, one in enumerate(footprints) if len(footprints) <= SELECTING_FORCES or k in driven or one.mass
    ]
    field_only = [k for k in range(len(footprints)) if k not in trained]
    places = np.asarray(() if points is None else points, float).reshape(-1, 2)
    more, average = footprint_points([footprints[k] for k in field_only])
    reduced, vectors = reduce(
        _with_forces(model, [footprints[k] for k in trained]),
        box,
        band,
        points=np.vstack([places, more]),
        field_certified=field_certified or bool(field_only),
        training=training,
        progress=progress,
    )
    patches = model.capacitance.size
    found = np.empty((len(footprints), reduced.size))
    found[trained] = reduced.coupling[:, patches:].T
    found[field_only] = average @ reduced.deflection[len(places) :]
    reduced = replace(
        reduced,
        coupling=reduced.coupling[:, :patches],
        capacitance=model.capacitance,
        deflection=reduced.deflection[: len(places)],
        points=places,
        footprints=found,
    )
    return reduced, vectors


def _with_forces(model: ShellModel, footprints: Sequence[Footprint]) -> ShellModel:
    """Plate with a unit force on every footprint, after the patches, as if it were a patch."""
    rows = model.footprint_rows(footprints)
    return replace(
        model,
        coupling=np.hstack([model.coupling, rows.T]),
        capacitance=np.concatenate([model.capacitance, np.ones(len(rows))]),
    )
