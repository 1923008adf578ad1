"""The simulated NI gRPC Device Server.

Every call of NI's service that is not simulated is refused by its name: a call without a method ends in the advice
to upgrade the server, which does not say what is missing.
"""

from collections.abc import Callable
from typing import Any

from nidaqmx._stubs.nidaqmx_pb2_grpc import NiDAQmxServicer

from drivers.clock import Clock, VirtualClock
from drivers.ni.simulated.acquisition import InputRecorder
from drivers.ni.simulated.answering import Answering, NotSimulatedError, refuse_lacking
from drivers.ni.simulated.channel_calls import ChannelCalls
from drivers.ni.simulated.chassis import Chassis
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.stream_calls import WaveformCalls
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.simulated.system_calls import SystemCalls
from drivers.ni.simulated.task_calls import EventCalls, TaskCalls, TimingCalls


class Refusals(Answering):
    """The part of the service that is not there; whatever is takes its place."""


def _refusing(call: str) -> Callable[[Answering, Any, Any], Any]:
    def refused(self: Answering, request: Any, context: Any) -> Any:
        what = f"{call} {_property_of(request)}".strip()
        self.lacking.add(what)
        return refuse_lacking(context, NotSimulatedError(what))

    return refused


def _property_of(request: Any) -> str:
    """Name of the property that a request is about, if it is about one."""
    field = request.DESCRIPTOR.fields_by_name.get("attribute")
    if field is None:
        return ""
    number = int(request.attribute_raw or request.attribute)
    named = field.enum_type.values_by_number.get(number)
    return named.name if named else str(number)


VENDORS_CALLS = tuple(name for name in vars(NiDAQmxServicer) if name[0].isupper())
for _name in VENDORS_CALLS:
    setattr(Refusals, _name, _refusing(_name))


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
