"""The way to NI-DAQmx: the driver on this computer, or an NI gRPC Device Server, real or simulated."""

import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Self

import grpc
import nidaqmx
from nidaqmx import errors
from nidaqmx.system import System

from drivers.ni.errors import CHECK_CABLE, Action, DaqError, from_status

# A sweep is one message and easily passes gRPC's usual 4 MiB; both ends have to agree to that.
MESSAGE_LIMITS = (("grpc.max_send_message_length", -1), ("grpc.max_receive_message_length", -1))

# A server whose computer has lost its power never answers, and TCP alone takes a quarter of an hour to
# notice. Calls here last a second or two, so these pings are sent only when one already lasts too long.
_LIVENESS = (
    ("grpc.keepalive_time_ms", 10_000),
    ("grpc.keepalive_timeout_ms", 5_000),
    ("grpc.min_reconnect_backoff_ms", 3_000),  # and no longer than this for each attempt to come back
    ("grpc.max_reconnect_backoff_ms", 10_000),
)

_NO_DRIVER = (
    'install NI-DAQmx from ni.com, or name a computer that has it (grpc = "host:port"), or use the simulated rig'
)
_NO_SERVER = 'check the address in grpc = "host:port" and that the NI gRPC Device Server is running there'


@dataclass(frozen=True)
class Device:
    """A chassis, a module or a board, as the driver lists it."""

    name: str
    product: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    simulated: bool


class Connection:
    """Makes tasks, lists devices and turns the vendor's errors into `DaqError`.

    Parameters
    ----------
    address : str, optional
        ``host:port`` of an NI gRPC Device Server; the local driver if neither this nor `channel` is given.
    channel : grpc.Channel, optional
        A channel already open, for a server inside this process; it stays its owner's to close.

    Attributes
    ----------
    names_proven : bool
        Whether every name in use has been accepted before. One that is refused later is a device that
        has gone, not a slip in the settings.

    Notes
    -----
    The local driver clears the tasks of a process that ends, however it ends. NI's gRPC Device Server keeps
    them, with the modules that they have reserved, until they are cleared or the server is reset (its
    ``SessionRepository``): after a campaign was killed in a sweep nobody could bring the output to 0 V. So
    tasks on a server have names, and the first of each name clears what a killed process has left under it. The
    name holds the computer's: its processes use a module one at a time (`drivers.rig.occupancy`), and tasks of
    other computers stay.
    """

    def __init__(self, address: str | None = None, channel: Any = None) -> None:
        options = MESSAGE_LIMITS + _LIVENESS
        self._own = grpc.insecure_channel(address, options=options) if address and channel is None else None
        self._channel = channel if channel is not None else self._own
        self.names_proven = False
        self._own_names: set[str] = set()

    def _session(self, name: str = "") -> Any:
        # An empty session name asks the server for a new session every time.
        return None if self._channel is None else nidaqmx.GrpcSessionOptions(self._channel, name)

    def _new_task(self, use: str, terminal: str) -> Any:
        if self._channel is None:
            return nidaqmx.Task()
        # NI-DAQmx takes letters, digits and underscores in names of tasks without exception
        name = re.sub(r"\W", "_", f"flexura_{use}_{terminal.split('/')[0]}_{socket.gethostname()}", flags=re.ASCII)
        if name not in self._own_names:
            # attaches to a task of this name, or makes one; either is cleared
            nidaqmx.Task(name, grpc_options=self._session(name)).close()
            self._own_names.add(name)
        return nidaqmx.Task(name, grpc_options=self._session(name))

    @contextmanager
    def task(self, use: str, terminal: str) -> Iterator[Any]:
        """Give a new task and clear it afterwards.

        A task that cannot be cleared because the device is gone must not hide what went wrong first.

        Parameters
        ----------
        use : str
            What the task is for, the same whenever it uses the same hardware: ``inputs``, ``output``.
        terminal : str
            One of its terminals; its module is part of the task's name on a server.
        """
        task = self._new_task(use, terminal)
        try:
            yield task
        except BaseException as first:
            try:
                task.close()
            except Exception as second:  # noqa: BLE001 (a lost device may say so in any way)
                first.add_note(f"and the task could not be cleared: {second}")
            raise
        task.close()

    def devices(self) -> tuple[Device, ...]:
        """List every device that the driver reports.

        Raises
        ------
        DaqError
            If there is no driver, or no server answers.
        """
        with self.translated("listing the devices"):
            return tuple(
                Device(
                    name=device.name,
                    product=device.product_type,
                    inputs=tuple(device.ai_physical_chans.channel_names),
                    outputs=tuple(device.ao_physical_chans.channel_names),
                    simulated=device.is_simulated,
                )
                for device in System(self._session()).devices
            )

    @contextmanager
    def translated(self, doing: str) -> Iterator[None]:
        """Turn whatever the vendor's package raises within into a `DaqError` about `doing`."""
        try:
            yield
        except errors.DaqError as error:
            raise self._from_vendor(doing, error) from error
        except errors.DaqNotFoundError as error:
            raise DaqError(doing, "NI-DAQmx is not installed here.", None, Action.STOP, _NO_DRIVER) from error
        except errors.DaqNotSupportedError as error:
            raise DaqError(doing, str(error), None, Action.STOP, _NO_DRIVER) from error
        except errors.RpcError as error:
            lost = error.rpc_code in (grpc.StatusCode.UNAVAILABLE, grpc.StatusCode.CANCELLED)
            action = Action.LOST_DEVICE if lost else Action.STOP
            raise DaqError(doing, str(error), None, action, _NO_SERVER) from error

    def _from_vendor(self, doing: str, error: Any) -> DaqError:
        found = from_status(doing, error.error_code, str(error))
        if found.action is not Action.LIST_EXISTING:
            return found
        if self.names_proven:
            return DaqError(doing, str(error), error.error_code, Action.LOST_DEVICE, CHECK_CABLE)
        try:
            existing = tuple(channel for device in self.devices() for channel in (device.inputs + device.outputs))
        except DaqError:
            existing = ()
        return from_status(doing, error.error_code, str(error), existing or ("no channel at all",))

    def close(self) -> None:
        """Close the channel if it was opened here."""
        if self._own is not None:
            self._own.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
