"""A plate known to a per cent over moduli of a hundredfold range: made in a second, for a first look at data."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Experiment, Patch, Plate
from analysis.material import MaterialBox
from simulation.damped_modes import DampedModes
from simulation.meshing.recipe import MeshRecipe
from simulation.rational_krylov import Chain
from simulation.reduced_model import ReducedModel
from simulation.reduction import projected
from simulation.shell.assembly import assemble
from simulation.shell.electric_load import ElectricLoad
from simulation.shell.factors import factorize

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

DEGREE, CELLS = 4, 5
"""Of the mesh, and cells along the shorter side: frequencies to a few per mille."""
LOSS_FACTOR = 0.04
"""At which all is compared, whatever the material's own."""
MODULUS_RATIO = 7.0
VECTORS = 24
"""Krylov vectors of every shift and modulus."""


@dataclass(frozen=True)
class CoarsePlate:
    """Voltage-to-voltage transfer of a plate known roughly; see `analysis.updating.coarse_look`.

    Attributes
    ----------
    reduced : ReducedModel
        Of no certified error.
    actuator : int
    sensors : tuple of int
    load : ElectricLoad
        Across every sensor.
    """

    reduced: ReducedModel
    actuator: int
    sensors: tuple[int, ...]
    load: ElectricLoad

    @classmethod
    def of(cls, experiment: Experiment, box: MaterialBox) -> Self:
        """Reduce an experiment's plate on a coarse mesh over the moduli of `box`."""
        reduced = coarse_reduction(experiment.plate, experiment.patch, box, experiment.protocol.band)
        sensors = tuple(k for k, patch in enumerate(experiment.patch) if patch.role == "sensor")
        inputs = experiment.acquisition
        load = ElectricLoad(inputs.input_resistance, inputs.input_capacitance)
        return cls(reduced, experiment.patch.index(experiment.actuator), sensors, load)

    def frf(self, youngs_modulus: float, poisson_ratio: float, frequency: Real) -> Complex:
        """Sensor volts per actuator volt, about, (K, F), damped by `LOSS_FACTOR`."""
        stiffness = self.reduced.stiffness(youngs_modulus, poisson_ratio, 0.0).real
        sensors = list(self.sensors)
        coupling = self.reduced.coupling[:, [*sensors, self.actuator]]
        answer = DampedModes.of(stiffness, coupling).transfers(frequency, LOSS_FACTOR)
        return self.load.voltages(answer[:-1, -1], answer[:-1, :-1], self.reduced.capacitance[sensors], frequency)


def coarse_reduction(
    plate: Plate, patches: Sequence[Patch], box: MaterialBox, band: tuple[float, float]
) -> ReducedModel:
    """Galerkin model on Krylov vectors at a few moduli and the middle nu; its error is not measured."""
    shorter = min(plate.length_x, plate.length_y)
    spacing = shorter / CELLS * float((0.003 / plate.thickness) ** 0.5)
    model = assemble(plate, patches, recipe=MeshRecipe(spacing=spacing, grading=0.0, growth=2.0), degree=DEGREE)
    low, high = box.youngs_modulus
    count = int(np.ceil(np.log(high / low) / np.log(MODULUS_RATIO))) + 1
    shifts = np.array([max(band[0], 0.05 * band[1]), 0.5 * sum(band), band[1]])
    blocks = max(VECTORS // model.coupling.shape[1], 4)
    spaces = []
    for e in np.geomspace(low, high, count):
        stiffness = model.stiffness(float(e), float(np.mean(box.poisson_ratio)))
        for shift in 2 * np.pi * shifts:
            chain = Chain(factorize(stiffness - shift**2 * model.mass), model.mass, model.coupling)
            spaces.append(chain.extend(blocks)[0])
    return projected(model, np.hstack(spaces), box, band)[0]
