"""What simulated controllers that an experiment's file declares hold: set-point, rate and switch."""

import math
from typing import TYPE_CHECKING

from drivers.ovens.simulated.regulated_oven import RegulatedOven

if TYPE_CHECKING:
    from drivers.ovens.modbus_map import ModbusMapOven
    from drivers.ovens.scpi import ScpiOven


class DeclaredOven:
    """Set-point, rate and switch of a controller without a program, and the oven that follows them.

    Parameters
    ----------
    declared : ModbusMapOven or ScpiOven
    oven : RegulatedOven

    Attributes
    ----------
    target, rate : float
        Degrees Celsius, K/min; the rate counts where one is declared, and 0 is none.
    on : bool
        Whether it regulates; a controller without a switch does from the beginning.
    """

    def __init__(self, declared: "ModbusMapOven | ScpiOven", oven: RegulatedOven) -> None:
        self._has_rate = declared.rate is not None
        self._oven = oven
        self.target = oven.working
        self.rate = 0.0
        self.on = declared.run is None
        if self.on:
            self.drive()

    @property
    def running(self) -> bool:
        """Whether it says that it regulates."""
        return self.on and self._oven.regulating

    def drive(self) -> None:
        """Have the oven follow."""
        if self.on:
            self._oven.go(self.target, self.rate or math.inf if self._has_rate else math.inf)
        else:
            self._oven.stop()
