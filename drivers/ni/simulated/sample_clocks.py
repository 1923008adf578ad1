"""What paces a task: the crystal of its modules, or the timebase of another task."""

import math
from collections.abc import Mapping
from dataclasses import replace

from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.output_modules import CHASSIS_CLOCK, OutputModule
from drivers.ni.simulated.status import DaqmxStatusError
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.simulated.task import SampleTiming, Task
from drivers.ni.thermocouple_modules import ThermocoupleModule

INPUT_ENGINES = ("ai", "te0", "te1")
"""The three timing engines a cDAQ-9178 has for analog input."""


PULSE_INTERVAL = 0.1
"""A generator on every PFI terminal of the simulated chassis gives a pulse so often, s."""


def engines(task: Task) -> tuple[str, ...]:
    """Return the timing engines that can run a task."""
    return INPUT_ENGINES if task.is_input else ("ao",)


class SampleClocks:
    """Those of all tasks of a chassis.

    Parameters
    ----------
    surroundings : Surroundings
        Says how far off the crystals are.
    tasks : mapping of str to Task
        The chassis' own, by handle.
    """

    def __init__(self, surroundings: Surroundings, tasks: Mapping[str, Task]) -> None:
        self._surroundings = surroundings
        self._tasks = tasks

    def terminal(self, task: Task, signal: str) -> str:
        """Return where a signal of a task's timing engine is available.

        Before a task is reserved it has no engine yet and the driver names the first one: right only
        as long as nobody else has it.
        """
        return f"/{self._surroundings.chassis}/{task.engine or engines(task)[0]}/{signal}"

    def full_name(self, terminal: str) -> str:
        """Return a terminal's name as the driver completes it: "ai/StartTrigger" means that of the own chassis."""
        return terminal if terminal.startswith("/") else f"/{self._surroundings.chassis}/{terminal}"

    def is_pfi(self, terminal: str) -> bool:
        """Whether a terminal is one of the chassis' two for signals from outside."""
        return terminal.lower() in [f"/{self._surroundings.chassis}/PFI{number}".lower() for number in (0, 1)]

    def configure(self, task: Task, asked: float, samples: int, *, finite: bool) -> None:
        """Give a task a sample clock, or another one; it runs at the rate that its timebase allows.

        Parameters
        ----------
        asked : float
            Rate asked for, Hz.
        samples : int
            Per channel: of a finite task all there are, of a continuous one its buffer.

        Raises
        ------
        DaqmxStatusError
            If a module of the task cannot run at this rate.
        """
        of_inputs, of_outputs = self._surroundings.clock_errors
        master = self._master(task)
        error = of_inputs if (master or task).is_input else of_outputs
        rate = _coerced(task, asked, self.timebase_rate(task))
        task.timing = SampleTiming(rate, samples, finite, asked, error)

    def timebase(self, task: Task) -> str:
        """Terminal of the timebase that paces a task: its own modules' unless it was given another."""
        return task.timebase or self.terminal(task, "SampleClockTimebase")

    def timebase_rate(self, task: Task) -> float:
        """Frequency of that timebase, Hz."""
        master = self._master(task)
        if master is not None:
            return self.timebase_rate(master)
        frequencies = []
        for channel in task.channels:
            module = channel.module
            if isinstance(module, OutputModule):
                frequencies.append(module.timebase)
            elif not isinstance(module, ThermocoupleModule):
                frequencies.append(module.timebases[0])
        return max(frequencies, default=CHASSIS_CLOCK)

    def take_timebase(self, task: Task, terminal: str) -> None:
        """Let the timebase of another task pace this one."""
        own = self.terminal(task, "SampleClockTimebase")
        there = {own} | {self.timebase(other) for other in self._tasks.values() if other is not task}
        if not self._surroundings.routes_timebases or terminal.lower() not in map(str.lower, there):
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_ROUTING_SOURCE_TERMINAL_NAME_ROUTING,
                f"Source terminal to be routed could not be found on the device. Source Terminal: {terminal}",
            )
        task.timebase = "" if terminal.lower() == own.lower() else terminal
        timing = task.clocked()
        self.configure(task, timing.asked, timing.samples, finite=timing.finite)

    def first_edge(self, task: Task, moment: float) -> float:
        """When the first sample comes that a trigger at `moment` calls for, s.

        An output's clock that runs by itself has its next edge up to a sample later.
        """
        timing = task.clocked()
        if task.is_input or task.timebase or not any(self._surroundings.clock_errors):
            return moment
        return math.ceil(moment * timing.pace - 1e-4) / timing.pace

    def _master(self, task: Task) -> Task | None:
        """Return the task whose timebase paces this one."""
        wanted = task.timebase.lower()
        others = (other for other in self._tasks.values() if other is not task and not other.timebase)
        return next((one for one in others if wanted and self.timebase(one).lower() == wanted), None)


def _coerced(task: Task, asked: float, timebase: float) -> float:
    """Rate the hardware makes of the one asked for, Hz."""
    rates = []
    for channel in task.channels:
        module = channel.module
        if isinstance(module, ThermocoupleModule):
            rates.append(asked)
            continue
        if isinstance(module, OutputModule):
            module = replace(module, timebase=timebase)
        try:
            rates.append(module.coerced_rate(asked))
        except ValueError as error:
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_ATTRIBUTE_VALUE,
                f"Requested value is not a supported value for this property. Property: SampClk.Rate: {error}",
            ) from error
    return max(rates, default=asked)
