"""The simulated NI gRPC Device Server."""

from typing import Any

from drivers.clock import Clock, VirtualClock
from drivers.ni.simulated.acquisition import InputRecorder
from drivers.ni.simulated.channel_calls import ChannelCalls
from drivers.ni.simulated.chassis import Chassis
from drivers.ni.simulated.event_calls import EventCalls
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.refusals import Refusals
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.simulated.system_calls import SystemCalls
from drivers.ni.simulated.task_calls import TaskCalls
from drivers.ni.simulated.timing_calls import TimingCalls
from drivers.ni.simulated.waveform_calls import WaveformCalls


class SimulatedDaq(TaskCalls, TimingCalls, ChannelCalls, WaveformCalls, EventCalls, SystemCalls, Refusals):
    """NI's own service with the calls that a sweep, a thermocouple and a plain script make.

    Parameters
    ----------
    surroundings : Surroundings
    clock : Clock, optional
        Shared with an oven, if there is one; a virtual one of its own by default.
    seed : int
        Of the cards' noise.
    faults : Faults
    """

    def __init__(
        self,
        surroundings: Surroundings,
        clock: Clock | None = None,
        seed: int = 0,
        faults: Faults | None = None,
    ) -> None:
        chassis = Chassis(surroundings, clock or VirtualClock(), faults or Faults())
        super().__init__(chassis, InputRecorder(chassis, seed))

    @property
    def clock(self) -> Clock:
        """The rig's time."""
        return self.chassis.clock

    def output_voltage(self, terminal: str | None = None) -> float:
        """Voltage on an output now, V; by default on the one that drives the plate."""
        with self.lock:
            self.chassis.catch_up()
            line = self.chassis.lines[terminal or self.chassis.surroundings.output]
            return line.voltage(self.clock.now())

    def tasks_open(self) -> tuple[str, ...]:
        """Names of the tasks no client has cleared yet."""
        with self.lock:
            return tuple(self.chassis.tasks)

    def notice(self, call: str) -> Any:
        """Return the method for a call by its name; remember a call that is not simulated."""
        method = getattr(type(self), call, None)
        if method is None:
            self.lacking.add(call)
        return getattr(self, call, None)
