"""A gRPC channel that calls the simulated server directly: no port, no bytes, microseconds a call."""

import queue
import threading
from collections import namedtuple
from collections.abc import Callable, Iterator
from typing import Any, Self

import grpc

from drivers.ni.simulated.servicer import SimulatedDaq

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
