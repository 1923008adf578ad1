"""The way to NI-DAQmx: the driver on this computer, or an NI gRPC Device Server, real or simulated.

Tasks of the driver, set up as the wiring says.
"""

import re
import socket
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Self

import grpc
import nidaqmx
import numpy as np
from nidaqmx import errors
from nidaqmx.constants import (
    AccelSensitivityUnits,
    AccelUnits,
    AcquisitionType,
    Coupling,
    ExcitationSource,
    TaskMode,
    TemperatureUnits,
    TerminalConfiguration,
    ThermocoupleType,
)
from nidaqmx.stream_readers import AnalogMultiChannelReader
from nidaqmx.system import System
from numpy.typing import NDArray

from drivers.ni.cards import CHECK_CABLE, Action, DaqError, from_status
from drivers.ni.modules import WITH_IEPE, find_module
from drivers.ni.wiring import InputWiring, Wiring

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


IEPE_CURRENT = 0.002
"""What an input feeds a sensor with, A: the least that modules have, and enough for every sensor's cable here."""
SAME_RATE = 1e-5
"""Output and inputs may be set to rates that differ by so much, as a share; crystals differ by more."""


def set_up_inputs(task: Any, wiring: InputWiring, samples: int, *, endless: bool = False) -> float:
    """Set up an input task: channels, IEPE supply, coupling and sample clock.

    Parameters
    ----------
    task : nidaqmx.Task
        Without channels.
    samples : int
        Per channel; of an endless task the size of the driver's buffer.
    endless : bool
        Whether it goes on until it is stopped.

    Returns
    -------
    float
        Its sample rate as read back, Hz.
    """
    for terminal in wiring.inputs:
        limits = {
            "terminal_config": TerminalConfiguration[wiring.terminal_configuration],
            "min_val": -wiring.input_range,
            "max_val": wiring.input_range,
        }
        if terminal in wiring.iepe:  # a sensor of 1 V/g: what is read are volts, whatever the sensor measures
            task.ai_channels.add_ai_accel_chan(
                terminal,
                **limits,
                units=AccelUnits.G,
                sensitivity=1000.0,
                sensitivity_units=AccelSensitivityUnits.MILLIVOLTS_PER_G,
                current_excit_source=ExcitationSource.INTERNAL,
                current_excit_val=IEPE_CURRENT,
            )
            continue
        channel = task.ai_channels.add_ai_voltage_chan(terminal, **limits)
        if wiring.coupling != "DEFAULT":
            channel.ai_coupling = Coupling[wiring.coupling]
    mode = AcquisitionType.CONTINUOUS if endless else AcquisitionType.FINITE
    task.timing.cfg_samp_clk_timing(wiring.sample_rate, sample_mode=mode, samps_per_chan=samples)
    return float(task.timing.samp_clk_rate)


def verified_inputs(connection: Connection, wiring: InputWiring) -> tuple[float, float]:
    """Have the driver verify the inputs as wired.

    Returns
    -------
    sample_rate : float
        As read back, Hz.
    full_scale : float
        Voltage beyond which the inputs clip, V.

    Raises
    ------
    DaqError
        If a terminal does not exist, is taken, or does not do what the wiring asks of it.
    """
    if wiring.iepe:
        require_iepe(wiring, connection.devices())
    with (
        connection.translated("setting the input module up"),
        connection.task("inputs", wiring.inputs[0]) as inputs,
    ):
        set_up_inputs(inputs, wiring, samples=2)
        inputs.control(TaskMode.TASK_VERIFY)
        return float(inputs.timing.samp_clk_rate), float(inputs.ai_channels[0].ai_max)


def set_up_output(task: Any, wiring: Wiring, sample_rate: float, samples: int, inputs: Any = None) -> None:
    """Set an output task up for so many samples.

    Parameters
    ----------
    task : nidaqmx.Task
    sample_rate : float
        Of the inputs, Hz.
    inputs : nidaqmx.Task, optional
        Whose timebase is to pace the output; a clock of its own if left out.

    Raises
    ------
    DaqError
        If the output cannot run at the inputs' rate.
    """
    set_up_output_channel(task, wiring)
    timing = task.timing
    timing.cfg_samp_clk_timing(sample_rate, sample_mode=AcquisitionType.FINITE, samps_per_chan=samples)
    if inputs is not None:
        timing.samp_clk_timebase_src = inputs.timing.samp_clk_timebase_src
        timing.samp_clk_timebase_rate = inputs.timing.samp_clk_timebase_rate
    rate = float(timing.samp_clk_rate)
    if not np.isclose(rate, sample_rate, rtol=SAME_RATE):
        said = f"{wiring.output} would run at {rate:g} Hz, the inputs run at {sample_rate:g} Hz."
        step = "choose a cards.sample_rate that both modules have"
        raise DaqError("setting the output up", said, None, Action.STOP, step)


def set_up_output_channel(task: Any, wiring: Wiring) -> None:
    """Put the output into a task."""
    reach = wiring.output_range
    task.ao_channels.add_ao_voltage_chan(wiring.output, min_val=-reach, max_val=reach)


def require_iepe(wiring: InputWiring, devices: Iterable[Device]) -> None:
    """Raise DaqError where an input that is to feed its sensor is on a module known to be unable to."""
    products = {device.name: device.product for device in devices}
    for terminal in wiring.iepe:
        product = products.get(terminal.split("/")[0], "")
        module = find_module(product)
        if module is not None and not module.iepe:
            said = f"{terminal} is on an {product}, which feeds no IEPE sensor."
            step = f"wire it to one that does ({', '.join(WITH_IEPE)}), or remove it from cards.iepe"
            raise DaqError(
                "switching the IEPE supply on", said, None, Action.STOP, f"{step} and use a conditioner"
            )


def set_up_thermocouples(task: Any, wiring: InputWiring) -> None:
    """Put every thermocouple into a task."""
    for terminal in wiring.thermocouples:
        task.ai_channels.add_ai_thrmcpl_chan(
            terminal,
            units=TemperatureUnits.DEG_C,
            thermocouple_type=ThermocoupleType[wiring.thermocouple_type],
        )


def read_thermocouples(connection: Connection, wiring: InputWiring) -> NDArray[np.float64]:
    """Read every thermocouple once, (C,), degrees Celsius, in a task of its own: the module is a slow one."""
    if not wiring.thermocouples:
        return np.empty(0)
    with (
        connection.translated("reading the thermocouples"),
        connection.task("thermocouples", wiring.thermocouples[0]) as task,
    ):
        set_up_thermocouples(task, wiring)
        reader = AnalogMultiChannelReader(task.in_stream)
        reader.verify_array_shape = False  # it would ask the task for what stands in the line below
        readings = np.empty(len(wiring.thermocouples))
        reader.read_one_sample(readings, timeout=10.0)
        return readings
