"""Coarse model of a plate, made in a second: levels of transfers and shapes of modes everywhere on it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.channel import Footprint
from analysis.experiment import Experiment, Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.modal_form import columns
from simulation.reduction.reduced_model import ReducedModel
from simulation.reduction.vectors.energy_decomposition import energy_shift, mass_orthonormal, middle, projected
from simulation.reduction.vectors.rational_krylov import Chain
from simulation.shell.assembly import assemble
from simulation.shell.unknowns import factorize
from simulation.twin.instruments import Instruments, Transfer

DEGREE, CELLS = 4, 5
"""Degree of the mesh, and cells along the shorter side: frequencies accurate to a few per mille."""
LOSS_FACTOR = 0.04
"""Loss factor used for every comparison, whatever the material's own."""
MODULUS_RATIO = 7.0
"""Largest ratio from one modulus of the vectors to the next."""
VECTORS = 24
"""Number of Krylov vectors for every shift and modulus."""
FORCES = 4
"""Footprints that are loads, too: of more, every load would have fewer vectors."""


@dataclass(frozen=True)
class CoarsePlate:
    """Approximate transfer from the input to the outputs of a plate, for `analysis.updating.start`.

    Attributes
    ----------
    reduced : ReducedModel
        Of no certified error.
    instruments : Instruments
    """

    reduced: ReducedModel
    instruments: Instruments

    @classmethod
    def of(cls, experiment: Experiment, box: MaterialBox) -> Self:
        """Reduce an experiment's plate on a coarse mesh over the moduli of `box`."""
        footprints = experiment.footprints
        reduced = coarse_reduction(experiment.plate, experiment.patch, box, experiment.protocol.band, footprints)
        return cls(reduced.loaded(np.array([one.mass for one in footprints])), Instruments.of(experiment))

    def frf(
        self, youngs_modulus: float, poisson_ratio: float, frequency: Real, loss_factor: float = LOSS_FACTOR
    ) -> Complex:
        """Return the approximate outputs per unit of the input.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray, Hz
        loss_factor : float
            Of plate and patches.

        Returns
        -------
        (K, F) complex ndarray
        """
        stiffness = self.reduced.stiffness(youngs_modulus, poisson_ratio, 0.0).real
        seen, driving = self.instruments.seen, self.instruments.driving
        ports = list(dict.fromkeys((*seen, *driving)))
        modes = DampedModes.of(stiffness, self.reduced.ports[:, ports], self.reduced.dashpots)
        answer = modes.transfers(frequency, loss_factor)
        between = answer[np.ix_([ports.index(one) for one in seen], [ports.index(one) for one in driving])]
        return Transfer.of(self.instruments, self.reduced.capacitance, between, frequency).response

    def poles(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float = LOSS_FACTOR) -> Complex:
        """Poles of the plate, its patches short-circuited and without dashpots.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        loss_factor : float
            Of plate and patches.

        Returns
        -------
        (r,) complex ndarray
            rad/s, ascending; motions without stiffness are left out.
        """
        stiffness = self.reduced.stiffness(youngs_modulus, poisson_ratio, 0.0).real
        squares = np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))
        return np.asarray(1j * np.sqrt((1.0 + 1j * loss_factor) * squares[squares > 1.0]))


def coarse_reduction(
    plate: Plate,
    patches: Sequence[Patch],
    box: MaterialBox,
    band: tuple[float, float],
    footprints: Sequence[Footprint] = (),
) -> ReducedModel:
    """Galerkin model on Krylov vectors at a few moduli and the middle nu; its error is not measured.

    The vectors are responses to patches and to the first `FORCES` footprints, the input among them; others are
    outputs only.

    Parameters
    ----------
    plate : Plate
        A mesh that it declares is not used.
    band : (float, float)
        Hz.

    Returns
    -------
    ReducedModel
        Of no certified error.

    Raises
    ------
    GeometryError
        Where no good mesh is found.
    """
    shorter = min(plate.length_x, plate.length_y)
    spacing = shorter / CELLS * float((0.003 / plate.thickness) ** 0.5)
    plate = plate.model_copy(update={"mesh": None})
    model = assemble(plate, patches, recipe=MeshRecipe(spacing=spacing, grading=0.0, growth=2.0), degree=DEGREE)
    rows = model.footprint_rows(footprints)
    forces = np.hstack([model.coupling, rows[:FORCES].T])
    low, high = box.youngs_modulus
    count = int(np.ceil(np.log(high / low) / np.log(MODULUS_RATIO))) + 1
    shifts = np.array([max(band[0], 0.05 * band[1]), 0.5 * sum(band), band[1]])
    blocks = max(VECTORS // forces.shape[1], 4)
    spaces = []
    for e in np.geomspace(low, high, count):
        stiffness = model.stiffness(float(e), float(np.mean(box.poisson_ratio)))
        for shift in 2 * np.pi * shifts:
            chain = Chain(factorize(stiffness - shift**2 * model.mass), model.mass, forces)
            spaces.append(chain.extend(blocks)[0])
    space = np.hstack(spaces)
    energy = model.stiffness(*middle(box)) + energy_shift(band) * model.mass
    vectors = mass_orthonormal(space, energy, model.mass)
    reduced = projected(model, vectors, box, band, columns(model.damping, space))
    return replace(reduced, footprints=rows @ vectors) if footprints else reduced


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
