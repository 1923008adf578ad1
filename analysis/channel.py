"""What a plate is driven by and read by, one quantity at a time: name, unit, and the place where it acts."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from analysis.checked_fields import check_finite, check_range, check_shapes
from analysis.declaration.strict import Point

Quantity = Literal["voltage", "charge", "force", "displacement", "velocity", "acceleration", "pressure", "strain"]
Motion = Literal["displacement", "velocity", "acceleration"]

UNITS: dict[Quantity, str] = {
    "voltage": "V",
    "charge": "C",
    "force": "N",
    "displacement": "m",
    "velocity": "m/s",
    "acceleration": "m/s2",
    "pressure": "Pa",
    "strain": "m/m",
}
ORDER: dict[Quantity, int] = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""How often a deflection is differentiated by time."""


@dataclass(frozen=True)
class Footprint:
    """The disc on which a transducer acts or feels: its motion is the mean deflection over the disc.

    Attributes
    ----------
    point : (float, float)
        Middle, m.
    radius : float
        m; 0 for a point.
    along : float
        1 where the quantity is positive along z, out of the top face; -1 where it is the other way round.
    mass : float
        That moves with the plate, kg.
    """

    point: Point
    radius: float = 0.0
    along: float = 1.0
    mass: float = 0.0

    def __post_init__(self) -> None:
        check_shapes(self, point="2")
        check_finite(self, "point")
        check_range(self, 0.0, np.inf, "radius", unit="m")
        check_range(self, 0.0, np.inf, "mass", unit="kg")
        check_range(self, -1.0, 1.0, "along")


@dataclass(frozen=True)
class Channel:
    """One input or output.

    Attributes
    ----------
    id : str
        As declared; where one sensor has many points, with the number of the point after it.
    quantity : str
    patch : int or None
        Index of the patch that it drives or reads.
    footprint : Footprint or None
        Where it acts on the plate itself.
    """

    id: str
    quantity: Quantity
    patch: int | None = None
    footprint: Footprint | None = None

    def __post_init__(self) -> None:
        if (self.patch is None) == (self.footprint is None):
            raise ValueError(f"channel {self.id!r} needs a patch or a footprint, and not both")

    @property
    def unit(self) -> str:
        """SI unit of its signal."""
        return UNITS[self.quantity]

    @property
    def gain_unit(self) -> str:
        """Unit of the gain between what is recorded of an input and the input itself: ``V/V`` of an amplifier."""
        return f"{self.unit}/{self.unit}"


def transfer_unit(output: Channel, source: Channel) -> str:
    """Return the unit of what an output answers to an input: ``V/V``, ``m/s2/N``."""
    return f"{output.unit}/{source.unit}"


def transfer_label(output: Channel, source: Channel) -> str:
    """Name a transfer and its unit wherever one is shown: ``S1/A1 [V/V]``, ``acc1/hammer [m/s2/N]``."""
    return f"{output.id}/{source.id} [{transfer_unit(output, source)}]"
