"""Heat in an oven with a plate in it: two lumps, solved exactly between changes of power.

    C_a dT_a/dt = P - G_w (T_a - T_room) - G_p (T_a - T_p)
    C_p dT_p/dt = G_p (T_a - T_p)

with a the air and what moves with it (shelves, inner walls), p the plate, P the power brought in
(negative: taken out). A plate a few millimetres thick is a lump: its Biot number h d / k in moving air
is of the order 1e-3 for aluminium.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Chamber:
    """What the heat meets, in SI units but for the room's degrees Celsius.

    Attributes
    ----------
    air_capacity : float
        Heat capacity of air, shelves and inner walls, J/K.
    plate_capacity : float
        Heat capacity of the plate, J/K.
    wall_conductance : float
        From the air through the walls to the room, W/K.
    plate_conductance : float
        From the air to the plate, W/K.
    heating, cooling : float
        Largest power brought in and taken out, W.
    room : float
        degrees Celsius.
    """

    air_capacity: float = 2.0e4
    plate_capacity: float = 900.0
    wall_conductance: float = 15.0
    plate_conductance: float = 6.0
    heating: float = 3000.0
    cooling: float = 2000.0
    room: float = 22.0

    def __post_init__(self) -> None:
        for name in ("air_capacity", "plate_capacity", "wall_conductance", "plate_conductance"):
            value = getattr(self, name)
            if not 0.0 < value < math.inf:
                raise ValueError(f"{name} {value!r} must be above 0 and finite")
        if not (0.0 <= self.heating < math.inf and 0.0 <= self.cooling < math.inf):
            raise ValueError(
                f"heating {self.heating!r} W and cooling {self.cooling!r} W must be 0 or more and finite"
            )
        if not -80.0 <= self.room <= 200.0:
            raise ValueError(f"room {self.room!r} °C; allowed -80 to 200")

    def rates(self) -> NDArray[np.float64]:
        """Return the (2, 2) matrix of d(T - T_room)/dt, air first, 1/s."""
        a, p = self.air_capacity, self.plate_capacity
        return np.array(
            [
                [-(self.wall_conductance + self.plate_conductance) / a, self.plate_conductance / a],
                [self.plate_conductance / p, -self.plate_conductance / p],
            ]
        )


class Heat:
    """Temperatures of air and plate, moved on in steps of one length under constant power.

    Parameters
    ----------
    chamber : Chamber
    step : float
        Seconds.
    air, plate : float, optional
        Start, degrees Celsius; the room's by default.

    Attributes
    ----------
    air, plate : float
        degrees Celsius, now.
    """

    def __init__(
        self, chamber: Chamber, step: float, air: float | None = None, plate: float | None = None
    ) -> None:
        from scipy.linalg import expm

        if not 0.0 < step < math.inf:
            raise ValueError(f"step {step!r} s must be above 0 and finite")
        self.chamber = chamber
        self.step = step
        self.air = chamber.room if air is None else air
        self.plate = chamber.room if plate is None else plate
        rates = chamber.rates()
        # Columns: air, plate and power. Exact for constant power, so the step only says how often the
        # power may change. Kept as floats: two multiply-adds cost less than a call into numpy.
        whole = np.zeros((3, 3))
        whole[:2, :2] = rates
        whole[0, 2] = 1.0 / chamber.air_capacity
        moved = expm(whole * step)
        (self._aa, self._ap, self._ah), (self._pa, self._pp, self._ph) = moved[:2].tolist()

    def advance(self, power: float) -> None:
        """Move on by one step under `power` (W; negative takes heat out), kept within the chamber's means."""
        power = min(max(power, -self.chamber.cooling), self.chamber.heating)
        room = self.chamber.room
        air, plate = self.air - room, self.plate - room
        self.air = room + self._aa * air + self._ap * plate + self._ah * power
        self.plate = room + self._pa * air + self._pp * plate + self._ph * power

    @property
    def stored(self) -> float:
        """Heat held above that at the room's temperature, J."""
        c = self.chamber
        return c.air_capacity * (self.air - c.room) + c.plate_capacity * (self.plate - c.room)
