"""An experiment that is to be acquired: one TOML file with the plate, the rig and the protocol.

The sections that are instruments are checked by the class that their ``kind`` names.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, TypeVar

from pydantic import Field, create_model, model_validator

from analysis.channel import UNITS, Motion
from analysis.declaration.strict import Declared, Sparse, Temperature
from analysis.declaration.tolerances import Tolerances
from analysis.declaration.transducers import Drive, Patch, Sensor
from analysis.experiment import Acquisition, Attachment, Experiment, OvenDeclaration, Plate
from analysis.protocol.limits import Limits
from analysis.protocol.objections import Hardware, objections
from analysis.protocol.protocol import AcquisitionProtocol, Programme
from analysis.protocol.sweep import SweepSettings
from analysis.recordings.campaign import Sensitivities, Sensitivity
from app.files.bad_file import quoted
from app.files.campaign_error import CampaignFileError, Problem
from app.files.campaigns.channels import FORMAT
from app.files.campaigns.kind import DECLARATION
from app.files.declarations.simulation_section import Simulation
from app.files.settings_toml import checked, read_table
from drivers.kinds import KindError, Kinds
from drivers.ni.cards import CARDS, CardsSettings
from drivers.ni.modules import find_module
from drivers.ovens.settings import OVENS, OvenSettings
from drivers.thermometers.thermometer import THERMOMETERS, ThermometerSettings

Model = TypeVar("Model", bound=Declared)


class OvenSection(OvenSettings):
    """The oven's limits and whatever its kind adds, and the room it stands in."""

    room_temperature: Temperature


class UnknownInstrument(ValueError):  # noqa: N818 (said of the file, whose section is wrong)
    """A section names a kind that is not there, or whose package is broken.

    Attributes
    ----------
    section : str
        ``cards``, ``oven`` or ``thermometer``.
    wrong : KindError
    """

    def __init__(self, section: str, wrong: KindError) -> None:
        self.section, self.wrong = section, wrong
        super().__init__(f"{section}.kind: {wrong}")

    def said_of(self, path: Path) -> CampaignFileError:
        """Return what a reader of the file raises in its place."""
        wrong = self.wrong
        problem = Problem(path.name, f"{self.section}.kind", wrong.seen, wrong.allowed, wrong.remedy)
        return CampaignFileError(path.parent, [problem])


def instrument_sections(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields that the instruments of an experiment's table make of its model.

    Raises
    ------
    UnknownInstrument
        For a kind that is not there.
    """
    sections: dict[str, Any] = {"cards": (_kind("cards", CARDS, table, default="ni") or CardsSettings, ...)}
    oven = _kind("oven", OVENS, table)
    if oven is not None:
        sections["oven"] = (create_model("OvenSection", __base__=(oven, OvenSection)), ...)
    thermometer = _kind("thermometer", THERMOMETERS, table)
    if thermometer is not None:
        sections["thermometer"] = (thermometer, ...)
    return sections


def _kind(
    section: str, kinds: Kinds[Model], table: Mapping[str, Any], default: str | None = None
) -> type[Model] | None:
    """Return the class of the kind a section names; None where it names none, which its own check then reports."""
    declared = table.get(section)
    name = declared.get("kind", default) if isinstance(declared, Mapping) else default
    if not isinstance(name, str):
        return None
    try:
        return kinds.find(name)
    except KindError as error:
        raise UnknownInstrument(section, error) from error


RANGES: dict[Motion, tuple[float, float]] = {
    "acceleration": (1e-5, 2.0),
    "velocity": (1e-2, 1e6),
    "displacement": (1.0, 1e9),
}
"""Sensitivities that sensors have, V per SI unit."""


class Amplifier(Declared):
    """The power amplifier before the driven patch."""

    gain: Annotated[float, Field(gt=0.0, le=1000.0, description="V/V; roughly: it guards the patch")]


class Exciter(Declared):
    """The shaker, with its amplifier, that makes the generator's volts a force."""

    gain: Annotated[float, Field(gt=0.0, le=1000.0, description="N/V; roughly: it guards the exciter")]
    rated_force: Annotated[float, Field(gt=0.0, le=1e4, description="N, amplitude")]


class AcquiredPatch(Patch):
    """A patch; one that is read by its charge has the sensitivity of its charge amplifier."""

    sensitivity: Annotated[
        float | None, Field(ge=1e3, le=1e14, description="V/C, of the charge amplifier: 1 mV/pC is 1e9 V/C")
    ] = None

    @model_validator(mode="after")
    def _of_a_charge(self) -> Self:
        if self.quantity == "charge" and self.sensitivity is None:
            raise ValueError(
                f"patch {self.id!r} has quantity charge and no sensitivity; give that of its charge amplifier, "
                "1e3 to 1e14 V/C (1 mV/pC is 1e9 V/C)"
            )
        if self.quantity != "charge" and self.sensitivity is not None:
            raise ValueError(
                f"patch {self.id!r} has quantity {self.quantity} and sensitivity {self.sensitivity:g}; only a "
                "charge needs one: remove sensitivity"
            )
        return self

    @property
    def volts(self) -> float:
        """V per unit of what is read."""
        return 1.0 if self.sensitivity is None else self.sensitivity

    def recorded(self) -> Patch:
        """Return what a campaign declares of it."""
        return Patch.model_validate(self.model_dump(exclude={"sensitivity"}))


class AcquiredDrive(Drive):
    """A force, and the sensor that measures it."""

    sensitivity: Annotated[float, Field(ge=1e-6, le=1.0, description="V/N, of the force sensor")]

    def recorded(self) -> Drive:
        """Return what a campaign declares of it."""
        return Drive.model_validate(self.model_dump(exclude={"sensitivity"}))


class AcquiredSensor(Sensor):
    """A sensor of motion; of many points, all with the same sensitivity."""

    sensitivity: Annotated[
        float, Field(gt=0.0, le=1e9, description="V per m/s2, m/s or m; with sensitivity_unit mV/g")
    ]
    sensitivity_unit: Annotated[
        Literal["mV/g"] | None, Field(description="of an accelerometer's; left out: SI")
    ] = None

    @model_validator(mode="after")
    def _plausible(self) -> Self:
        if self.sensitivity_unit is not None and self.kind != "acceleration":
            raise ValueError(
                f"sensor {self.id!r} has sensitivity_unit {self.sensitivity_unit} and measures {self.kind}; "
                f"remove sensitivity_unit and give V per {UNITS[self.kind]}"
            )
        low, high = RANGES[self.kind]
        if not low <= self.volts <= high:
            unit = f"V per {UNITS[self.kind]}"
            seen = f"{self.sensitivity:g} {self.sensitivity_unit or unit}"
            other = '; sensitivity_unit = "mV/g" takes a data sheet\'s' if self.kind == "acceleration" else ""
            raise ValueError(
                f"sensor {self.id!r} has sensitivity {seen}; {low:g} to {high:g} {unit} allowed{other}"
            )
        return self

    @property
    def volts(self) -> float:
        """V per SI unit."""
        from scipy.constants import g

        return self.sensitivity if self.sensitivity_unit is None else self.sensitivity * 1e-3 / g

    def recorded(self) -> Sensor:
        """Return what a campaign declares of it."""
        return Sensor.model_validate(self.model_dump(exclude={"sensitivity", "sensitivity_unit"}))


LARGEST_LIMIT_DISTANCE = 30.0
"""How far beyond the oven's set-points the limits of a campaign may lie, K."""


def far_limits(name: str, limits: Limits, oven: OvenSettings) -> Iterator[Problem]:
    """Yield what is wrong with the limits of a campaign.

    Parameters
    ----------
    name : str
        Of the experiment's file.

    Yields
    ------
    Problem
        A limit more than `LARGEST_LIMIT_DISTANCE` beyond the oven's own.
    """
    least, most = oven.minimum - LARGEST_LIMIT_DISTANCE, oven.maximum + LARGEST_LIMIT_DISTANCE
    remedy = (
        "choose a nearer limit, or correct [oven]: it must stop a campaign that leaves the range of the set-points"
    )
    if limits.hottest > most:
        allowed = f"at most {most:g} °C, oven.maximum + {LARGEST_LIMIT_DISTANCE:g} K"
        yield Problem(name, "limits.hottest", f"{limits.hottest:g} °C", allowed, remedy)
    if limits.coldest < least:
        allowed = f"at least {least:g} °C, oven.minimum - {LARGEST_LIMIT_DISTANCE:g} K"
        yield Problem(name, "limits.coldest", f"{limits.coldest:g} °C", allowed, remedy)


RigKind = Literal["simulated", "real", "ni"]
"""``ni`` is the older word for ``real``, from before there were cards of other makers."""


class Inputs(Declared):
    """The input module, and what it puts across each sensor patch."""

    module: str
    input_resistance: Annotated[float, Field(ge=1e3, le=1e12, description="ohm")]
    input_capacitance: Annotated[float, Field(ge=0.0, le=1e-6, description="F, module plus cable")]


class AcquiredExperiment(Sparse):
    """The whole file; what its instruments declare besides is up to their kinds, see `experiment_model`."""

    always: ClassVar[frozenset[str]] = frozenset({"string", "cable", "simulation"})

    format: Literal["experiment/1"]
    title: str
    operator: str = ""
    rig: Annotated[RigKind, Field(description="which rig runs it, unless --rig is given")]
    plate: Plate
    patch: tuple[AcquiredPatch, ...] = ()
    drive: Annotated[tuple[AcquiredDrive, ...], Field(max_length=1)] = ()
    sensor: Annotated[tuple[AcquiredSensor, ...], Field(max_length=100)] = ()
    string: tuple[Attachment, ...] = ()
    cable: tuple[Attachment, ...] = ()
    acquisition: Inputs
    amplifier: Amplifier | None = None
    exciter: Exciter | None = None
    cards: CardsSettings
    oven: OvenSection
    thermometer: ThermometerSettings | None = None
    sweep: SweepSettings
    programme: Programme
    limits: Limits
    simulation: Simulation | None = None
    tolerances: Tolerances = Tolerances()

    def on(self, rig: RigKind) -> Self:
        """Return the same for a rig; where that is simulated, the title says so wherever results go."""
        if rig != "simulated" or "simulated" in self.title:
            return self
        return self.model_copy(update={"title": f"{self.title} (simulated)"})

    @property
    def protocol(self) -> AcquisitionProtocol:
        """What is measured when."""
        forced, settling = bool(self.drive), self.cards.settling
        read = [patch.id for patch in self.patch if patch.role == "sensor"]
        read += [channel.id for sensor in self.sensor for channel in sensor.channels(self.plate)]
        named = tuple(f"{one} ({at})" for one, at in zip(read, self.cards.responses, strict=False))
        touching: tuple[str, ...] = getattr(self.cards, "thermocouples", ())  # a sound card has none
        return AcquisitionProtocol(self.sweep, self.programme, self.limits, forced, settling, named, touching)

    @property
    def drive_gain(self) -> float:
        """What is stated of the amplifier, V/V, or of the exciter, N/V."""
        driver = self.amplifier or self.exciter
        if driver is None:
            raise AssertionError("refused when it was made")
        return driver.gain

    @property
    def sensitivities(self) -> Sensitivities:
        """What every channel gives at the cards, in the order of ``cards.inputs``."""
        declared = self.recorded(self.sample_rate)
        volts = [patch.volts for patch in self.patch if patch.role == "sensor"]
        volts += [sensor.volts for sensor in self.sensor for _ in sensor.places(self.plate)]
        return Sensitivities(
            Sensitivity(declared.inputs[0], self.drive[0].sensitivity if self.drive else 1.0),
            tuple(Sensitivity(*one) for one in zip(declared.outputs, volts, strict=True)),
        )

    @property
    def plate_measured(self) -> bool:
        """Whether a sensor on the plate gives the temperatures of its sweeps."""
        return self.cards.has_thermocouples or self.thermometer is not None

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
            operator=self.operator,
            plate=self.plate,
            patch=tuple(patch.recorded() for patch in self.patch),
            drive=tuple(drive.recorded() for drive in self.drive),
            sensor=tuple(sensor.recorded() for sensor in self.sensor),
            string=self.string,
            cable=self.cable,
            acquisition=Acquisition(
                module=inputs.module,
                sample_rate=sample_rate,
                input_resistance=inputs.input_resistance,
                input_capacitance=inputs.input_capacitance,
            ),
            protocol=self.protocol.recorded(),
            oven=OvenDeclaration(room_temperature=self.oven.room_temperature),
            tolerances=self.tolerances,
        )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        declared = self.recorded(self.sample_rate)
        sensors, wired = [output.id for output in declared.outputs], self.cards.responses
        if len(sensors) != len(wired):
            raise ValueError(
                f"cards.responses names {len(wired)} terminals for the {len(sensors)} sensors {sensors}; "
                "one each, in this order"
            )
        named = [channel.id for channel in declared.inputs]
        if len(named) > 1:
            raise ValueError(
                f"patch, drive: {len(named)} would drive ({', '.join(named)}), but the cards have one output; "
                'give the other patches role = "shorted", remove other drives, and acquire a campaign with each; '
                "flexura import joins them"
            )
        patch_driven = not self.drive
        for key, given, wanted in (
            ("amplifier", self.amplifier, patch_driven),
            ("limits.patch_voltage", self.limits.patch_voltage, patch_driven),
            ("exciter", self.exciter, not patch_driven),
        ):
            if (given is not None) != wanted:
                driven = f"{'patch' if patch_driven else 'drive'} {declared.inputs[0].id!r} is driven"
                raise ValueError(
                    f"{key} is {'missing' if wanted else 'given'}, but {driven}; "
                    + ("add it" if wanted else "remove it")
                )
        if self.programme.watch == "plate" and not self.plate_measured:
            raise ValueError(
                "programme.watch is the plate, but cards.thermocouples names no thermocouple on it, and there is "
                "no [thermometer]; name one, or watch the air"
            )
        if self.cards.has_thermocouples and self.thermometer is not None:
            raise ValueError("the plate has both cards.thermocouples and a [thermometer]; remove one of them")
        if self.rig == "simulated" and self.simulation is None:
            raise ValueError("rig is simulated, but there is no [simulation], which declares what is simulated")
        return self


def experiment_model(table: Mapping[str, Any]) -> type[AcquiredExperiment]:
    """Return the model of an experiment with the instruments of these kinds, which know their own keys.

    Raises
    ------
    UnknownInstrument
        For a kind that is not there.
    """
    return create_model("AcquiredExperiment", __base__=AcquiredExperiment, **instrument_sections(table))


def read_declared_experiment(path: Path) -> AcquiredExperiment:
    """Read an experiment's file.

    Raises
    ------
    CampaignFileError
        With every key that is wrong.
    """
    if path.is_dir():
        takes = (
            f"; flexura import {quoted(path)} takes this recorded campaign"
            if (path / DECLARATION).is_file()
            else ""
        )
        raise CampaignFileError(path, [Problem("", "", f"a folder; an experiment is a TOML file{takes}", "")])
    table = read_table(path)
    if table.get("format") == FORMAT:
        seen = (
            f"declares a recorded campaign (format {FORMAT!r}), which flexura import {quoted(path.parent)} takes"
        )
        raise CampaignFileError(path.parent, [Problem(path.name, "", seen, "")])
    if table.get("kind") == "hammer":
        seen = (
            f"declares a hammer test, which flexura acquire {quoted(path)} takes, and no campaign over an oven's "
            "programme"
        )
        raise CampaignFileError(path.parent, [Problem(path.name, "kind", seen, "")])
    _require_recorded_force(path, table)
    try:
        model = experiment_model(table)
    except UnknownInstrument as error:
        raise error.said_of(path) from error
    return checked(path, table, model)


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
        drive_gain=experiment.drive_gain,
        oven_minimum=oven.minimum,
        oven_maximum=oven.maximum,
        oven_max_rate=oven.max_rate,
        rated_force=experiment.exciter.rated_force if experiment.exciter else None,
    )
    found = [
        Problem(path.name, one.key, one.seen, one.allowed, one.remedy)
        for one in objections(experiment.protocol, hardware)
    ]
    found += far_limits(path.name, experiment.limits, experiment.oven)
    if found:
        raise CampaignFileError(path.parent, found)
    return experiment


def _require_recorded_force(path: Path, table: Mapping[str, Any]) -> None:
    """Raise CampaignFileError for a force without a channel; pydantic would only miss a terminal."""
    cards = table.get("cards")
    if table.get("drive") and isinstance(cards, Mapping) and "drive_input" not in cards:
        allowed = "the terminal of the drive's force sensor, such as 'cDAQ1Mod1/ai0'"
        remedy = "without the force there is nothing to refer the responses to"
        raise CampaignFileError(path.parent, [Problem(path.name, "cards.drive_input", "nothing", allowed, remedy)])


def _require_known_effects(path: Path, experiment: AcquiredExperiment, simulation: Simulation) -> None:
    from app.files.declarations.hidden_effects import (
        effect_problems,  # the library takes a moment, and few files ask for it
    )

    problems = effect_problems(path.name, experiment.recorded(experiment.sample_rate), simulation.effects)
    if problems:
        raise CampaignFileError(path.parent, problems)
