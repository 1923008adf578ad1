"""A hammer test that is to be acquired: one TOML file with the plate, the points, the sensors and the cards."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, create_model, model_validator

from analysis.declaration.strict import Declared, Point, Sparse, Temperature
from analysis.declaration.tolerances import Tolerances
from analysis.declaration.transducers import MOST_POINTS, Drive, Name, Radius, Side
from analysis.estimation.impacts import HammerTest
from analysis.experiment import Acquisition, Attachment, Experiment, OvenDeclaration, Plate, Protocol
from analysis.protocol.limits import Limits
from analysis.protocol.protocol import AcquisitionProtocol, Programme, Rate, Settling
from analysis.protocol.sweep import SweepSettings
from app.files.campaign_error import CampaignFileError, Problem
from app.files.declarations.experiment import (
    AcquiredSensor,
    OvenSection,
    RigKind,
    UnknownInstrument,
    far_limits,
    instrument_sections,
)
from app.files.declarations.simulation_section import Simulation
from app.files.settings_toml import checked, read_table
from drivers.hammer.hammer_rig import TriggerSettings
from drivers.ni.wiring import InputWiring
from drivers.thermometers.thermometer import ThermometerSettings

KIND = "hammer"
MOST_SIMULATED = 100
"""Points that a simulated hammer can hit: its twin answers to a force at each."""


class HammerDrive(Sparse):
    """The hammer: where it hits, and its force sensor."""

    id: Name
    sensitivity: Annotated[float, Field(ge=1e-6, le=10.0, description="V/N, of the force sensor")]
    point: Point | None = None
    points: Annotated[tuple[Point, ...] | None, Field(min_length=2, max_length=MOST_POINTS)] = None
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
    coupling: Annotated[
        float | None, Field(gt=0.0, le=100.0, description="Hz, corner of inputs that couple AC")
    ] = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not 0.0 < self.band[0] < self.band[1]:
            raise ValueError(f"band {list(self.band)} Hz: the lower edge must be above 0 and below the upper edge")
        self.test()
        return self

    def test(self) -> HammerTest:
        """Return the settings as what judges hits takes them."""
        return HammerTest(self.trigger, self.pretrigger, self.duration, self.double_hit, coupling=self.coupling)

    def triggering(self, volts: float) -> TriggerSettings:
        """Return the settings of the trigger; `volts` is the sensitivity of the force sensor, V/N."""
        return TriggerSettings(self.trigger * volts, self.pretrigger, self.duration)


LARGEST_MOVE = 2.5
"""Largest change of temperature between two readings on the way, K: half of what `Programme.tolerance` allows."""


class HammerSetPoints(Declared):
    """Temperatures at which the plate is hit, one after the other, each held while it is hit: ``[set_points]``."""

    temperatures: Annotated[tuple[Temperature, ...], Field(min_length=1, max_length=200)]
    ramp_rate: Annotated[Rate, Field(description="K/min, magnitude, from one to the next")]
    within: Annotated[
        float, Field(ge=0.05, le=5.0, description="K from the set-point; a hit beyond is rejected")
    ] = 0.5
    soak: Annotated[float, Field(ge=0.0, le=86_400.0, description="s within it, before the first hit")] = 600.0
    timeout: Annotated[float, Field(ge=60.0, le=172_800.0, description="s to get there, beyond the ramp")] = (
        14_400.0
    )
    watch: Annotated[Literal["plate", "air"], Field(description="temperature that counts")] = "plate"
    poll_interval: Annotated[float, Field(ge=0.1, le=60.0, description="s between two readings")] = 5.0

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        for one in self.temperatures:
            if self.temperatures.count(one) > 1:
                raise ValueError(f"temperatures: {one:g} °C is there twice; each once")
        moved = self.poll_interval * self.ramp_rate / 60.0
        if moved > LARGEST_MOVE:
            raise ValueError(
                f"poll_interval {self.poll_interval:g} s: at {self.ramp_rate:g} K/min the temperature moves by "
                f"{moved:.3g} K between two readings; at most {60.0 * LARGEST_MOVE / self.ramp_rate:.3g} s"
            )
        return self

    def protocol(self, limits: Limits, hits: HammerHits) -> AcquisitionProtocol:
        """Return what the rig's readings and ramps are held against; nothing of its sweep is ever played.

        Its programme has one temperature: rules for sweeps on a ramp do not bind temperatures that are held.
        """
        programme = Programme(
            lowest=self.temperatures[0],
            highest=self.temperatures[0],
            every=100.0,
            ramp_rate=self.ramp_rate,
            lead=0.0,
            soak_before=self.soak,
            settling=Settling(within=self.within, lasting=self.soak, timeout=self.timeout),
            watch=self.watch,
            tolerance=2.0 * LARGEST_MOVE,
            poll_interval=self.poll_interval,
        )
        sweep = SweepSettings(
            kind="logarithmic",
            band=hits.band,
            duration=hits.duration,
            taper=0.1 * hits.duration,
            tail=0.1,
            repeats=1,
            levels=(1.0,),
        )
        return AcquisitionProtocol(sweep, programme, limits)


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
    def _has_no_amplifier(self) -> Self:
        for name in ("heat", "gain"):
            if getattr(self, name) is not None:
                raise ValueError(f"{name} belongs to a simulated campaign of sweeps, on ramps; remove it")
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
    oven: OvenSection | None = None
    thermometer: ThermometerSettings | None = None
    set_points: HammerSetPoints | None = None
    limits: Limits | None = None
    simulation: HammerSimulation | None = None
    tolerances: Tolerances = Tolerances()

    @property
    def temperatures(self) -> tuple[float | None, ...]:
        """Set-points, degrees Celsius; a single None where no oven is driven."""
        return (None,) if self.set_points is None else self.set_points.temperatures

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
        measured = {
            "temperature": self.temperature is not None,
            "cards.thermocouples": self.cards.has_thermocouples,
            "[thermometer]": self.thermometer is not None,
        }
        given = [name for name, there in measured.items() if there]
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} are given; keep one of them")
        if not given and (self.set_points is None or self.set_points.watch == "plate"):
            raise ValueError(
                "temperature, cards.thermocouples and [thermometer]: none given; declare the plate's temperature, "
                "or what measures it"
            )
        self._with_its_oven()
        if self.rig == "simulated" and self.simulation is None:
            raise ValueError("rig is simulated, but there is no [simulation], which declares what is simulated")
        return self

    def _with_its_oven(self) -> None:
        """Raise ValueError where oven, limits and set-points do not belong together."""
        parts = {"oven": self.oven, "set_points": self.set_points, "limits": self.limits}
        missing = [name for name, part in parts.items() if part is None]
        if 0 < len(missing) < 3:
            raise ValueError(
                f"[{missing[0]}] is missing; at temperatures of an oven's programme, [oven], [set_points] and "
                "[limits] are needed, at one temperature none of them"
            )
        if self.oven is None or self.set_points is None or self.limits is None:
            if self.thermometer is not None:
                raise ValueError("[thermometer] without [oven]; declare temperature, or cards.thermocouples")
            return
        if self.temperature is not None:
            raise ValueError("temperature and [set_points] are given; keep one of them")
        for one in self.set_points.temperatures:
            if not self.oven.minimum <= one <= self.oven.maximum:
                raise ValueError(
                    f"set_points.temperatures: {one:g} °C; {self.oven.minimum:g} to {self.oven.maximum:g} °C "
                    "allowed, oven.minimum to oven.maximum"
                )
        if self.set_points.ramp_rate > self.oven.max_rate:
            raise ValueError(
                f"set_points.ramp_rate {self.set_points.ramp_rate:g} K/min; at most {self.oven.max_rate:g} K/min "
                "allowed, oven.max_rate"
            )


def hammer_model(table: Mapping[str, Any]) -> type[HammerExperiment]:
    """Return the model of a hammer test with oven and thermometer of these kinds, which know their own keys.

    Raises
    ------
    UnknownInstrument
        For a kind that is not there.
    """
    sections = instrument_sections({name: table[name] for name in ("oven", "thermometer") if name in table})
    fields: dict[str, Any] = {name: (sections[name][0] | None, None) for name in sections if name != "cards"}
    return create_model("HammerExperiment", __base__=HammerExperiment, **fields)


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
    table = read_table(path)
    try:
        model = hammer_model(table)
    except UnknownInstrument as error:
        raise error.said_of(path) from error
    experiment = checked(path, table, model)
    if experiment.limits is not None and experiment.oven is not None:
        beyond = [*far_limits(path.name, experiment.limits, experiment.oven)]
        if beyond:
            raise CampaignFileError(path.parent, beyond)
    if experiment.simulation is not None and experiment.simulation.effects:
        from app.files.declarations.hidden_effects import (
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
