"""What a program has asked of one task, and how far the task has got."""

from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from nidaqmx.error_codes import DAQmxErrors
from numpy.typing import NDArray

from drivers.ni.simulated.faults import DaqmxStatusError
from drivers.ni.simulated.surroundings import Module


class Kind(Enum):
    """What a channel measures or makes."""

    VOLTAGE_IN = "voltage input"
    ACCELERATION_IN = "acceleration input"
    THERMOCOUPLE_IN = "thermocouple input"
    VOLTAGE_OUT = "voltage output"


class TaskState(Enum):
    """Where a task stands."""

    CONFIGURED = "configured"
    RESERVED = "reserved"
    STARTED = "started"


@dataclass
class TaskChannel:
    """A virtual channel: a physical one and its settings."""

    name: str
    terminal: str
    module: Module
    kind: Kind
    reach: float
    """Largest magnitude, in the channel's unit."""

    ac_coupled: bool = False
    volts_per_unit: float = 1.0
    feeds: bool = False
    """Whether it feeds its sensor with a constant current."""


@dataclass
class SampleTiming:
    """The sample clock, once configured."""

    rate: float
    """As the driver states it, Hz."""

    samples: int
    finite: bool
    asked: float
    """Rate asked for, Hz."""

    error: float = 0.0
    """How much too fast its crystal is, as a share."""

    @property
    def pace(self) -> float:
        """Samples in a true second."""
        return self.rate * (1.0 + self.error)


@dataclass(eq=False)
class Task:
    """A task of the driver's."""

    name: str
    channels: list[TaskChannel] = field(default_factory=list)
    timing: SampleTiming | None = None
    trigger: str = ""
    pretrigger: int | None = None
    """Samples kept from before a reference trigger; None where there is no such trigger."""

    timebase: str = ""
    """Terminal of another task's timebase, if it is to run on that."""

    engine: str = ""
    state: TaskState = TaskState.CONFIGURED
    reserved_on_purpose: bool = False
    began: float | None = None
    """When the first sample was taken or played, s; None while it waits for its trigger."""

    position: int = 0
    """Samples read so far."""

    written: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    buffer: int = 0
    """Samples the input buffer holds, 0 for the driver's choice."""

    regenerates: bool = True
    pieces: dict[int, tuple[int, NDArray[np.float64]]] = field(default_factory=dict)
    """Recorded so far: number of the piece -> version of the output it was computed from, samples."""

    watched: bool = False
    """Whether a client waits for its events."""

    announced: int = 0
    """Samples that were read, or announced to a callback that will read them."""

    broken: DaqmxStatusError | None = None
    """What every later call gets, once the hardware has failed under a running task."""

    @property
    def is_input(self) -> bool:
        """Whether it measures."""
        return bool(self.channels) and self.channels[0].kind is not Kind.VOLTAGE_OUT

    def devices(self) -> list[str]:
        """Names of the modules its channels are on, each once."""
        return list(dict.fromkeys(channel.terminal.split("/")[0] for channel in self.channels))

    def clocked(self) -> SampleTiming:
        """Return the sample clock; the driver refuses queries of one that was never configured."""
        if self.timing is None:
            raise DaqmxStatusError(
                DAQmxErrors.ATTRIBUTE_NOT_SUPPORTED_IN_TASK_CONTEXT,
                f"Property is not supported for on-demand timing. Task Name: {self.name}",
            )
        return self.timing

    def buffer_size(self) -> int:
        """Return how many samples the buffer holds: asked for, or what the driver picks for the rate."""
        timing = self.clocked()
        if self.buffer:
            return self.buffer
        if timing.finite:
            return timing.samples
        sizes = ((100.0, 1_000), (10_000.0, 10_000), (1e6, 100_000))
        by_rate = next((size for fastest, size in sizes if timing.rate <= fastest), 1_000_000)
        return max(by_rate, timing.samples)

    def ends(self) -> float:
        """When a finite task is done, s; infinity for a continuous one or one still waiting."""
        if self.began is None or self.timing is None or not self.timing.finite:
            return float("inf")
        return self.began + self.timing.samples / self.timing.pace

    def taken(self, moment: float) -> int:
        """Return how many samples have been acquired or generated at a moment."""
        if self.began is None or self.timing is None:
            return 0
        count = int(np.floor((moment - self.began) * self.timing.pace + 1e-4))
        return max(0, min(count, self.timing.samples) if self.timing.finite else count)
