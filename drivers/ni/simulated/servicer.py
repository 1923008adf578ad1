"""The simulated NI gRPC Device Server.

Every call of NI's service that is not simulated is refused by its name: a call without a method ends in the advice
to upgrade the server, which does not say what is missing.

The simulated server on a port of this computer, and of no other.

A gRPC channel that calls the simulated server directly: no port, no bytes, microseconds a call.
"""

import ipaddress
import queue
import threading
from collections import namedtuple
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any, Self

import grpc
from nidaqmx._stubs.nidaqmx_pb2_grpc import NiDAQmxServicer, add_NiDAQmxServicer_to_server

from drivers.clock import Clock, VirtualClock
from drivers.ni.connection import MESSAGE_LIMITS
from drivers.ni.simulated.acquisition import InputRecorder
from drivers.ni.simulated.answering import Answering, NotSimulatedError, refuse_lacking
from drivers.ni.simulated.channel_calls import ChannelCalls, SystemCalls
from drivers.ni.simulated.chassis import Chassis
from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.stream_calls import WaveformCalls
from drivers.ni.simulated.surroundings import Surroundings
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


_WORKERS = 16
"""Calls answered at once; every event a client waits for holds one."""


class _Notices(grpc.ServerInterceptor):
    """Lets the server know of calls it has no method for: a newer client's."""

    def __init__(self, server: SimulatedDaq) -> None:
        self._server = server

    def intercept_service(self, continuation: Any, details: Any) -> Any:
        self._server.notice(details.method.rpartition("/")[2])
        return continuation(details)


@contextmanager
def serving(server: SimulatedDaq, port: int = 0, host: str = "127.0.0.1") -> Iterator[str]:
    """Serve on a loopback port while the block runs.

    Parameters
    ----------
    port : int
        0 lets the system choose one that is free.
    host : str
        A loopback address. Any other is refused: the protocol has neither password nor encryption.

    Yields
    ------
    str
        ``host:port`` to connect to.

    Raises
    ------
    ValueError
        If `host` is not a loopback address, or the port is out of range.
    OSError
        If the port is taken.
    """
    name = f"[{host}]" if ":" in host else host
    if host != "localhost" and not _is_loopback(host):
        raise ValueError(
            f"host {host!r}; only this computer's own addresses are served (127.0.0.1, ::1, localhost)"
        )
    if not 0 <= port <= 65_535:
        raise ValueError(f"port {port}; 0 (any free one) to 65535 allowed")
    # Two servers sharing a port would answer in turns.
    options = (*MESSAGE_LIMITS, ("grpc.so_reuseport", 0))
    pool = ThreadPoolExecutor(_WORKERS, thread_name_prefix="simulated DAQ")
    listener = grpc.server(pool, interceptors=[_Notices(server)], options=options)
    add_NiDAQmxServicer_to_server(server, listener)
    try:
        bound = listener.add_insecure_port(f"{name}:{port}")
    except RuntimeError as error:
        pool.shutdown()
        raise OSError(f"port {port} of {host} cannot be served: is another program on it?") from error
    listener.start()
    try:
        yield f"{name}:{bound}"
    finally:
        listener.stop(grace=0.5).wait()
        pool.shutdown()


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


_Entry = namedtuple("_Entry", ("key", "value"))
_END = object()


class InProcessError(grpc.RpcError):
    """A call that the server ended with an error, as a client sees it."""

    def __init__(self, code: grpc.StatusCode, details: str, trailing: tuple[_Entry, ...]) -> None:
        super().__init__(details)
        self._seen = (code, details, trailing)

    def code(self) -> grpc.StatusCode:
        """Return gRPC's own status."""
        return self._seen[0]

    def details(self) -> str:
        """Return the server's words."""
        return self._seen[1]

    def trailing_metadata(self) -> tuple[_Entry, ...]:
        """Return what the server sent along."""
        return self._seen[2]


class _Context:
    """The server's side of one call."""

    def __init__(self) -> None:
        self._trailing: tuple[_Entry, ...] = ()
        self._cancelled = threading.Event()
        self.registered = threading.Event()

    def set_trailing_metadata(self, entries: tuple[tuple[str, str], ...]) -> None:
        self._trailing = tuple(_Entry(*entry) for entry in entries)

    def abort(self, code: grpc.StatusCode, details: str) -> None:
        raise InProcessError(code, details, self._trailing)

    def send_initial_metadata(self, _: tuple[()]) -> None:
        self.registered.set()

    def is_active(self) -> bool:
        return not self._cancelled.is_set()

    def cancel(self) -> None:
        self._cancelled.set()

    # The message of the stub's base class for a call that is not implemented.
    def set_code(self, code: grpc.StatusCode) -> None:
        self._code = code

    def set_details(self, details: str) -> None:
        self.abort(self._code, details)


class _Stream:
    """The client's side of a call that answers many times."""

    def __init__(self, handle: Callable[[Any, Any], Iterator[Any]], request: Any) -> None:
        self._context = _Context()
        self._answers: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._failure: InProcessError | None = None
        threading.Thread(target=self._run, args=(handle, request), daemon=True).start()

    def _run(self, handle: Callable[[Any, Any], Iterator[Any]], request: Any) -> None:
        try:
            for answer in handle(request, self._context):
                self._answers.put(answer)
        except InProcessError as error:
            self._failure = error
        finally:
            self._context.registered.set()
            self._answers.put(_END)

    def initial_metadata(self) -> tuple[()]:
        self._context.registered.wait()
        return ()

    def done(self) -> bool:
        return self._failure is not None

    def exception(self) -> InProcessError | None:
        return self._failure

    def cancel(self) -> None:
        self._context.cancel()
        self._answers.put(_END)

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Any:
        answer = self._answers.get()
        if answer is _END:
            raise StopIteration
        return answer


class InProcessChannel(grpc.Channel):
    """Leads to a simulated server in this process; hand it to ``nidaqmx.GrpcSessionOptions``.

    Parameters
    ----------
    server : SimulatedDaq
    """

    def __init__(self, server: SimulatedDaq) -> None:
        self._server = server

    def unary_unary(self, method: str, *_: Any, **__: Any) -> Callable[..., Any]:
        """Return a function that makes one call and returns its answer."""

        def call(request: Any, **_: Any) -> Any:
            return self._server.notice(method.rpartition("/")[2])(request, _Context())

        return call

    def unary_stream(self, method: str, *_: Any, **__: Any) -> Callable[..., Any]:
        """Return a function that makes one call and returns a stream of its answers."""

        def call(request: Any, **_: Any) -> _Stream:
            return _Stream(self._server.notice(method.rpartition("/")[2]), request)

        return call

    def stream_unary(self, method: str, *_: Any, **__: Any) -> Callable[..., Any]:
        """Refuse: NI-DAQmx has no such call."""
        raise NotImplementedError(method)

    def stream_stream(self, method: str, *_: Any, **__: Any) -> Callable[..., Any]:
        """Refuse: NI-DAQmx has no such call."""
        raise NotImplementedError(method)

    def subscribe(self, callback: Callable[[Any], None], try_to_connect: bool | None = False) -> None:
        """Tell that the server is there, as it always is."""
        callback(grpc.ChannelConnectivity.READY)

    def unsubscribe(self, callback: Callable[[Any], None]) -> None:
        """Forget a listener; nothing ever changes here."""

    def close(self) -> None:
        """Do nothing: there is no connection to close."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
