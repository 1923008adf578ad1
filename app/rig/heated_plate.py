"""The simulated rig's plate in its oven, by the heat equation: how far each place is behind the air on a ramp.

A plate in air that warms by r K/s comes, after its time constant, to T = air + r b(x, y) with G b = -C 1: b is
negative, its mean is the lag that a sensor on the plate sees, and what differs from the mean is a gradient. Both
have one cause, the heat that has to pass from the air into the plate.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander2d

from analysis.arrays import Numbers, Real
from analysis.effect_card import EffectCard, Parameter
from analysis.experiment import Experiment
from app.files.simulation_section import HeatInOven
from simulation.effects.effect import Effect
from simulation.heat.heat_model import HeatModel, settled
from simulation.shell.shell_plate import ShellPlate
from simulation.state.plate_state import Circumstances, PlateState

NAME = "uneven_heat"
"""Of the gradient as an effect of the simulated plate; no library that a campaign is held against has it."""
POLYNOMIAL_DEGREE = 6
"""Of the polynomials in the place that b is fitted by, in each direction."""


@dataclass(frozen=True)
class PlateBehindAir:
    """How far a plate is behind the air on a ramp.

    Attributes
    ----------
    lag : float
        Mean over the plate, s.
    capacity : float
        J/K.
    coefficients : (`POLYNOMIAL_DEGREE` + 1, `POLYNOMIAL_DEGREE` + 1) ndarray
        Of Legendre products in xi and zeta: b as bending weighs it over the thickness, less its mean, K per K/s.
    """

    lag: float
    capacity: float
    coefficients: Real

    @classmethod
    def of(cls, experiment: Experiment, heat: HeatInOven) -> "PlateBehindAir":
        """Solve for a plate."""
        plate = experiment.plate
        shell = ShellPlate.of(plate, experiment.patch, degree=2)
        xi, zeta = plate.normalised(shell.space.points)
        transfer = heat.convection * (1.0 + 0.5 * (heat.uneven[0] * xi + heat.uneven[1] * zeta))
        model = HeatModel.of(
            shell.space,
            shell.thickness,
            density=plate.density,
            specific_heat=heat.specific_heat,
            conductivity=heat.conductivity,
            front=transfer,
            back=transfer,
        )
        behind = settled(model, -(model.capacity @ model.uniform(1.0)))
        field = model.seen(behind, "bending")
        capacity = float(model.uniform(1.0) @ (model.capacity @ model.uniform(1.0)))
        mean = float(model.uniform(1.0) @ (model.capacity @ behind)) / capacity
        values = shell.space.values(shell.space.points) @ field
        values = values - np.average(values, weights=shell.space.dx)
        weight = np.sqrt(shell.space.dx)
        rows = weight[:, None] * legvander2d(xi, zeta, [POLYNOMIAL_DEGREE, POLYNOMIAL_DEGREE])
        found = np.linalg.lstsq(rows, weight * values, rcond=None)[0]
        return cls(-mean, capacity, found.reshape(POLYNOMIAL_DEGREE + 1, POLYNOMIAL_DEGREE + 1))

    @property
    def conductance(self) -> float:
        """From the air to the plate, W/K, with which one lump lags as much."""
        return self.capacity / self.lag

    def uneven(self, xi: Numbers, zeta: Numbers) -> Numbers:
        """Return b less its mean (Q,), K per K/s, at normalised places (Q,)."""
        return np.asarray(
            legvander2d(xi, zeta, [POLYNOMIAL_DEGREE, POLYNOMIAL_DEGREE]) @ self.coefficients.ravel()
        )

    @property
    def effect(self) -> Effect:
        """The gradient, in proportion to the rate of the temperature."""

        def card(_experiment: Experiment) -> EffectCard:
            return EffectCard(
                name=NAME,
                summary="on a ramp the air warms one side of the plate sooner than the other",
                parameters=(Parameter("share", "1", 0.0, 1.0, 1.0),),
                needs="an up and a down ramp",
                separated_by="thermocouples at the plate's corners",
                title="uneven convection",
                phrase="a gradient of {share} of what the heat equation says",
            )

        def apply(state: PlateState, circumstances: Circumstances, values: Mapping[str, Any]) -> PlateState:
            moved = values["share"] * circumstances.point.rate * self.uneven(state.xi, state.zeta)
            return state.with_(temperature=state.temperature + moved)

        return Effect(card, apply)
