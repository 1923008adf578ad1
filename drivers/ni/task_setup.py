"""Tasks of the driver, set up as the wiring says."""

from typing import Any

import numpy as np
from nidaqmx.constants import (
    AcquisitionType,
    Coupling,
    TemperatureUnits,
    TerminalConfiguration,
    ThermocoupleType,
)

from drivers.ni.errors import Action, DaqError
from drivers.ni.wiring import Wiring

SAME_RATE = 1e-5
"""Output and inputs may be set to rates that differ by so much, as a share; crystals differ by more."""


def set_up_inputs(task: Any, wiring: Wiring, samples: int) -> float:
    """Set an input task up for so many samples and return its rate as read back, Hz."""
    for terminal in wiring.inputs:
        channel = task.ai_channels.add_ai_voltage_chan(
            terminal,
            terminal_config=TerminalConfiguration[wiring.terminal_configuration],
            min_val=-wiring.input_range,
            max_val=wiring.input_range,
        )
        if wiring.coupling != "DEFAULT":
            channel.ai_coupling = Coupling[wiring.coupling]
    task.timing.cfg_samp_clk_timing(wiring.sample_rate, sample_mode=AcquisitionType.FINITE, samps_per_chan=samples)
    return float(task.timing.samp_clk_rate)


def set_up_output(task: Any, wiring: Wiring, sample_rate: float, samples: int, inputs: Any = None) -> None:
    """Set an output task up for so many samples.

    Parameters
    ----------
    task : nidaqmx.Task
    wiring : Wiring
    sample_rate : float
        Of the inputs, Hz.
    samples : int
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


def set_up_thermocouples(task: Any, wiring: Wiring) -> None:
    """Put every thermocouple into a task."""
    for terminal in wiring.thermocouples:
        task.ai_channels.add_ai_thrmcpl_chan(
            terminal,
            units=TemperatureUnits.DEG_C,
            thermocouple_type=ThermocoupleType[wiring.thermocouple_type],
        )
