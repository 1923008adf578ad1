"""Declaration of a focusing panel: plate, actuators, target, grid, filters, and who listens to it."""

import math
from itertools import combinations, pairwise
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from analysis.arrays import Real
from analysis.channel import Footprint
from analysis.declaration.outline import check_disc
from analysis.declaration.plate_material import material_box
from analysis.declaration.strict import Coordinate, Degrees, Point, Sparse
from analysis.experiment import Declared, Drive, Patch, Plate, Temperature, check_patches
from analysis.geometry.loop import GeometryError, Loop, at, ellipse, polygon, rectangle
from analysis.geometry.relations import leaves, overlap, self_crossing
from analysis.material import MaterialBox
from analysis.radiation.radiator import LEAST_LISTENER_HEIGHT, Air, Mounting, require_fine

Height = Annotated[float, Field(ge=LEAST_LISTENER_HEIGHT, le=100.0, description="m in front of the panel")]
Decibels = Annotated[float, Field(ge=-100.0, le=100.0, description="dB")]
Weight = Annotated[float, Field(ge=0.0, le=1e4)]
Frequency = Annotated[float, Field(ge=1.0, le=20_000.0, description="Hz")]


class SoundListener(Sparse):
    """Someone who hears the panel: an ear, or a microphone.

    Attributes
    ----------
    name : str
    position : (float, float, float)
        m, in the coordinates of the plate; the third is the height in front of the panel.
    zone : str
        Listeners of one zone hear the same programme.
    """

    name: Annotated[str, Field(min_length=1, max_length=40)]
    position: tuple[Coordinate, Coordinate, Height]
    zone: Annotated[str, Field(max_length=40)] = ""


class PanelSound(Sparse):
    """Listeners, air and mounting of a panel, the sound wanted, and the weights of what is wanted.

    Weights are of squared relative errors, beside 1 for the field's: that of pressure at listeners (or of net
    volume) over the wanted one, that of pressure in zones that are to be quiet over the wanted one elsewhere, and
    the power radiated by what moves outside the target over that of the target alone.
    """

    mounting: Annotated[Mounting, Field(description="in a rigid baffle, or the front of a closed box")] = "baffle"
    sound_speed: Annotated[float, Air.model_fields["sound_speed"]] = Air().sound_speed
    density: Annotated[float, Air.model_fields["density"]] = Air().density
    listener: Annotated[tuple[SoundListener, ...], Field(max_length=64)] = ()
    level: Annotated[
        float, Field(ge=-80.0, le=40.0, description="dB, of the sound of the target if it moved alone as asked")
    ] = -3.0
    curve: Annotated[
        tuple[tuple[Frequency, Decibels], ...],
        Field(max_length=100, description="Hz and dB on top of level; between them linear in log f"),
    ] = ()
    field_weight: Weight = 1.0
    sound_weight: Weight = 10.0
    quiet_weight: Weight = 10.0
    power_weight: Weight = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [one.name for one in self.listener]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"two listeners are named {twice[0]!r}; give each a name of its own")
        for (before, _), (after, _) in pairwise(self.curve):
            if not before < after:
                raise ValueError(f"curve: {after:g} Hz after {before:g} Hz; frequencies must ascend")
        if self.field_weight == 0.0 and self.sound_weight == 0.0:
            raise ValueError("field_weight and sound_weight are both 0: nothing is asked for; raise one of them")
        return self

    @property
    def air(self) -> Air:
        """The air in front."""
        return Air(sound_speed=self.sound_speed, density=self.density)

    def listeners(self, center: tuple[float, float]) -> tuple[SoundListener, ...]:
        """Those declared; else one at 1 m in front of the panel's `center`, m."""
        return self.listener or (SoundListener(name="axis", position=(*center, 1.0)),)

    def wanted(self, frequency: Real) -> Real:
        """Wanted level (F,) at `frequency` (F,), Hz, as a factor: `level` and `curve`."""
        if not self.curve:
            return np.full(len(frequency), 10.0 ** (self.level / 20.0))
        places, values = np.array(self.curve).T
        curve = np.interp(np.log(frequency), np.log(places), values)
        return np.asarray(10.0 ** ((self.level + curve) / 20.0))


AimedAt = Literal["field", "volume", "listeners"]
FEWEST_LINES = 8
"""In the band: with two, as of a transform for 4 kHz taken at 48 kHz, a contrast was told that no filter had."""
Hertz = Annotated[float, Field(ge=1.0, le=20_000.0)]
Modulus = Annotated[float, Field(ge=1e6, le=1e12, description="Pa")]
Ratio = Annotated[float, Field(ge=0.0, le=0.499)]
Loss = Annotated[float, Field(ge=1e-4, le=0.5)]
Count = Annotated[int, Field(ge=4, le=400)]


class Filters(Declared):
    """Settings of the focusing filters and their FIR taps."""

    taps: Annotated[int, Field(ge=16, le=16_384)] = 512
    sample_rate: Annotated[float, Field(ge=1_000.0, le=400_000.0, description="Hz")] = 44_100.0
    band: Annotated[tuple[Hertz, Hertz], Field(description="Hz, full gain between")] = (100.0, 800.0)
    edges: Annotated[tuple[Hertz, Hertz], Field(description="Hz, no gain outside")] = (20.0, 900.0)
    transform_length: Annotated[int, Field(ge=64, le=1_048_576, description="samples of the fine inverse FFT")] = (
        16_384
    )
    delay: Annotated[
        int | None, Field(ge=0, description="modelling delay, samples; left out, what suits taps and method")
    ] = None
    aim: Annotated[
        AimedAt,
        Field(description="what filters are chosen by: the field, its net volume, or pressure at listeners"),
    ] = "field"
    zone: Annotated[str, Field(max_length=40, description="of the listeners that are played to; empty, all")] = ""
    design: Annotated[
        Literal["field", "inverse-fft"], Field(description="least squares of the field, or a cut inverse FFT")
    ] = "field"
    outside_weight: Annotated[
        float | None,
        Field(ge=1.0, le=1e4, description="energy outside the target over energy inside; 3, or 1 for inverse-fft"),
    ] = None
    level: Annotated[
        float | None,
        Field(ge=-80.0, le=20.0, description="dB of displacement, at every line of the band; left out, free"),
    ] = None
    thermometer_error: Annotated[
        float, Field(ge=0.0, le=30.0, description="°C either way, for which filters are to be robust")
    ] = 0.0
    regularisation: Literal["tikhonov", "truncation"] = "tikhonov"
    tolerance: Annotated[
        float, Field(ge=1e-6, le=0.9, description="share of the largest singular value at each frequency")
    ] = 0.01
    reference_temperature: Annotated[
        float,
        Field(ge=-80.0, le=200.0, description="degrees Celsius, of the one filter kept without compensation"),
    ] = 20.0
    operating_range: Annotated[
        tuple[Temperature, Temperature], Field(description="degrees Celsius, over which the filters are wanted")
    ] = (0.0, 60.0)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        (low, high), (foot, head) = self.band, self.edges
        if not foot <= low < high <= head:
            raise ValueError(f"edges {list(self.edges)} Hz must enclose band {list(self.band)} Hz, both ascending")
        if head >= self.sample_rate / 2.0:
            raise ValueError(
                f"edges end at {head:g} Hz; allowed below half of sample_rate, {self.sample_rate / 2:g} Hz"
            )
        if self.transform_length < 2 * self.taps:
            raise ValueError(
                f"transform_length {self.transform_length} must be at least twice taps ({2 * self.taps}): "
                "a shorter one folds the filter onto itself"
            )
        spacing = self.sample_rate / self.transform_length
        if (high - low) / spacing < FEWEST_LINES:
            least = 2 ** math.ceil(math.log2(FEWEST_LINES * self.sample_rate / (high - low)))
            raise ValueError(
                f"transform_length {self.transform_length} at {self.sample_rate:g} Hz is a frequency line every "
                f"{spacing:.3g} Hz, too few in the band [{low:g}, {high:g}] Hz; allowed: {least} and more"
            )
        if self.aim != "field" and (
            self.level is not None or self.design != "field" or self.regularisation != "tikhonov"
        ):
            raise ValueError(
                f"aim {self.aim!r} has a level of its own, [sound] level, and needs design 'field' and "
                f"regularisation 'tikhonov': leave out level, design and regularisation"
            )
        if self.zone and self.aim != "listeners":
            raise ValueError(f"zone {self.zone!r} is for the aim 'listeners'; the aim is {self.aim!r}")
        coldest, hottest = self.operating_range
        if not coldest < hottest:
            raise ValueError(f"operating_range [{coldest:g}, {hottest:g}] °C must ascend")
        if self.delay is not None and self.delay >= self.taps:
            raise ValueError(
                f"delay {self.delay} samples must lie inside the {self.taps} taps; leave it out, or take 0 to "
                f"{self.taps - 1}"
            )
        return self

    @property
    def kappa(self) -> float:
        """Weight of the energy outside the target relative to that inside, in the design."""
        plain = 3.0 if self.design == "field" else 1.0
        return plain if self.outside_weight is None else self.outside_weight

    @property
    def middle(self) -> int:
        """Declared delay, else half the taps, which suits filters with equal ringing and pre-ringing, samples."""
        return self.taps // 2 if self.delay is None else self.delay

    @property
    def frequency(self) -> NDArray[np.float64]:
        """Lines (F,) of the fine inverse FFT inside the edges, Hz."""
        spacing = self.sample_rate / self.transform_length
        first, last = np.ceil(self.edges[0] / spacing), np.floor(self.edges[1] / spacing)
        lines: NDArray[np.float64] = np.arange(first, last + 1.0) * spacing
        return lines

    @property
    def twin_band(self) -> tuple[float, float]:
        """Band of the panel's twin, Hz.

        Wider than the edges, because interpolation at equal reduced frequency needs it: three training steps of 5
        °C shift the modes by a fifth.
        """
        return self.edges[0] / 1.3, self.edges[1] * 1.3

    def in_band(self, frequency: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which of `frequency` lie inside the band of full gain."""
        inside: NDArray[np.bool_] = (frequency >= self.band[0]) & (frequency <= self.band[1])
        return inside


class Illustration(Declared):
    """A plate of constant elastic constants, on which all methods are compared (paper Fig. 4)."""

    youngs_modulus: Modulus = 1.1e9
    poisson_ratio: Ratio = 0.33
    loss_factor: Loss = 0.06


class TwinSettings(Declared):
    """Accuracy of the panel's reduced twin, and its ranges of constants, if not those of its material."""

    youngs_modulus: Annotated[tuple[Modulus, Modulus] | None, Field(description="Pa")] = None
    poisson_ratio: tuple[Ratio, Ratio] | None = None
    loss_factor: tuple[Loss, Loss] | None = None
    function_tolerance: Annotated[
        float, Field(ge=1e-12, le=1e-4, description="share of an answer's energy for which a function is kept")
    ] = 3e-8
    basis_tolerance: Annotated[float, Field(ge=1e-6, le=1e-2, description="share of a transfer's rms")] = 1e-3

    @model_validator(mode="before")
    @classmethod
    def _mesh_follows_thickness(cls, declared: object) -> object:
        old = [name for name in ("mesh_degree", "mesh_strip") if isinstance(declared, dict) and name in declared]
        if old:
            raise ValueError(
                f"{' and '.join(old)}: the mesh now follows the plate's thickness and wavelengths; remove "
                "the key, and give function_tolerance (3e-8 unless given) for a finer or coarser twin"
            )
        if not isinstance(declared, dict):
            return declared
        # after this validator JSON counts as Python, and strict models do not accept lists as tuples
        return {name: tuple(value) if isinstance(value, list) else value for name, value in declared.items()}

    @model_validator(mode="after")
    def _ascending(self) -> Self:
        for name in ("youngs_modulus", "poisson_ratio", "loss_factor"):
            pair = getattr(self, name)
            if pair is not None and pair[0] >= pair[1]:
                raise ValueError(f"{name} [{pair[0]:g}, {pair[1]:g}] must ascend")
        return self


class Load(Declared):
    """A mass that rides on the panel: what a cable, its glue or a connector adds."""

    point: Point
    mass: Annotated[float, Field(gt=0.0, le=1.0, description="kg")]
    radius: Annotated[float, Field(ge=0.0, le=0.05, description="m")] = 0.002

    @property
    def footprint(self) -> Footprint:
        """Where it acts."""
        return Footprint(self.point, self.radius, mass=self.mass)


Fraction = Annotated[float, Field(gt=0.0, lt=1.0)]
Size = Annotated[float, Field(ge=1e-4, lt=1.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
Pair = tuple[float, float]
SMALLEST_AREA = 1e-8
"""Smallest area of a polygon, as a fraction of the area of the box around the plate."""


class Spot(Sparse):
    """One part to be moved: `shape` of `size` about `center`, turned by `angle`, or a `polygon`.

    In fractions of the plate's lengths: of the box around its outline.
    """

    center: tuple[Fraction, Fraction] | None = None
    size: tuple[Size, Size] | None = None
    shape: Literal["rectangle", "ellipse"] = "rectangle"
    angle: Degrees = 0.0
    polygon: tuple[tuple[Share, Share], ...] = ()

    def loop(self, corner: Pair, lengths: Pair) -> Loop:
        """Border, m, on a plate whose box has this lower left `corner` and these `lengths`, m."""
        if self.center is None or self.size is None:
            return polygon([(corner[0] + x * lengths[0], corner[1] + y * lengths[1]) for x, y in self.polygon])
        center = (corner[0] + self.center[0] * lengths[0], corner[1] + self.center[1] * lengths[1])
        size, angle = (self.size[0] * lengths[0], self.size[1] * lengths[1]), float(np.deg2rad(self.angle))
        if self.shape == "ellipse":
            return ellipse(center, (0.5 * size[0], 0.5 * size[1]), angle)
        return rectangle(center, size, angle)

    def _check(self, name: str) -> None:
        if self.polygon:
            if self.center is not None or self.size is not None:
                raise ValueError(f"{name} has a polygon and a center or size; keep one of them")
            if len(self.polygon) < 3:
                raise ValueError(
                    f"{name}: a polygon of {len(self.polygon)} points encloses nothing; give at least 3"
                )
            loop = self.loop((0.0, 0.0), (1.0, 1.0))
            place = self_crossing(loop)
            if place is not None:
                raise ValueError(f"{name}: the polygon crosses itself at {place[0]:g}, {place[1]:g} of the plate")
            if loop.area < SMALLEST_AREA:
                raise ValueError(
                    f"{name}: the polygon encloses {loop.area:.3g} of the area of the box around the plate; "
                    f"allowed from {SMALLEST_AREA:g}"
                )
            return
        if self.center is None or self.size is None:
            raise ValueError(f"{name} is empty; give center and size, or a polygon, or tables [[target.spot]]")
        if self.angle == 0.0:
            for axis, (center, size) in enumerate(zip(self.center, self.size, strict=True)):
                if center - size / 2.0 < 0.0 or center + size / 2.0 > 1.0:
                    raise ValueError(
                        f"{name} spans {center - size / 2:g} to {center + size / 2:g} of the plate along "
                        f"{'xy'[axis]}; allowed 0 to 1"
                    )


class Target(Spot):
    """Part of the plate to be moved: one, or several `spot` that move together, for example a stereo pair."""

    spot: tuple[Spot, ...] = ()
    displacement: Annotated[float, Field(ge=1e-12, le=1e-2, description="m per unit of audio signal")] = 1e-6

    @property
    def spots(self) -> tuple[Spot, ...]:
        """All parts."""
        return self.spot or (self,)

    @property
    def plain(self) -> bool:
        """Whether it is one rectangle along the plate's sides, whose share of a cell is known exactly."""
        return not self.spot and not self.polygon and self.shape == "rectangle" and self.angle == 0.0

    def loops(self, corner: Pair, lengths: Pair) -> tuple[Loop, ...]:
        """Borders of all parts, m."""
        return tuple(spot.loop(corner, lengths) for spot in self.spots)

    @model_validator(mode="after")
    def _each_somewhere(self) -> Self:
        if self.spot and (self.center is not None or self.size is not None or self.polygon):
            raise ValueError("target has tables [[target.spot]] and a shape of its own; keep one of them")
        for number, spot in enumerate(self.spots, start=1):
            spot._check(f"spot {number}" if self.spot else "target")
        pairs = combinations(enumerate(self.loops((0.0, 0.0), (1.0, 1.0)), start=1), 2)
        for (one, first), (other, second) in pairs:
            if overlap(first, second) is not None:
                raise ValueError(f"spots {one} and {other} overlap; move them apart")
        return self


class Panel(Sparse):
    """Declaration of a focusing panel, a ``panel/1`` TOML file. It is driven by patches or by forces."""

    always: ClassVar[frozenset[str]] = frozenset({"format", "patch", "grid", "filters", "twin", "illustration"})

    format: Literal["panel/1"] = "panel/1"
    title: str
    plate: Plate
    patch: tuple[Patch, ...] = ()
    drive: tuple[Drive, ...] = ()
    load: Annotated[tuple[Load, ...], Field(max_length=100)] = ()
    target: Target
    grid: tuple[Count, Count] = (40, 30)
    filters: Filters = Filters()
    twin: TwinSettings = TwinSettings()
    illustration: Illustration = Illustration()
    sound: PanelSound = PanelSound()

    @model_validator(mode="after")
    def _on_the_plate(self) -> Self:
        check_patches(self.plate, self.patch)
        for drive in self.drive:
            drive.check(self.plate)
        for number, load in enumerate(self.load):
            check_disc(f"load {number + 1}", load.point, load.radius, self.plate.loop, self.plate.hole_loops)
        if bool(self.patch) == bool(self.drive):
            raise ValueError(
                f"{len(self.patch)} patches and {len(self.drive)} drives; a panel has at least one actuator, and "
                "actuators of one kind: volts and newtons cannot be weighed against each other"
            )
        if self.filters.zone and not self.loud.any():
            zones = ", ".join(sorted({repr(one.zone) for one in self.listeners}))
            raise ValueError(f"filters.zone {self.filters.zone!r} has no listener; zones of listeners: {zones}")
        if self.filters.aim != "field" or self.sound.listener:
            cell = float(np.sqrt(self.plate.length_x * self.plate.length_y / (self.grid[0] * self.grid[1])))
            highest = self.filters.band[1]
            try:
                require_fine(cell, highest, self.sound.air, self.shortest_wave(highest))
            except ValueError as error:
                raise ValueError(f"grid {list(self.grid)}: {error}") from error
        for loop in self.target_loops:
            place = leaves(loop, self.plate.loop)
            for hole in self.plate.hole_loops:
                place = overlap(loop, hole) if place is None else place
            if place is None:
                continue
            raise GeometryError(
                f"target reaches over the plate's edge at {at(place)}; move it onto the plate", place
            )
        constants = self.illustration
        values = np.array([constants.youngs_modulus, constants.poisson_ratio, constants.loss_factor])
        inside = self.box.clip(values)
        names = ("youngs_modulus", "poisson_ratio", "loss_factor")
        moved = {name: float(one) for name, one, was in zip(names, inside, values, strict=True) if one != was}
        if moved and not moved.keys() & constants.model_fields_set:  # the defaults are a plastic's
            self.__dict__["illustration"] = constants.model_copy(update=moved)
        elif moved:
            raise ValueError(
                "illustration lies outside the ranges of twin (or else of plate.material); widen them or move it"
            )
        for patch in self.patch:
            if patch.role != "actuator":
                raise ValueError(f"patch {patch.id!r} has the role {patch.role}; a panel has actuators only")
        return self

    @property
    def box(self) -> MaterialBox:
        """Materials for which the panel's twin is made: of ``[twin]``, else of ``[plate.material]``."""
        known = material_box(self.plate.material)
        return MaterialBox(
            self.twin.youngs_modulus or known.youngs_modulus,
            self.twin.poisson_ratio or known.poisson_ratio,
            self.twin.loss_factor or known.loss_factor,
        )

    @property
    def target_center(self) -> tuple[float, float]:
        """Centre of the target, of its first spot where it has several, m."""
        return self.target_loops[0].centroid

    @property
    def target_loops(self) -> tuple[Loop, ...]:
        """Borders of the target's spots, m."""
        (x, y), plate = self.plate.bounds[0], self.plate
        return self.target.loops((float(x), float(y)), (plate.length_x, plate.length_y))

    @property
    def listeners(self) -> tuple[SoundListener, ...]:
        """Who hears the panel; where none is declared, one at 1 m in front of its middle."""
        (x0, y0), (x1, y1) = self.plate.bounds
        return self.sound.listeners((float(0.5 * (x0 + x1)), float(0.5 * (y0 + y1))))

    @property
    def loud(self) -> NDArray[np.bool_]:
        """Which of the listeners (L,) are played to."""
        zone = self.filters.zone
        return np.array([not zone or one.zone == zone for one in self.listeners])

    def shortest_wave(self, frequency: float) -> float:
        """Shortest wavelength of bending, m, at `frequency`, Hz, of any material the panel's twin is made for."""
        plate = self.plate
        rigidity = self.box.youngs_modulus[0] * plate.thickness**3 / 12.0 / (1.0 - self.box.poisson_ratio[0] ** 2)
        mass = plate.density * plate.thickness
        return float(2.0 * np.pi * (rigidity / mass) ** 0.25 / np.sqrt(2.0 * np.pi * frequency))

    @property
    def centers(self) -> tuple[Point, ...]:
        """Centres of the actuators, m."""
        return tuple(patch.center for patch in self.patch) or tuple(drive.point for drive in self.drive)

    @property
    def footprints(self) -> tuple[Footprint, ...]:
        """Where forces act, then where masses ride."""
        return tuple(drive.footprint for drive in self.drive) + tuple(load.footprint for load in self.load)

    @property
    def limits(self) -> NDArray[np.float64]:
        """Largest peak drive (N,) of each actuator, V: rated field times thickness; no limit for forces."""
        return np.array([patch.rated_voltage for patch in self.patch] or [np.inf] * len(self.drive))
