"""Coarse plate with one transducer anywhere: levels of its transfers for every place on the plate at once."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.experiment import Experiment
from analysis.material import MaterialBox
from simulation.reduction.coarse_plate import coarse_reduction
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.reduced_model import ReducedModel

POINTS_ALONG_BOX = 28
"""Grid points along the longer side of the box around the plate: 9 mm apart on one of 0.24 m, half a patch."""


@dataclass(frozen=True)
class CoarsePlaces:
    """A reduced plate whose deflection is known on a grid.

    Attributes
    ----------
    reduced : ReducedModel
        With the experiment's patches and masses, of no certified error.
    deflection, curvature : (G, r) ndarray
        Rows that give the deflection at every place, and the sum of both curvatures but for a factor, which a
        patch there feels.
    places : (G, 2) ndarray
        m.
    """

    reduced: ReducedModel
    deflection: Real
    curvature: Real
    places: Real

    @classmethod
    def of(cls, experiment: Experiment, box: MaterialBox) -> Self:
        """Reduce an experiment's plate on a coarse mesh; GeometryError where no good mesh is found."""
        plate, declared = experiment.plate, experiment.footprints
        (x0, y0), (x1, y1) = plate.bounds
        step = max(x1 - x0, y1 - y0) / POINTS_ALONG_BOX
        axes = [np.arange(low + 0.5 * step, high, step) for low, high in ((x0, x1), (y0, y1))]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        shape = grid.shape[:2]
        inside = plate.contains(grid.reshape(-1, 2))
        points: Sequence[Footprint] = [Footprint((float(x), float(y))) for x, y in grid.reshape(-1, 2)[inside]]
        whole = coarse_reduction(plate, experiment.patch, box, experiment.protocol.band, (*declared, *points))
        count = len(declared)
        masses = np.concatenate([[one.mass for one in declared], np.zeros(len(points))])
        whole = whole.loaded(masses)
        rows = np.full((inside.size, whole.size), np.nan)
        rows[inside] = whole.footprints[count:]
        rows = rows.reshape(*shape, -1)
        bent = rows[2:, 1:-1] + rows[:-2, 1:-1] + rows[1:-1, 2:] + rows[1:-1, :-2] - 4.0 * rows[1:-1, 1:-1]
        known = np.isfinite(bent).all(axis=-1)
        return cls(
            replace(whole, footprints=whole.footprints[:count]),
            rows[1:-1, 1:-1][known],
            bent[known],
            grid[1:-1, 1:-1][known],
        )

    def powers(
        self,
        material: tuple[float, float],
        frequency: Real,
        loss_factor: float,
        others: Sequence[int],
        *,
        patch: bool,
    ) -> Real:
        """Squared transfers between a transducer at every place and some ports.

        Parameters
        ----------
        material : (float, float)
            E [Pa] and nu.
        frequency : (F,) ndarray, Hz
        others : sequence of int
            Ports at the other end.
        patch : bool
            Whether the transducer is a patch.

        Returns
        -------
        (N, G, F) ndarray
            But for a factor, and electronics and time derivatives, which hardly change along a resonance.
        """
        stiffness = self.reduced.stiffness(*material, 0.0).real
        modes = DampedModes.of(stiffness, self.reduced.ports[:, list(others)])
        rows = (self.curvature if patch else self.deflection) @ modes.shapes
        terms = modes.terms(frequency, loss_factor)
        return np.stack([np.abs((rows * force) @ terms) ** 2 for force in modes.force.T])
