"""Shapes of a coarse plate's modes at the points of an experiment and everywhere else on the plate."""

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

PLACES = 40
"""Places along the longer side of the box around the plate: 6 mm apart on one of 0.24 m; `analysis.pairing.points`
interpolates between them. The reduction then takes 1 s, most of it for the rows of these places."""


@dataclass(frozen=True)
class CoarseShapes:
    """A reduced plate whose deflection is known at points and on a grid.

    Attributes
    ----------
    reduced : ReducedModel
        With the experiment's patches and masses, of no certified error.
    points : (K, r) ndarray
        Rows that give the outputs' motion; NaN for those that are no motions.
    anywhere : (G, r) ndarray
        Rows that give the deflection at every place.
    places : (G, 2) ndarray
        m.
    """

    reduced: ReducedModel
    points: Real
    anywhere: Real
    places: Real

    @classmethod
    def of(cls, experiment: Experiment, moduli: tuple[float, float], ratios: tuple[float, float]) -> Self:
        """Reduce an experiment's plate on a coarse mesh; GeometryError where no good mesh is found.

        Parameters
        ----------
        moduli : (float, float)
            Lowest and highest E, Pa.
        ratios : (float, float)
            Lowest and highest Poisson's ratio.
        """
        plate, declared = experiment.plate, experiment.footprints
        (x0, y0), (x1, y1) = plate.bounds
        step = max(x1 - x0, y1 - y0) / PLACES
        # to the very edge, where many sensors stand
        inside = 1e-6 * step
        axes = [
            np.linspace(low + inside, high - inside, int(np.ceil((high - low) / step)) + 1)
            for low, high in ((x0, x1), (y0, y1))
        ]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        places = grid[plate.contains(grid)]
        spots = [Footprint((float(x), float(y))) for x, y in places]
        box = MaterialBox(moduli, ratios, (0.0, 0.0))
        whole = coarse_reduction(plate, experiment.patch, box, experiment.protocol.band, (*declared, *spots))
        masses = np.concatenate([[one.mass for one in declared], np.zeros(len(spots))])
        whole = whole.loaded(masses)
        feet = iter(range(len(experiment.driven), len(declared)))
        points = np.full((len(experiment.outputs), whole.size), np.nan)
        for k, output in enumerate(experiment.outputs):
            if output.footprint is not None:
                points[k] = output.footprint.along * whole.footprints[next(feet)]
        rows = whole.footprints[len(declared) :]
        return cls(replace(whole, footprints=whole.footprints[: len(declared)]), points, rows, places)

    def modes(self, youngs_modulus: float, poisson_ratio: float) -> tuple[Real, Real, Real]:
        """Modes of the plate of one material.

        Parameters
        ----------
        youngs_modulus : float
            Pa.

        Returns
        -------
        frequency : (r,) ndarray
            Hz, ascending.
        points : (K, r) ndarray
            Shapes at the outputs.
        anywhere : (G, r) ndarray
            Shapes at the places.
        """
        stiffness = self.reduced.stiffness(youngs_modulus, poisson_ratio, 0.0).real
        modes = DampedModes.of(stiffness, self.reduced.ports)
        frequency = np.sqrt(np.abs(modes.squares)) / (2.0 * np.pi)
        return frequency, self.points @ modes.shapes, self.anywhere @ modes.shapes
