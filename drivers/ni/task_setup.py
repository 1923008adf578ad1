"""Tasks of the driver, set up as the wiring says."""

from collections.abc import Iterable
from typing import Any

import numpy as np
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
from numpy.typing import NDArray

from drivers.ni.connection import Connection, Device
from drivers.ni.errors import Action, DaqError
from drivers.ni.modules import WITH_IEPE, find_module
from drivers.ni.wiring import InputWiring, Wiring

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
