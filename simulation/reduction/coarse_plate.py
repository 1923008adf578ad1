"""Coarse model of a plate, accurate to a per cent over a hundredfold range of moduli, made in a second."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.channel import Footprint
from analysis.experiment import Experiment, Patch, Plate
from analysis.material import MaterialBox
from simulation.meshing.recipe import MeshRecipe
from simulation.reduction.damped_modes import DampedModes
from simulation.reduction.dashpots import columns
from simulation.reduction.energy_decomposition import energy_shift, mass_orthonormal, middle
from simulation.reduction.galerkin import projected
from simulation.reduction.rational_krylov import Chain
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.assembly import assemble
from simulation.shell.factors import factorize
from simulation.twin.instruments import Instruments
from simulation.twin.transfer import Transfer

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
    """Approximate transfer from the input to the outputs of a plate, for `analysis.updating.modulus_scan`.

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
