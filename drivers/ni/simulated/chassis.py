"""The modules in their slots: who has reserved them, which engine times a task, what triggers what."""

import math

import numpy as np
from nidaqmx.error_codes import DAQmxErrors
from numpy.typing import NDArray

from drivers.clock import Clock
from drivers.ni.output_modules import OutputModule
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.output_line import OutputLine
from drivers.ni.simulated.sample_clocks import INPUT_ENGINES, PULSE_INTERVAL, SampleClocks, engines
from drivers.ni.simulated.status import DaqmxStatusError
from drivers.ni.simulated.surroundings import Module, Surroundings
from drivers.ni.simulated.task import Task, TaskState

PRODUCT = "cDAQ-9178"


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
