"""What hangs on the simulated cards: a plate behind the output, its temperature, the wires back."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.ni.modules import NI_9211, NI_9234, NI_9260, InputModule, OutputModule, ThermocoupleModule

Module = InputModule | OutputModule | ThermocoupleModule

Temperature = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Moments (M,) on the rig's clock, s -> temperature (M,), degrees Celsius.

A record is computed when its first sample is read, so the moments may lie ahead of the clock.
"""


class DrivenPlate(Protocol):
    """A plate with its amplifier and sensors, at rest before the first sample."""

    def __call__(
        self, drive: NDArray[np.float64], sample_rate: float, temperature: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the sensors' voltages.

        Parameters
        ----------
        drive : (M,) ndarray, V
            On the output terminal.
        sample_rate : float, Hz
        temperature : (M,) ndarray, degrees Celsius
            Of the plate, at each sample.

        Returns
        -------
        (K, M) ndarray, V
        """
        ...


class StruckPlate(Protocol):
    """A plate that an impact hammer hits, with the sensors of both.

    Attributes
    ----------
    version : int
        Changes where what was asked for before is no longer true: another hit is on its way.
    """

    version: int

    def __call__(
        self, moments: NDArray[np.float64], sample_rate: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the force sensor's voltage (M,) and those of the plate's sensors (K, M), V.

        Parameters
        ----------
        moments : (M,) ndarray, s
            1 / `sample_rate` apart.
        sample_rate : float, Hz
        """
        ...


def room(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return 20 degrees Celsius, as in a room all day."""
    return np.full(np.shape(moments), 20.0)


@dataclass(frozen=True)
class Surroundings:
    """A chassis, what is plugged into it and what is wired to that.

    Attributes
    ----------
    plate : DrivenPlate
    sensors : mapping of str to int
        Input terminal -> row of the plate's answer it is wired to.
    drive_inputs : frozenset of str
        Input terminals wired to the output. An input wired to nothing reads 0 V and its own noise.
    drive_scale : float
        Volts there per volt of the output: 1 of a wire, gain times sensitivity of an exciter with a force sensor.
    output : str
        Output terminal the plate hangs on.
    plate_temperature : Temperature
    thermocouples : mapping of str to Temperature
        Thermocouple terminal -> what it touches. One that touches nothing reads the plate.
    chassis : str
    modules : mapping of int to Module
        Slot, from 1, -> module.
    iepe_sensors : frozenset of str
        Input terminals whose sensors say nothing unless they are fed.
    clock_errors : (float, float)
        How much too fast the clocks of the input and of the output modules are, as a share: each runs on a
        crystal of its own unless a task takes the other's timebase.
    routes_timebases : bool
        Whether the chassis can route a timebase from one module to another.
    memory : float
        How long the plate remembers, s. A continuous record is computed in pieces, each preceded by
        this much of the drive; a finite one is computed whole.
    hammer : StruckPlate, optional
        The plate that is hit, in the place of `plate`: the drive inputs then read the hammer's force sensor.
    """

    plate: DrivenPlate
    sensors: Mapping[str, int]
    drive_inputs: frozenset[str] = frozenset({"cDAQ1Mod1/ai0"})
    drive_scale: float = 1.0
    output: str = "cDAQ1Mod2/ao0"
    plate_temperature: Temperature = room
    thermocouples: Mapping[str, Temperature] = field(default_factory=dict)
    chassis: str = "cDAQ1"
    modules: Mapping[int, Module] = field(default_factory=lambda: {1: NI_9234, 2: NI_9260, 3: NI_9211})
    iepe_sensors: frozenset[str] = frozenset()
    clock_errors: tuple[float, float] = (0.0, 0.0)
    routes_timebases: bool = True
    memory: float = 2.0
    hammer: StruckPlate | None = None

    def __post_init__(self) -> None:
        if not all(1 <= slot <= 8 for slot in self.modules):
            raise ValueError(f"modules in slots {sorted(self.modules)}; a cDAQ-9178 has slots 1 to 8")
        if not 0.0 <= self.memory <= 60.0:
            raise ValueError(f"memory of {self.memory:g} s; 0 to 60 allowed")
        terminals = self.terminals()
        for terminal in (self.output, *self.drive_inputs, *self.sensors, *self.thermocouples):
            if terminal not in terminals:
                raise ValueError(f"terminal {terminal!r} is wired but not there; there are {sorted(terminals)}")

    def devices(self) -> dict[str, Module]:
        """Device name, as NI MAX makes them up, -> module."""
        return {f"{self.chassis}Mod{slot}": module for slot, module in sorted(self.modules.items())}

    def terminals(self) -> dict[str, Module]:
        """Physical channel -> module it is on."""
        return {
            f"{device}/{'ao' if isinstance(module, OutputModule) else 'ai'}{number}": module
            for device, module in self.devices().items()
            for number in range(module.channels)
        }
