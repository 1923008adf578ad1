"""How a call to the simulated server is counted, made to fail and answered."""

import threading
from collections import Counter
from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, NoReturn

import grpc
from nidaqmx.error_codes import DAQmxErrors

from drivers.ni.simulated.acquisition import InputRecorder
from drivers.ni.simulated.chassis import Chassis
from drivers.ni.simulated.faults import DaqmxStatusError, Faults, status_name
from drivers.ni.simulated.task import Task

NOT_SIMULATED = DAQmxErrors.OPERATION_NOT_SUPPORTED_ON_SIMULATED_DEVICE
"""Status of a call that asks for what is not simulated."""


class NotSimulatedError(Exception):
    """The simulated server does not know what it was asked for."""


class Answering:
    """What every kind of call needs: the chassis, the tasks, a lock, the faults and the counts.

    Attributes
    ----------
    calls : Counter of str
        How often each remote call was made.
    lacking : set of str
        Calls and properties a client wanted that this server does not have.
    """

    def __init__(self, chassis: Chassis, acquisition: InputRecorder) -> None:
        self.chassis = chassis
        self.acquisition = acquisition
        self.calls: Counter[str] = Counter()
        self.lacking: set[str] = set()
        self.lock = threading.RLock()
        self._since_faults: Counter[str] = Counter()

    def inject(self, faults: Faults) -> None:
        """Replace what is to go wrong; calls are counted anew."""
        with self.lock:
            self.chassis.faults = faults
            self._since_faults.clear()

    def begin(self, call: str) -> None:
        """Count a call and fail it if it is to fail."""
        self.calls[call] += 1
        self._since_faults[call] += 1
        self.chassis.catch_up()
        for fault in self.chassis.faults.calls:
            if fault.call == call and fault.strikes(self._since_faults[call]):
                raise DaqmxStatusError(fault.code, f"{status_name(fault.code)}. (Put in on purpose at {call}.)")

    def task_of(self, request: Any) -> Task:
        """Return the task a request names."""
        task = self.chassis.tasks.get(request.task.name)
        if task is None:
            raise DaqmxStatusError(DAQmxErrors.INVALID_TASK, "Task specified is invalid or does not exist.")
        return task

    def lacks(self, what: str) -> NoReturn:
        """Remember that a client wanted what this server does not have, and refuse it."""
        self.lacking.add(what)
        raise NotSimulatedError(what)

    def one_of(self, values: Mapping[int, Any], enumeration: Any, request: Any) -> Any:
        """Return the value of the property a request names, in whichever of the two fields it came.

        Parameters
        ----------
        values : mapping of int to object
            Number of a property -> its value.
        enumeration : protobuf enum wrapper
            Names of the properties, for the message.
        request : protobuf message
            With the fields `attribute` and `attribute_raw`.

        Returns
        -------
        object
            The value in `values`.

        Raises
        ------
        NotSimulatedError
            If `values` has no such property; see `lacks`.
        """
        wanted = int(request.attribute_raw or request.attribute)
        if wanted in values:
            return values[wanted]
        names = {number: name for name, number in enumeration.items()}
        self.lacks(f"{type(request).__name__.removesuffix('Request')} {names.get(wanted, wanted)}")


def refuse(context: Any, status: DaqmxStatusError) -> None:
    """End a call the way the real server does: status in the trailing metadata, words in the details."""
    context.set_trailing_metadata((("ni-error", str(status.code)),))
    context.abort(grpc.StatusCode.UNKNOWN, str(status))


def refuse_lacking(context: Any, lacking: NotSimulatedError) -> None:
    """End a call that asks for what is not simulated, and say what that is."""
    said = f"Not simulated by Flexura's cards: {lacking}. Real cards and NI's own server may have it."
    refuse(context, DaqmxStatusError(NOT_SIMULATED, said))


def answered(handle: Callable[[Any, Any], Any]) -> Callable[[Any, Any, Any], Any]:
    """Make a method (self, request) -> response into one of the service's calls."""
    call = handle.__name__

    @wraps(handle)
    def answer(self: Answering, request: Any, context: Any) -> Any:
        try:
            with self.lock:
                self.begin(call)
                return handle(self, request)
        except DaqmxStatusError as status:
            return refuse(context, status)
        except NotSimulatedError as lacking:
            return refuse_lacking(context, lacking)

    return answer
