"""FaceAir of a panel over time, what its plate does with heat, and its thermometers: a ``weather/1`` file."""

from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from analysis.arrays import Real
from analysis.declaration.strict import Declared, Point, Sparse, Temperature

Second = Annotated[float, Field(ge=0.0, le=1e6, description="s")]
Transfer = Annotated[float, Field(ge=0.0, le=500.0, description="W/(m2 K); air at rest 5 to 10, a fan 10 to 50")]
Kelvin = Annotated[float, Field(ge=-100.0, le=100.0, description="K")]
Flow = Annotated[float, Field(ge=0.0, le=1500.0, description="W/m2, absorbed; the sun's is 1000 at most")]
Over = Annotated[tuple[tuple[Second, Temperature], ...], Field(min_length=1, max_length=10_000)]
MOST_WEATHER_STEPS = 20_000
"""Steps of one weather."""


class PlateHeat(Declared):
    """What the plate does with heat; polypropylene unless given."""

    conductivity: Annotated[float, Field(ge=0.01, le=500.0, description="W/(m K)")] = 0.22
    specific_heat: Annotated[float, Field(ge=100.0, le=5000.0, description="J/(kg K)")] = 1900.0


class FaceAir(Sparse):
    """Air beside a face of the plate.

    Attributes
    ----------
    air : tuple of (s, °C)
        In the middle of the box around the plate; straight in between, held before and after.
    across : tuple of (s, K, K)
        By how much the air is warmer at the largest x than at the smallest, and at the largest y.
    sun : tuple of (s, W/m2)
        Heat absorbed where the sun shines.
    lit : (point, point), optional
        Sun from nothing at the first point to all of it at the second, evenly in between; all over unless given.
    """

    convection: Transfer = 10.0
    air: Over
    across: Annotated[tuple[tuple[Second, Kelvin, Kelvin], ...], Field(max_length=10_000)] = ()
    sun: Annotated[tuple[tuple[Second, Flow], ...], Field(max_length=10_000)] = ()
    lit: tuple[Point, Point] | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        for name in ("air", "across", "sun"):
            for before, after in pairwise(row[0] for row in getattr(self, name)):
                if not before < after:
                    raise ValueError(f"{name}: {after:g} s after {before:g} s; times must ascend")
        if self.lit is not None and not self.sun:
            raise ValueError("lit says where the sun shines, and sun is missing; give it as [[s, W/m2], ...]")
        if self.lit is not None and self.lit[0] == self.lit[1]:
            raise ValueError(f"lit: both points are {list(self.lit[0])}; the second is where all of the sun is")
        return self

    def air_at(self, time: float) -> Real:
        """Return the air in the middle, °C, and its differences along x and y, K, (3,), at a time, s."""
        middle = _at(self.air, time)
        return np.concatenate([middle, _at(self.across, time) if self.across else np.zeros(2)])

    def sun_at(self, time: float) -> float:
        """Heat absorbed in the sun at a time, s, W/m2."""
        return float(_at(self.sun, time)[0]) if self.sun else 0.0

    def lit_at(self, points: Real) -> Real:
        """Share (K,) of the sun at points (K, 2), m."""
        if self.lit is None:
            return np.ones(len(points))
        dark, bright = np.array(self.lit)
        way = bright - dark
        return np.asarray(np.clip((points - dark) @ way / (way @ way), 0.0, 1.0))


class PlateThermometer(Declared):
    """A thermometer on the plate."""

    name: Annotated[str, Field(min_length=1, max_length=40)]
    point: Point
    face: Literal["front", "back", "middle"] = "back"


class Weather(Sparse):
    """FaceAir of a panel's plate from the time 0 on.

    Attributes
    ----------
    duration, step : float
        s; `step` of the computation.
    initial : float or None
        °C, all over; None for a plate that came to rest in the first surroundings.
    front, back : FaceAir
        Of the faces toward the listener and away.
    edge : FaceAir, optional
        Along all edges; no heat flows there unless given. Its `across`, `sun` and `lit` are not used.
    thermometer : tuple of PlateThermometer
    """

    format: Literal["weather/1"] = "weather/1"
    title: str = ""
    duration: Annotated[float, Field(gt=0.0, le=1e6, description="s")]
    step: Annotated[float, Field(gt=0.0, le=3600.0, description="s")] = 5.0
    initial: Temperature | None = None
    heat: PlateHeat = PlateHeat()
    front: FaceAir
    back: FaceAir
    edge: FaceAir | None = None
    thermometer: Annotated[tuple[PlateThermometer, ...], Field(min_length=1, max_length=32)]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.duration / self.step > MOST_WEATHER_STEPS:
            raise ValueError(
                f"duration {self.duration:g} s in steps of {self.step:g} s; at most "
                f"{MOST_WEATHER_STEPS} steps: raise step"
            )
        names = [one.name for one in self.thermometer]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"two thermometers are named {twice[0]!r}; give each a name of its own")
        if self.initial is None and not any(one and one.convection for one in self.faces):
            raise ValueError("convection is 0 everywhere and initial is missing; give the plate's first °C")
        if self.edge is not None and (self.edge.across or self.edge.sun):
            raise ValueError("edge takes convection and air only; leave out across and sun")
        return self

    @property
    def faces(self) -> tuple[FaceAir, FaceAir, FaceAir | None]:
        """Front, back and edge."""
        return self.front, self.back, self.edge

    @property
    def times(self) -> NDArray[np.float64]:
        """0 and the end of every step, s; steps are a little shorter than declared where they do not fit."""
        return np.linspace(0.0, self.duration, int(np.ceil(self.duration / self.step - 1e-9)) + 1)


def _at(table: tuple[tuple[float, ...], ...], time: float) -> Real:
    rows = np.array(table)
    return np.array([np.interp(time, rows[:, 0], column) for column in rows[:, 1:].T])
