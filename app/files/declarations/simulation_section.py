"""What the simulated rig of an experiment is: the table ``[simulation]`` of its file."""

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declaration.strict import Declared
from analysis.material import Material, MaterialLaws, laws_through
from analysis.weather.declared_weather import PlateHeat

Share = Annotated[float, Field(ge=-1.8, le=1.8)]
Column = tuple[float, ...]
SLOTS = (("1", "NI-9234"), ("2", "NI-9260"), ("3", "NI-9211"), ("4", "NI-9215"), ("5", "NI-9263"))
"""Modules of the simulated chassis unless the file says otherwise."""


class Laws(Declared):
    """What the simulated plate is made of, at temperatures that ascend."""

    temperature: Annotated[Column, Field(min_length=4, description="degrees Celsius")]
    youngs_modulus: Annotated[Column, Field(min_length=4, description="Pa")]
    poisson_ratio: Annotated[Column, Field(min_length=4)]
    loss_factor: Annotated[Column, Field(min_length=4)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for name in ("youngs_modulus", "poisson_ratio", "loss_factor"):
            values = getattr(self, name)
            if len(values) != len(self.temperature):
                raise ValueError(f"{name} has {len(values)} values for {len(self.temperature)} temperatures")
            if min(values) <= 0.0:
                raise ValueError(f"{name} {min(values):g} must be above 0")
        if max(self.poisson_ratio) >= 0.5:
            raise ValueError(f"poisson_ratio {max(self.poisson_ratio):g} must be below 0.5")
        self.laws()
        return self

    def laws(self) -> MaterialLaws:
        """Return continuous laws through the values."""
        columns = (self.youngs_modulus, self.poisson_ratio, self.loss_factor)
        return laws_through(np.array(self.temperature), Material(*(np.array(column) for column in columns)))


class HeatInOven(PlateHeat):
    """What warms the simulated plate: moving air on both faces."""

    convection: Annotated[float, Field(gt=0.0, le=500.0, description="W/(m2 K), in the middle")] = 10.0
    uneven: Annotated[
        tuple[Share, Share],
        Field(description="by which share of it more at the largest x than at the smallest, and at the largest y"),
    ] = (0.0, 0.0)

    @model_validator(mode="after")
    def _everywhere(self) -> Self:
        if abs(self.uneven[0]) + abs(self.uneven[1]) >= 2.0:
            raise ValueError(
                f"uneven {list(self.uneven)} leaves a corner without convection; allowed: together below 2"
            )
        return self


class Simulation(Declared):
    """What the simulated rig is; the real one is not asked.

    What a campaign is to find out (gain, laws, effects) is left out of every dump, so that no campaign folder
    tells it; the experiment's SHA-256, which is there, holds it fast.

    `effects` are what the plate has besides (``[simulation.effects.point_mass]``, ``mass = 0.0008``). Their
    temperature is that of the simulated oven's plate, which its sensor reads, and their rate is the present one
    of that temperature; so ``thermal_lag`` holds the plate behind its own sensor, not behind the air, which it
    follows late without any effect. Their level is the drive's amplitude before the amplifier, V.
    """

    seed: Annotated[int, Field(ge=0, description="of every noise")] = 0
    gain: Annotated[
        float | None, Field(gt=0.0, le=1000.0, exclude=True, description="V/V, or N/V; unset: as stated")
    ] = None
    noise: Annotated[
        float | None, Field(ge=0.0, le=1.0, description="V rms on every input; unset: the module's own")
    ] = None
    modules: Annotated[
        dict[str, str], Field(min_length=2, description="slot -> module", default_factory=lambda: dict(SLOTS))
    ]
    served: Annotated[bool, Field(description="reach the cards over a loopback port, not in this process")] = False
    heat: Annotated[
        HeatInOven | None, Field(exclude=True, description="left out: a lag of 150 s, everywhere alike")
    ] = None
    laws: Annotated[Laws, Field(exclude=True)]
    effects: Annotated[
        dict[str, dict[str, float]],
        Field(exclude=True, description="parameters by effect", default_factory=dict),
    ]
