"""The simulated server on a port of this computer, and of no other."""

import ipaddress
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import grpc
from nidaqmx._stubs.nidaqmx_pb2_grpc import add_NiDAQmxServicer_to_server

from drivers.ni.connection import MESSAGE_LIMITS
from drivers.ni.simulated.servicer import SimulatedDaq

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
