"""An experiment that is to be acquired: one TOML file with the plate, the rig and the protocol."""

from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.declared import Declared
from analysis.experiment import Acquisition, Attachment, Experiment, Oven, Patch, Plate, Temperature
from analysis.material import Material, MaterialLaws
from analysis.material_table import laws_through
from analysis.protocol.limits import Limits
from analysis.protocol.objections import Hardware, objections
from analysis.protocol.programme import Programme
from analysis.protocol.protocol import AcquisitionProtocol
from analysis.protocol.sweep import SweepSettings
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaign_toml import FORMAT, NAME
from app.files.far_limits import far_limits
from app.files.settings_toml import checked, read_table
from drivers.ni.modules import find_module
from drivers.ni.wiring import Wiring
from drivers.ovens.settings import OvenSettings

RigKind = Literal["simulated", "ni"]
Column = tuple[float, ...]
SLOTS = (("1", "NI-9234"), ("2", "NI-9260"), ("3", "NI-9211"))
"""Modules of the simulated chassis unless the file says otherwise."""


class Inputs(Declared):
    """The input module, and what it puts across each sensor patch."""

    module: str
    input_resistance: Annotated[float, Field(ge=1e3, le=1e12, description="ohm")]
    input_capacitance: Annotated[float, Field(ge=0.0, le=1e-6, description="F, module plus cable")]


class Amplifier(Declared):
    """The power amplifier before the driven patch."""

    gain: Annotated[float, Field(gt=0.0, le=1000.0, description="V/V; roughly: it guards the patch")]


class OvenSection(OvenSettings):
    """The oven's line and limits, and the room it stands in."""

    room_temperature: Temperature


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
        float | None, Field(gt=0.0, le=1000.0, exclude=True, description="V/V; unset: amplifier.gain")
    ] = None
    noise: Annotated[
        float | None, Field(ge=0.0, le=1.0, description="V rms on every input; unset: the module's own")
    ] = None
    modules: Annotated[
        dict[str, str], Field(min_length=2, description="slot -> module", default_factory=lambda: dict(SLOTS))
    ]
    served: Annotated[bool, Field(description="reach the cards over a loopback port, not in this process")] = False
    laws: Annotated[Laws, Field(exclude=True)]
    effects: Annotated[
        dict[str, dict[str, float]],
        Field(exclude=True, description="parameters by effect", default_factory=dict),
    ]


class AcquiredExperiment(Declared):
    """The whole file."""

    format: Literal["experiment/1"]
    title: str
    rig: Annotated[RigKind, Field(description="which rig runs it unless --rig says otherwise")]
    plate: Plate
    patch: Annotated[tuple[Patch, ...], Field(min_length=2)]
    string: tuple[Attachment, ...] = ()
    cable: tuple[Attachment, ...] = ()
    acquisition: Inputs
    amplifier: Amplifier
    cards: Wiring
    oven: OvenSection
    sweep: SweepSettings
    programme: Programme
    limits: Limits
    simulation: Simulation | None = None

    def on(self, rig: RigKind) -> Self:
        """Return the same for a rig; where that is simulated, the title says so wherever results go."""
        if rig != "simulated" or "simulated" in self.title:
            return self
        return self.model_copy(update={"title": f"{self.title} (simulated)"})

    @property
    def protocol(self) -> AcquisitionProtocol:
        """What is measured when."""
        return AcquisitionProtocol(self.sweep, self.programme, self.limits)

    @property
    def sample_rate(self) -> float:
        """Rate the input module makes of ``cards.sample_rate``, Hz; the same where the module is unknown."""
        module = find_module(self.acquisition.module)
        return module.coerced_rate(self.cards.sample_rate) if module else self.cards.sample_rate

    def recorded(self, sample_rate: float) -> Experiment:
        """Return the declaration its campaign will carry; `sample_rate` (Hz) as read back from the cards."""
        inputs = self.acquisition
        return Experiment(
            title=self.title,
            plate=self.plate,
            patch=self.patch,
            string=self.string,
            cable=self.cable,
            acquisition=Acquisition(
                module=inputs.module,
                sample_rate=sample_rate,
                input_resistance=inputs.input_resistance,
                input_capacitance=inputs.input_capacitance,
            ),
            protocol=self.protocol.recorded(),
            oven=Oven(room_temperature=self.oven.room_temperature),
        )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        sensors = [patch.id for patch in self.patch if patch.role == "sensor"]
        amplified = [patch.id for patch in self.patch if patch.quantity == "charge"]
        if amplified:
            raise ValueError(
                f"patches {amplified} have quantity charge; flexura acquire reads volts across patches only: "
                "record charges elsewhere and import them"
            )
        if len(sensors) != len(self.cards.responses):
            raise ValueError(
                f"cards.responses names {len(self.cards.responses)} terminals for the "
                f"{len(sensors)} sensors {sensors}; one each, in the order of the patches"
            )
        if self.programme.watch == "plate" and not self.cards.thermocouples:
            raise ValueError(
                "programme.watch is the plate, but cards.thermocouples names no thermocouple on it; "
                "name one, or watch the air"
            )
        if self.rig == "simulated" and self.simulation is None:
            raise ValueError("rig is simulated, but there is no [simulation] that says what is simulated")
        self.recorded(self.sample_rate)
        return self


def read_declared_experiment(path: Path) -> AcquiredExperiment:
    """Read an experiment's file.

    Raises
    ------
    CampaignFileError
        With every key that is wrong.
    """
    if path.is_dir():
        takes = f"; flexura import {path} takes this recorded campaign" if (path / NAME).is_file() else ""
        raise CampaignFileError(path, [Problem("", "", f"a folder; an experiment is a TOML file{takes}", "")])
    table = read_table(path)
    if table.get("format") == FORMAT:
        seen = f"declares a recorded campaign (format {FORMAT!r}), which flexura import {path.parent} takes"
        raise CampaignFileError(path.parent, [Problem(path.name, "", seen, "")])
    return checked(path, table, AcquiredExperiment)


def read_acquired_experiment(path: Path) -> AcquiredExperiment:
    """Read an experiment's file, and hold its protocol against cards, amplifier and oven.

    Raises
    ------
    CampaignFileError
        With every key that is wrong, or every reason why this hardware cannot run this protocol.
    """
    experiment = read_declared_experiment(path)
    if experiment.simulation is not None and experiment.simulation.effects:
        _require_known_effects(path, experiment, experiment.simulation)
    oven = experiment.oven
    hardware = Hardware(
        sample_rate=experiment.sample_rate,
        output_range=experiment.cards.output_range,
        amplifier_gain=experiment.amplifier.gain,
        oven_minimum=oven.minimum,
        oven_maximum=oven.maximum,
        oven_max_rate=oven.max_rate,
    )
    found = [
        Problem(path.name, one.key, one.seen, one.allowed, one.remedy)
        for one in objections(experiment.protocol, hardware)
    ]
    found += far_limits(path.name, experiment.limits, experiment.oven)
    if found:
        raise CampaignFileError(path.parent, found)
    return experiment


def _require_known_effects(path: Path, experiment: AcquiredExperiment, simulation: Simulation) -> None:
    from app.files.hidden_effects import effect_problems  # the library takes a moment, and few files ask for it

    problems = effect_problems(path.name, experiment.recorded(experiment.sample_rate), simulation.effects)
    if problems:
        raise CampaignFileError(path.parent, problems)
