"""The experiment as declared: plate, patches, electronics and protocol, each checked when read.

Every model refuses values that cannot be, with the key, the value seen and the range allowed; the ranges are wide
enough for any plate of a laboratory and tight enough to catch a wrong unit (mm for m, g for kg, K
for degrees Celsius, kHz for Hz).

What is fixed to the plate is held against it: every patch and point in a place where it can be.
"""

from collections.abc import Sequence
from datetime import date as Date  # noqa: N812 (the field is called date)
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.channel import Channel, Footprint, transfer_label
from analysis.declaration.plate import Plate
from analysis.declaration.strict import Declared, Point, Sparse, Temperature
from analysis.declaration.tolerances import Tolerances
from analysis.declaration.transducers import MOST_POINTS, Drive, Patch, Sensor
from analysis.geometry.loop import GeometryError, at
from analysis.geometry.relations import leaves, overlap
from analysis.protocol.sweep import DriveKind, SweepTiming, sweep_timing

LEAST_LINES = 20
"""Frequency lines of a record within the band: of fewer nothing is judged, and no resonance is seen."""


def check_patches(plate: Plate, patches: Sequence[Patch]) -> None:
    """Raise ValueError unless every patch has its own name and place, on the plate and over no edge of it."""
    names = [p.id for p in patches]
    for name in names:
        if name == "drive":
            raise ValueError("patch 'drive' has the name of the drive's channel; choose another id")
        if names.count(name) > 1:
            raise ValueError(f"patch id {name!r} is used {names.count(name)} times")
    for patch in patches:
        _check_place(plate, patch)
    for i, first in enumerate(patches):
        for second in patches[i + 1 :]:
            place = overlap(first.loop, second.loop) if first.side == second.side else None
            if place is not None:
                raise GeometryError(
                    f"patches {first.id!r} and {second.id!r} overlap on the {first.side} face at {at(place)}; "
                    "part them",
                    place,
                )


def _check_place(plate: Plate, patch: Patch) -> None:
    place = leaves(patch.loop, plate.loop)
    for axis, (low, high) in enumerate(zip(*plate.bounds, strict=True)):
        first, last = patch.span(axis)
        if first < low - 1e-9 or last > high + 1e-9:
            raise GeometryError(
                f"patch {patch.id!r} spans {first:g} to {last:g} m along {'xy'[axis]}; "
                f"the plate allows {low:g} to {high:g}",
                patch.center if place is None else place,
            )
    if place is not None:
        raise GeometryError(f"patch {patch.id!r} reaches over the plate's edge at {at(place)}; move it", place)
    for number, hole in enumerate(plate.hole_loops):
        place = overlap(patch.loop, hole)
        if place is not None:
            raise GeometryError(
                f"patch {patch.id!r} reaches into hole {number + 1} at {at(place)}; move it", place
            )
    for number, zone in enumerate(plate.zone_loops):
        place = overlap(patch.loop, zone)
        beyond = None if place is None else leaves(patch.loop, zone)
        if beyond is not None:
            raise GeometryError(
                f"patch {patch.id!r} lies partly on zone {number + 1} and partly beside it, at {at(beyond)}; "
                "it has to lie on one thickness",
                beyond,
            )


def check_point(plate: Plate, name: str, point: Point) -> None:
    """Check that a point lies on the plate.

    Parameters
    ----------
    name : str
        What is fixed there, for the message.
    point : (float, float)
        m.

    Raises
    ------
    GeometryError
        For a point in a hole or off the plate.
    """
    if plate.contains(np.array([point]))[0]:
        return
    for number, hole in enumerate(plate.hole_loops):
        if hole.contains(np.array([point]))[0]:
            raise GeometryError(f"{name} {list(point)} m is in hole {number + 1}; move it onto the plate", point)
    raise GeometryError(f"{name} {list(point)} m is off the plate", point)


__all__ = [
    "Acquisition",
    "Attachment",
    "Declared",
    "Drive",
    "Experiment",
    "OvenDeclaration",
    "Patch",
    "Plate",
    "Point",
    "Protocol",
    "Temperature",
    "check_patches",
]


class Attachment(Sparse):
    """A place where a string or a cable holds the plate: a disc of `radius`, smaller where the edge is near.

    Half the plate's thickness unless given: over less, a plate theory is not valid; over more, a disc averages
    the bending waves.
    """

    point: Point
    radius: Annotated[float | None, Field(ge=0.0, le=0.05, description="m")] = None


class Acquisition(Declared):
    """The input module and what it puts across each sensor patch."""

    module: str
    sample_rate: Annotated[float, Field(ge=100.0, le=2e6, description="Hz, as read back")]
    input_resistance: Annotated[float, Field(ge=1e3, le=1e12, description="ohm")]
    input_capacitance: Annotated[float, Field(ge=0.0, le=1e-6, description="F, module plus cable")]


class Protocol(Declared):
    """Which sweeps were made, at which temperatures."""

    sweep: DriveKind
    band: Annotated[tuple[float, float], Field(description="Hz")]
    sweep_duration: Annotated[float, Field(gt=0.0, le=3600.0, description="s")]
    tail: Annotated[float, Field(ge=0.0, le=600.0, description="s of silence")]
    taper: Annotated[float | None, Field(gt=0.0, le=60.0, description="s of each fade, outside the band")] = None
    repeats: Annotated[int, Field(ge=1, le=1000)]
    ramp_rate: Annotated[float, Field(ge=0.0, le=60.0, description="K/min, magnitude")]
    temperatures: Annotated[tuple[Temperature, ...], Field(min_length=1)]
    directions: Annotated[tuple[Literal["up", "down"], ...], Field(min_length=1, max_length=2)]
    levels: Annotated[tuple[Annotated[float, Field(gt=0.0, le=1000.0)], ...], Field(min_length=1)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        low, high = self.band
        if not 0.0 < low < high:
            raise ValueError(f"band {list(self.band)} Hz: the lower edge must be above 0 and below the upper edge")
        if (high - low) * self.record < LEAST_LINES:
            raise ValueError(
                f"band {list(self.band)} Hz holds {(high - low) * self.record:.0f} frequency lines in a record of "
                f"{self.record:g} s; at least {LEAST_LINES} needed (bands are in Hz: 1 kHz is 1000)"
            )
        for before, after in zip(self.temperatures, self.temperatures[1:], strict=False):
            if after <= before:
                raise ValueError(f"temperatures must ascend: {after:g} follows {before:g}")
        if self.taper is not None and self.taper > 0.25 * self.sweep_duration:
            raise ValueError(
                f"taper {self.taper:g} s is more than a quarter of sweep_duration ({self.sweep_duration:g} s); "
                f"at most {0.25 * self.sweep_duration:g} s allowed"
            )
        if len(set(self.directions)) != len(self.directions):
            raise ValueError(f"directions {list(self.directions)} name a leg twice")
        return self

    @property
    def record(self) -> float:
        """Length of one repeat, s."""
        return self.sweep_duration + self.tail

    @property
    def spread(self) -> float:
        """Standard deviation of the temperature over the repeats of a sweep, one directly after another, K."""
        return self.ramp_rate / 60.0 * self.record * float(((self.repeats**2 - 1) / 12.0) ** 0.5)

    @property
    def timing(self) -> SweepTiming | None:
        """When sweeps pass their frequencies; None where the taper is not declared, or all are played at once."""
        if self.taper is None:
            return None
        return sweep_timing(self.sweep, self.band, self.taper, self.sweep_duration, self.record)


class OvenDeclaration(Sparse):
    """The oven and the room it stands in.

    Attributes
    ----------
    room_temperature : float
        Degrees Celsius.
    reading : str
        What the sweeps' temperatures are those of: the ``air`` of the oven, or a sensor on the ``plate``. Of a
        campaign whose sweeps carry readings of such a sensor it is the plate, whatever is declared.
    """

    room_temperature: Temperature
    reading: Literal["air", "plate"] = "air"


class Experiment(Sparse):
    """All that is declared of a campaign: the ``campaign.toml`` of ``recorded-campaign/1``."""

    always: ClassVar[frozenset[str]] = frozenset({"format", "patch", "string", "cable"})

    format: Literal["recorded-campaign/1"] = "recorded-campaign/1"
    title: str
    operator: str = ""
    date: Date | None = None
    plate: Plate
    patch: tuple[Patch, ...] = ()
    drive: Annotated[tuple[Drive, ...], Field(max_length=MOST_POINTS)] = ()
    sensor: Annotated[tuple[Sensor, ...], Field(max_length=100)] = ()
    string: tuple[Attachment, ...] = ()
    cable: tuple[Attachment, ...] = ()
    acquisition: Acquisition
    protocol: Protocol
    oven: OvenDeclaration
    tolerances: Tolerances = Tolerances()

    @property
    def actuator(self) -> Patch | Drive:
        """The patch or force that drives the plate, or the first of them."""
        return next((p for p in self.patch if p.role == "actuator"), None) or self.drive[0]

    @property
    def sensors(self) -> tuple[Patch, ...]:
        """The patches that are read, in the order declared; `outputs` are all that is read."""
        return tuple(p for p in self.patch if p.role == "sensor")

    @property
    def attachments(self) -> tuple[Attachment, ...]:
        """Points at which an effect's springs, dashpots and masses can act: the reduced plate keeps these."""
        return (*self.string, *self.cable)

    @property
    def inputs(self) -> tuple[Channel, ...]:
        """What drives the plate, one of them in every sweep: patches, then forces, in the order declared."""
        patches = (Channel(p.id, "voltage", patch=k) for k, p in enumerate(self.patch) if p.role == "actuator")
        return (*patches, *(drive.channel for drive in self.drive))

    @property
    def outputs(self) -> tuple[Channel, ...]:
        """What is read: patches, then motions, in the order declared; all at once in every sweep."""
        patches = (Channel(p.id, p.quantity, patch=k) for k, p in enumerate(self.patch) if p.role == "sensor")
        return (*patches, *(channel for sensor in self.sensor for channel in sensor.channels(self.plate)))

    @property
    def driven(self) -> range:
        """Which of the footprints forces act on."""
        return range(sum(source.footprint is not None for source in self.inputs))

    @property
    def footprints(self) -> tuple[Footprint, ...]:
        """Where forces act and motions are read: of the inputs, then of the outputs."""
        return tuple(c.footprint for c in (*self.inputs, *self.outputs) if c.footprint is not None)

    @property
    def unseen_lag(self) -> bool:
        """Whether the plate may lag behind its temperatures, and nothing recorded tells: one ramp, by the air."""
        protocol = self.protocol
        return self.oven.reading == "air" and protocol.ramp_rate > 0.0 and len(protocol.directions) == 1

    @property
    def level_units(self) -> tuple[str, ...]:
        """Unit of the levels of each input."""
        return tuple(source.unit for source in self.inputs)

    def labels(self, source: Channel | None = None) -> tuple[str, ...]:
        """Name the transfers from an input, the first unless given, to all outputs, with their units."""
        return tuple(transfer_label(output, source or self.inputs[0]) for output in self.outputs)

    @model_validator(mode="after")
    def _driven_and_read(self) -> Self:
        if not self.inputs:
            raise ValueError("patch, drive: nothing drives; give a patch the role actuator, or add a [[drive]]")
        if not self.outputs:
            raise ValueError("patch, sensor: nothing is read; give a patch the role sensor, or add a [[sensor]]")
        return self

    @model_validator(mode="after")
    def _on_the_plate(self) -> Self:
        check_patches(self.plate, self.patch)
        for drive in self.drive:
            drive.check(self.plate)
        for sensor in self.sensor:
            sensor.check(self.plate)
        names = [p.id for p in self.patch if p.role in ("shorted", "open")]
        names += [channel.id for channel in (*self.inputs, *self.outputs)]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(
                    f"id {name!r} is used {names.count(name)} times among patches, drives and sensors"
                )
        for kind in ("string", "cable"):
            for number, attachment in enumerate(getattr(self, kind)):
                check_point(self.plate, f"{kind}[{number}].point", attachment.point)
        if self.protocol.band[1] >= self.acquisition.sample_rate / 2.0:
            raise ValueError(
                f"protocol.band ends at {self.protocol.band[1]:g} Hz, not below half of "
                f"acquisition.sample_rate ({self.acquisition.sample_rate:g} Hz)"
            )
        return self
