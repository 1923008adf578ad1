"""A hammer test that is to be acquired: one TOML file with the plate, the points, the sensors and the cards."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from analysis.declared import Declared, Point, Sparse, Temperature
from analysis.estimation.impacts import HammerTest
from analysis.experiment import Acquisition, Attachment, Experiment, OvenDeclaration, Plate, Protocol
from analysis.tolerances import Tolerances
from analysis.transducers import Drive, Name, Radius, Side
from app.files.campaign_error import CampaignFileError, Problem
from app.files.experiment_toml import AcquiredSensor, RigKind
from app.files.settings_toml import checked, read_table
from app.files.simulation_section import Simulation
from drivers.hammer.trigger import TriggerSettings
from drivers.ni.input_wiring import InputWiring

KIND = "hammer"
MOST_SIMULATED = 100
"""Points that a simulated hammer can hit: as many forces as a declaration of a plate can have."""


class HammerDrive(Sparse):
    """The hammer: where it hits, and its force sensor."""

    id: Name
    sensitivity: Annotated[float, Field(ge=1e-6, le=10.0, description="V/N, of the force sensor")]
    point: Point | None = None
    points: Annotated[tuple[Point, ...] | None, Field(min_length=2, max_length=5000)] = None
    radius: Radius = 0.002
    side: Side = "top"

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if (self.point is None) == (self.points is None):
            raise ValueError(
                f"drive {self.id!r} has {'no place' if self.point is None else 'point and points'}; give point, "
                "where it always hits, or points, between which it moves"
            )
        if self.id == "drive":
            raise ValueError("drive 'drive': the name stands for every drive's channel; choose another id")
        return self

    @property
    def places(self) -> tuple[Point, ...]:
        """Where it hits, m, in the order in which the points are asked for."""
        return self.points if self.points is not None else (self.point or (0.0, 0.0),)

    @property
    def roves(self) -> bool:
        """Whether it moves between several points."""
        return self.points is not None

    def forces(self) -> tuple[Drive, ...]:
        """Return the force at each point."""
        return tuple(
            Drive(id=f"{self.id}{number}" if self.roves else self.id, point=p, radius=self.radius, side=self.side)
            for number, p in enumerate(self.places, start=1)
        )


class HammerHits(Declared):
    """How hits are heard and judged; `trigger`, `pretrigger`, `duration` and `double_hit` as in ``test.toml``."""

    trigger: Annotated[float, Field(gt=0.0, le=1e5, description="N above rest")]
    pretrigger: Annotated[float, Field(ge=0.001, le=1.0, description="s before the trigger")] = 0.02
    duration: Annotated[float, Field(gt=0.0, le=100.0, description="s of a block, the pretrigger included")]
    hits: Annotated[int, Field(ge=1, le=100, description="at each point")] = 5
    double_hit: Annotated[float, Field(gt=0.0, le=1.0, description="share of the first peak")] = 0.1
    overload: Annotated[float, Field(gt=0.1, le=1.0, description="share of what an input can hold")] = 0.98
    band: Annotated[tuple[float, float], Field(description="Hz, where the force is even")]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not 0.0 < self.band[0] < self.band[1]:
            raise ValueError(f"band {list(self.band)} Hz: the lower edge must be above 0 and below the upper edge")
        self.test()
        return self

    def test(self) -> HammerTest:
        """Return the settings as what judges hits takes them."""
        return HammerTest(self.trigger, self.pretrigger, self.duration, self.double_hit)

    def triggering(self, volts: float) -> TriggerSettings:
        """Return the settings of the trigger; `volts` is the sensitivity of the force sensor, V/N."""
        return TriggerSettings(self.trigger * volts, self.pretrigger, self.duration)


class HammerInHand(Declared):
    """How the simulated hammer is held: ``[simulation.hammer]``."""

    peak: Annotated[float, Field(gt=0.0, le=1e5, description="N, median")] = 30.0
    spread: Annotated[float, Field(ge=0.0, le=1.0, description="of its logarithm")] = 0.2
    width: Annotated[float, Field(ge=1e-5, le=0.05, description="s, half width at 1/e")] = 4e-4
    double_hits: Annotated[float, Field(ge=0.0, le=1.0, description="share of all hits")] = 0.05
    overloads: Annotated[float, Field(ge=0.0, le=1.0, description="share of all hits")] = 0.03
    pause: Annotated[float, Field(ge=0.2, le=60.0, description="s before each hit")] = 1.0

    @model_validator(mode="after")
    def _shares(self) -> Self:
        if self.double_hits + self.overloads > 0.9:
            raise ValueError(
                f"double_hits {self.double_hits:g} and overloads {self.overloads:g} leave too few good hits; "
                "allowed: together at most 0.9"
            )
        return self


class HammerSimulation(Simulation):
    """What is simulated of a hammer test: besides cards and plate, who hits it."""

    temperature: Annotated[Temperature, Field(description="degrees Celsius, of the plate")] = 21.0
    hammer: Annotated[HammerInHand, Field(default_factory=HammerInHand)]

    @model_validator(mode="after")
    def _has_no_oven(self) -> Self:
        for name in ("heat", "gain"):
            if getattr(self, name) is not None:
                raise ValueError(f"{name}: a hammer test has neither oven nor amplifier; remove it")
        return self


class HammerExperiment(Sparse):
    """The whole file."""

    always: ClassVar[frozenset[str]] = frozenset({"string", "cable", "simulation"})

    format: Literal["experiment/1"]
    kind: Literal["hammer"]
    title: str
    operator: str = ""
    rig: Annotated[RigKind, Field(description="which rig runs it, unless --rig is given")]
    temperature: Annotated[
        Temperature | None, Field(description="degrees Celsius, of the plate; unset: of the thermocouples")
    ] = None
    plate: Plate
    drive: Annotated[tuple[HammerDrive, ...], Field(min_length=1, max_length=1)]
    sensor: Annotated[tuple[AcquiredSensor, ...], Field(min_length=1, max_length=100)]
    string: tuple[Attachment, ...] = ()
    cable: tuple[Attachment, ...] = ()
    cards: InputWiring
    hammer: HammerHits
    simulation: HammerSimulation | None = None
    tolerances: Tolerances = Tolerances()

    def on(self, rig: RigKind) -> Self:
        """Return the same for a rig; where that is simulated, the title says so wherever results go."""
        if rig != "simulated" or "simulated" in self.title:
            return self
        return self.model_copy(update={"title": f"{self.title} (simulated)"})

    @property
    def mallet(self) -> HammerDrive:
        """The only drive."""
        return self.drive[0]

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of what is recorded: force, then the sensors, in the order of ``cards.inputs``."""
        return (self.mallet.id, *(one.id for sensor in self.sensor for one in sensor.channels(self.plate)))

    @property
    def units(self) -> tuple[str, ...]:
        """SI units of the channels."""
        return ("N", *(one.unit for sensor in self.sensor for one in sensor.channels(self.plate)))

    @property
    def volts(self) -> tuple[float, ...]:
        """V per unit of each channel."""
        volts = (sensor.volts for sensor in self.sensor for _ in sensor.places(self.plate))
        return (self.mallet.sensitivity, *volts)

    def struck(self) -> Experiment:
        """Return the plate with a force at every point: what is hit, as a twin declares it."""
        rate = self.cards.sample_rate
        return Experiment(
            title=self.title,
            plate=self.plate,
            drive=self.mallet.forces(),
            sensor=tuple(sensor.recorded() for sensor in self.sensor),
            string=self.string,
            cable=self.cable,
            acquisition=Acquisition(module="none", sample_rate=rate, input_resistance=1e6, input_capacitance=0.0),
            protocol=Protocol(
                sweep="linear",
                band=self.hammer.band,
                sweep_duration=self.hammer.duration,
                tail=0.0,
                repeats=self.hammer.hits,
                ramp_rate=0.0,
                temperatures=(20.0,),
                directions=("up",),
                levels=(1.0,),
            ),
            oven=OvenDeclaration(room_temperature=20.0),
            tolerances=self.tolerances,
        )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for force in self.mallet.forces():
            force.check(self.plate)
        for sensor in self.sensor:
            sensor.check(self.plate)
        names, wired = self.channels, self.cards.responses
        if len(names) - 1 != len(wired):
            raise ValueError(
                f"cards.responses names {len(wired)} terminals for the {len(names) - 1} sensors "
                f"{list(names[1:])}; one each, in this order"
            )
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"id {name!r} is used {names.count(name)} times among drive and sensors")
        kinds = sorted({sensor.kind for sensor in self.sensor})
        if self.mallet.roves and len(kinds) > 1:
            raise ValueError(f"sensor: {' and '.join(kinds)} beside a hammer that moves; use sensors of one kind")
        if self.mallet.roves and any(sensor.point is None for sensor in self.sensor):
            raise ValueError("sensor: several points beside a hammer that moves; give each sensor one point")
        if self.hammer.band[1] >= 0.45 * self.cards.sample_rate:
            raise ValueError(
                f"hammer.band ends at {self.hammer.band[1]:g} Hz; below {0.45 * self.cards.sample_rate:g} Hz "
                "allowed, 0.45 of cards.sample_rate, where the filters of the cards end"
            )
        if (self.temperature is None) == (not self.cards.has_thermocouples):
            both = self.temperature is not None
            raise ValueError(
                f"temperature and cards.thermocouples: {'both' if both else 'none'} given; "
                + ("remove one" if both else "declare the plate's temperature, or a thermocouple on it")
            )
        if self.rig == "simulated" and self.simulation is None:
            raise ValueError("rig is simulated, but there is no [simulation], which declares what is simulated")
        return self


def declares_hammer_test(path: Path) -> bool:
    """Whether a file is an experiment with ``kind = "hammer"``; False for what cannot be read."""
    if not path.is_file():
        return False
    try:
        return is_hammer_table(read_table(path))
    except CampaignFileError:
        return False


def is_hammer_table(table: Mapping[str, Any]) -> bool:
    """Whether keys and values, unchecked, are those of an experiment with ``kind = "hammer"``."""
    return bool(table.get("kind") == KIND)


def read_hammer_experiment(path: Path) -> HammerExperiment:
    """Read an experiment with ``kind = "hammer"``; CampaignFileError with every key that is wrong."""
    experiment = checked(path, read_table(path), HammerExperiment)
    if experiment.simulation is not None and experiment.simulation.effects:
        from app.files.hidden_effects import (
            effect_problems,  # the library takes a moment, and few files ask for it
        )

        problems = effect_problems(path.name, experiment.struck(), experiment.simulation.effects)
        if problems:
            raise CampaignFileError(path.parent, problems)
    return experiment


def require_simulated(experiment: HammerExperiment, file: Path) -> HammerSimulation:
    """Return what is simulated; CampaignFileError where the file does not say it, or nobody could compute it."""
    problems = []
    if experiment.simulation is None:
        allowed = "a table that declares what is simulated: laws, seed, noise, hammer"
        problems.append(Problem(file.name, "simulation", "nothing", allowed))
    if len(experiment.mallet.places) > MOST_SIMULATED:
        seen = f"{len(experiment.mallet.places)} points"
        problems.append(Problem(file.name, "drive.points", seen, f"at most {MOST_SIMULATED} on the simulated rig"))
    kinds = sorted({sensor.kind for sensor in experiment.sensor} - {"acceleration"})
    if kinds:
        remedy = "a free plate that is hit drifts away, and with it what these sensors would read"
        problems.append(Problem(file.name, "sensor.kind", kinds[0], "acceleration on the simulated rig", remedy))
    if problems or experiment.simulation is None:
        raise CampaignFileError(file.parent, problems)
    return experiment.simulation
