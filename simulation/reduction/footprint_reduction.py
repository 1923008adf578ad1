"""Reduction of a plate with forces and measured motions in addition to its patches."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.material import MaterialBox
from simulation.reduction.basis_training import BasisTraining
from simulation.reduction.reduce import reduce
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.assembly import SELECTING_FORCES
from simulation.shell.footprints import footprint_points
from simulation.shell.shell_model import ShellModel


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
    """Reduce as `simulation.reduction.reduce.reduce` does, with the footprints of transducers.

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
