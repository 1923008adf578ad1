"""The modules in their slots: who has reserved them, what times and triggers tasks, what is on their outputs.

A task is paced by the crystal of its modules, or by the timebase of another task.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from nidaqmx.error_codes import DAQmxErrors
from numpy.typing import NDArray

from drivers.clock import Clock
from drivers.ni.modules import CHASSIS_CLOCK, OutputModule, ThermocoupleModule
from drivers.ni.simulated.faults import DaqmxStatusError, Faults
from drivers.ni.simulated.surroundings import Module, Surroundings
from drivers.ni.simulated.task import SampleTiming, Task, TaskState

INTERPOLATION_SAMPLES = 24
"""Samples on either side from which the voltage between two samples is computed: to 1e-3 up to 0.45 of it."""
SMOOTH_RATE_RATIO = 0.75
"""Samples played per sample recorded, from which on the stairs between them are not seen."""


@dataclass(frozen=True)
class _Run:
    """Samples played from `start` on; the last is held. `repeats` plays them over and over instead."""

    start: float
    rate: float
    samples: NDArray[np.float64]
    repeats: bool

    def at(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        # Moments are multiples of a sample period counted from some other start: rounding must not
        # take the sample before the one that has just begun.
        position = (moments - self.start) * self.rate
        index = np.floor(position + 1e-4).astype(np.int64)
        fraction = position - index
        if self._in_stairs(position) or not np.any(np.abs(fraction) > 1e-3):
            return self._sample(index)
        return self._between(index, np.clip(fraction, 1e-9, None))

    def _in_stairs(self, position: NDArray[np.float64]) -> bool:
        """Whether who looks is quick enough to see the stairs: behind a slower input's filter there are none."""
        return self.samples.size < 2 or position.size < 2 or float(position[1] - position[0]) < SMOOTH_RATE_RATIO

    def _sample(self, index: NDArray[np.int64]) -> NDArray[np.float64]:
        if self.repeats:
            return np.asarray(self.samples[np.maximum(index, 0) % self.samples.size])
        return np.asarray(self.samples[np.clip(index, 0, self.samples.size - 1)])

    def _between(self, index: NDArray[np.int64], fraction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the smooth voltage between samples: a sum of sinc functions under a Hann window."""
        total, angle = np.zeros(index.size), 0.5 * np.pi / INTERPOLATION_SAMPLES
        even, odd = np.cos(angle * fraction), np.sin(angle * fraction)
        for tap in range(1 - INTERPOLATION_SAMPLES, INTERPOLATION_SAMPLES + 1):
            window = (even * np.cos(angle * tap) + odd * np.sin(angle * tap)) ** 2
            total += self._sample(index + tap) * window * (-1.0) ** tap / (fraction - tap)
        return np.asarray(total * np.sin(np.pi * fraction) / np.pi)


class OutputLine:
    """What a digital-to-analog converter has put on its terminal so far, and is going to.

    It holds its last value until the next command, as the real one does: stopping a task leaves the
    voltage standing.

    Attributes
    ----------
    version : int
        Counts the changes, which shows whether results computed from it are out of date.
    """

    def __init__(self, module: OutputModule) -> None:
        self._module = module
        self._runs = [_Run(-1e9, 1.0, np.zeros(1), repeats=False)]
        self.version = 0

    def play(self, samples: NDArray[np.float64], rate: float, start: float, repeats: bool = False) -> None:
        """Play samples, rounded to the converter's codes and clipped at its full scale.

        Parameters
        ----------
        samples : (M,) ndarray
            V.
        rate : float
            Hz.
        start : float
            When the first sample comes, s on the simulation's clock.
        repeats : bool
            Begin again after the last sample, without end; otherwise the last one stands.
        """
        quantum = self._module.quantum
        reach = self._module.full_scale
        coded = np.clip(np.round(np.asarray(samples, dtype=np.float64) / quantum) * quantum, -reach, reach)
        self._runs.append(_Run(start, rate, coded, repeats))
        self.version += 1

    def extend(self, samples: NDArray[np.float64]) -> None:
        """Add samples to those being played."""
        latest = self._runs.pop()
        self.play(np.concatenate([latest.samples, samples]), latest.rate, latest.start, latest.repeats)

    def hold(self, value: float, moment: float) -> None:
        """Put a single value on the terminal."""
        self.play(np.array([value]), 1.0, moment)

    def stop(self, moment: float) -> None:
        """Hold from `moment` on what is on the terminal then."""
        self.hold(self.voltage(moment), moment)

    def voltage(self, moment: float) -> float:
        """Voltage at one moment, V."""
        return float(self.voltages(np.array([moment]))[0])

    def voltages(self, moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """Voltages at ascending moments (M,), V."""
        values = np.empty(len(moments))
        first = np.searchsorted(moments, [run.start - 1e-4 / run.rate for run in self._runs])
        # A run that starts later overrides; runs are in the order they were begun.
        last = np.minimum.accumulate(np.append(first[1:], len(moments))[::-1])[::-1]
        for number, run in enumerate(self._runs):
            values[first[number] : last[number]] = run.at(moments[first[number] : last[number]])
        return values

    def forget_before(self, moment: float) -> None:
        """Drop samples that are not needed any more: memory must not grow during a long campaign."""
        last = max((n for n, run in enumerate(self._runs) if run.start <= moment), default=0)
        self._runs = self._runs[last:]


PRODUCT = "cDAQ-9178"
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


class Chassis:
    """A cDAQ-9178 and what its tasks do with it.

    Attributes
    ----------
    surroundings : Surroundings
    clock : Clock
        Usually virtual: it then advances only while a client waits for samples.
    faults : Faults
        May be replaced at any time.
    tasks : dict of str to Task
        By handle.
    clocks : SampleClocks
    lines : dict of str to OutputLine
        By output terminal.
    """

    def __init__(self, surroundings: Surroundings, clock: Clock, faults: Faults) -> None:
        self.surroundings = surroundings
        self.clock = clock
        self.faults = faults
        self.tasks: dict[str, Task] = {}
        self.clocks = SampleClocks(surroundings, self.tasks)
        self._seen = clock.now()
        self._handled: tuple[float, float] | None = None
        self.lines = {
            terminal: OutputLine(module)
            for terminal, module in surroundings.terminals().items()
            if isinstance(module, OutputModule)
        }

    def plugged_in(self, moment: float) -> bool:
        """Whether the chassis can be reached at a moment."""
        gap = self.faults.unplugged
        return gap is None or not gap[0] <= moment < gap[1]

    def devices(self) -> dict[str, Module]:
        """Modules the driver sees now."""
        return self.surroundings.devices() if self.plugged_in(self.clock.now()) else {}

    def pass_time_to(self, moment: float) -> None:
        """Let time pass until `moment`, s, with all that happens on the way."""
        self.clock.sleep(moment - self.clock.now())
        self.catch_up()

    def catch_up(self) -> None:
        """Break every started task if the chassis has been unplugged since time was last looked at.

        Somebody else, an oven, may have moved the clock meanwhile.
        """
        seen, self._seen = self._seen, self.clock.now()
        gap = self.faults.unplugged
        if gap is None or gap[0] > self._seen or gap[1] <= seen:
            return
        if gap != self._handled:
            self._handled = gap
            for line in self.lines.values():
                line.stop(max(gap[0], seen))
        for task in self.tasks.values():
            if task.state is not TaskState.CONFIGURED and task.broken is None:
                code = self.faults.unplugged_code
                task.broken = DaqmxStatusError(
                    code, f"Device cannot be accessed. Device: {', '.join(task.devices())}"
                )

    def verify(self, task: Task) -> None:
        """Refuse a task whose hardware is not there or that has no channels."""
        if task.broken is not None:
            raise task.broken
        if not task.channels:
            raise DaqmxStatusError(
                DAQmxErrors.CAN_NOT_PERFORM_OP_WHEN_NO_CHANS_IN_TASK,
                f"Operation cannot be performed when there are no channels in the task. Task Name: {task.name}",
            )
        for device in task.devices():
            if device not in self.devices():
                raise DaqmxStatusError(
                    DAQmxErrors.INVALID_DEVICE_ID, f"Device identifier is invalid. Device Specified: {device}"
                )

    def reserve(self, task: Task) -> None:
        """Give a task its modules and a timing engine, or say who has them."""
        self.verify(task)
        if task.state is not TaskState.CONFIGURED:
            return
        others = [
            other for other in self.tasks.values() if other is not task and other.state is not TaskState.CONFIGURED
        ]
        for other in others:
            shared = sorted(set(task.devices()) & set(other.devices()))
            if shared:
                self._reserved(task, f"{', '.join(shared)} is reserved by task {other.name}")
        if task.timing is not None:
            free = [engine for engine in engines(task) if engine not in [other.engine for other in others]]
            if not free:
                self._reserved(task, f"all {len(engines(task))} timing engines are reserved")
            task.engine = free[0]
        task.state = TaskState.RESERVED

    def _reserved(self, task: Task, why: str) -> None:
        raise DaqmxStatusError(
            DAQmxErrors.PAL_RESOURCE_RESERVED,
            f"The specified resource is reserved. The operation could not be completed as specified: {why}. "
            f"Task Name: {task.name}",
        )

    def release(self, task: Task) -> None:
        """Give modules and engine back."""
        task.state = TaskState.CONFIGURED
        task.engine = ""
        task.reserved_on_purpose = False

    def known_terminal(self, terminal: str) -> str:
        """Return the full name of a source of triggers; refuse one that the chassis does not have."""
        full = self.clocks.full_name(terminal)
        known = [f"/{self.surroundings.chassis}/{engine}/StartTrigger" for engine in (*INPUT_ENGINES, "ao")]
        if not self.clocks.is_pfi(full) and full.lower() not in [name.lower() for name in known]:
            raise DaqmxStatusError(
                DAQmxErrors.INVALID_ROUTING_SOURCE_TERMINAL_NAME_ROUTING,
                f"Source terminal to be routed could not be found on the device. Source Terminal: {terminal}",
            )
        return full

    def start(self, task: Task) -> None:
        """Start a task: at once, or armed for its trigger."""
        on_purpose = task.state is TaskState.RESERVED
        self.reserve(task)
        if task.state is TaskState.STARTED:
            raise DaqmxStatusError(
                DAQmxErrors.CAN_NOT_PERFORM_OP_WHILE_TASK_RUNNING,
                f"Specified operation cannot be performed while the task is running. Task Name: {task.name}",
            )
        if not task.is_input and task.timing is not None and not task.written.size:
            self.release(task)
            raise DaqmxStatusError(
                DAQmxErrors.OUTPUT_BUFFER_EMPTY,
                f"Generation cannot be started: the output buffer is empty. Task Name: {task.name}",
            )
        task.reserved_on_purpose = on_purpose
        task.state = TaskState.STARTED
        task.position = task.announced = 0
        task.pieces.clear()  # of the last run, perhaps with other channels
        task.began = None
        if not task.trigger or self.clocks.is_pfi(task.trigger):
            now = self.clock.now()
            self._begin(task, _next_pulse(now) if task.trigger else now)

    def _begin(self, task: Task, moment: float) -> None:
        """Take or play the first sample, and start the tasks that this triggers."""
        if task.timing is not None:
            moment = self.clocks.first_edge(task, moment)
        if task.timing is not None and task.pretrigger is not None:
            before = task.pretrigger / task.timing.pace
            moment = _next_pulse(moment + before) - before
        task.began = moment
        if not task.is_input and task.timing is not None:
            self._play(task, moment)
        start_trigger = self.clocks.terminal(task, "StartTrigger").lower()
        if self.faults.stuck_trigger:
            return
        for other in self.tasks.values():
            if other.state is TaskState.STARTED and other.began is None and other.trigger.lower() == start_trigger:
                self._begin(other, moment)

    def _play(self, task: Task, moment: float) -> None:
        timing = task.clocked()
        for channel, samples in zip(task.channels, task.written, strict=True):
            played = np.resize(samples, timing.samples) if timing.finite else samples
            repeats = not timing.finite and task.regenerates
            self.lines[channel.terminal].play(played, timing.pace, moment, repeats)

    def put(self, task: Task, values: NDArray[np.float64]) -> None:
        """Put single values on a task's outputs at once, as on-demand writing does."""
        self.reserve(task)
        for channel, value in zip(task.channels, values, strict=True):
            self.lines[channel.terminal].hold(float(value), self.clock.now())
        self.release(task)

    def stop(self, task: Task) -> None:
        """Stop a task; an output keeps the voltage it has."""
        now = self.clock.now()
        playing = task.state is TaskState.STARTED and not task.is_input and task.began is not None
        if playing and task.broken is None and now < task.ends():
            for channel in task.channels:
                self.lines[channel.terminal].stop(now)
        if task.state is TaskState.STARTED and task.reserved_on_purpose:
            task.state = TaskState.RESERVED
        else:
            self.release(task)
        task.began = None
        task.announced = 0
        self._tidy()

    def _tidy(self) -> None:
        """Forget output that no running input can still ask for."""
        if not any(task.is_input and task.state is TaskState.STARTED for task in self.tasks.values()):
            for line in self.lines.values():
                line.forget_before(self.clock.now() - self.surroundings.memory - 4.0)

    def done(self, task: Task) -> bool:
        """Whether a task has nothing left to do."""
        return task.state is not TaskState.STARTED or self.clock.now() >= task.ends() - 1e-9


def _next_pulse(moment: float) -> float:
    """When the next pulse after `moment` comes on a PFI terminal, s."""
    return (math.floor(moment / PULSE_INTERVAL + 1e-9) + 1) * PULSE_INTERVAL
