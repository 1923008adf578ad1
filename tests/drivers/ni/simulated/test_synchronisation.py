"""Start triggers, timing engines and reservations, as a plain nidaqmx program meets them."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from nidaqmx.constants import AcquisitionType, TaskMode
from nidaqmx.errors import DaqError

from drivers.ni.simulated.servicer import SimulatedDaq

NewTask = Callable[..., Any]


@pytest.fixture
def pair(new_task: NewTask) -> tuple[Any, Any]:
    """Return an input and an output task of 1000 samples, the output waiting for the input's trigger."""
    inputs, output = new_task(), new_task()
    inputs.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
    inputs.timing.cfg_samp_clk_timing(8533.0, sample_mode=AcquisitionType.FINITE, samps_per_chan=1000)
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(
        inputs.timing.samp_clk_rate, sample_mode=AcquisitionType.FINITE, samps_per_chan=1000
    )
    inputs.control(TaskMode.TASK_RESERVE)
    output.triggers.start_trigger.cfg_dig_edge_start_trig(inputs.triggers.start_trigger.term)
    output.write(np.full(1000, 2.0), auto_start=False)
    return inputs, output


def test_output_armed_first_is_heard_from_the_first_sample(pair: tuple[Any, Any]) -> None:
    inputs, output = pair
    output.start()
    inputs.start()
    recorded = np.array(inputs.read(1000))
    output.wait_until_done()
    assert np.abs(recorded[:30]).max() < 0.05  # the filter's delay is 38.4 samples, and it rings a little before
    assert recorded[100:] == pytest.approx(2.0, abs=1e-3)


def test_input_started_first_records_silence_and_the_output_never_ends(pair: tuple[Any, Any]) -> None:
    inputs, output = pair
    inputs.start()
    output.start()
    assert np.abs(inputs.read(1000)).max() < 1e-3
    with pytest.raises(DaqError) as caught:
        output.wait_until_done(timeout=5.0)
    assert caught.value.error_code == -200560


def test_terminal_written_down_beforehand_is_somebody_elses_when_another_task_runs(new_task: NewTask) -> None:
    slow = new_task()
    slow.ai_channels.add_ai_thrmcpl_chan("cDAQ1Mod3/ai0")
    slow.timing.cfg_samp_clk_timing(2.0, sample_mode=AcquisitionType.CONTINUOUS)
    slow.start()
    inputs, output = new_task(), new_task()
    inputs.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
    inputs.timing.cfg_samp_clk_timing(8533.0, sample_mode=AcquisitionType.FINITE, samps_per_chan=1000)
    inputs.control(TaskMode.TASK_RESERVE)
    assert inputs.triggers.start_trigger.term == "/cDAQ1/te0/StartTrigger"
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(8533.0, sample_mode=AcquisitionType.FINITE, samps_per_chan=1000)
    output.triggers.start_trigger.cfg_dig_edge_start_trig("/cDAQ1/ai/StartTrigger")
    output.write(np.full(1000, 2.0), auto_start=False)
    output.start()
    inputs.start()
    assert np.abs(inputs.read(1000)).max() < 1e-3


def test_terminal_that_is_not_there_is_refused(new_task: NewTask) -> None:
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    with pytest.raises(DaqError) as caught:
        output.triggers.start_trigger.cfg_dig_edge_start_trig("/cDAQ2/ai/StartTrigger")
    assert caught.value.error_code == -89120


def test_module_belongs_to_one_task_at_a_time(new_task: NewTask) -> None:
    first, second = new_task("first"), new_task("second")
    for task, channel in ((first, "ai0"), (second, "ai1")):
        task.ai_channels.add_ai_voltage_chan(f"cDAQ1Mod1/{channel}")
        task.timing.cfg_samp_clk_timing(8533.0, sample_mode=AcquisitionType.CONTINUOUS)
    first.start()
    with pytest.raises(DaqError, match="task first") as caught:
        second.start()
    assert caught.value.error_code == -50103
    first.stop()
    second.start()


def test_reservation_made_on_purpose_outlives_a_stop(new_task: NewTask) -> None:
    first, second = new_task("first"), new_task("second")
    for task in (first, second):
        task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
        task.timing.cfg_samp_clk_timing(8533.0, sample_mode=AcquisitionType.CONTINUOUS)
    first.control(TaskMode.TASK_RESERVE)
    first.start()
    first.stop()
    with pytest.raises(DaqError, match="reserved by task first"):
        second.start()
    first.control(TaskMode.TASK_UNRESERVE)
    second.start()


def test_stopped_output_keeps_its_voltage(new_task: NewTask, server: SimulatedDaq) -> None:
    """Why every way out has to bring it down."""
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(2000.0, sample_mode=AcquisitionType.CONTINUOUS)
    output.write(np.full(100, 1.5), auto_start=True)
    server.clock.sleep(1.0)
    output.stop()
    output.close()
    assert server.output_voltage() == pytest.approx(1.5, abs=1e-6)


def test_task_without_channels_or_samples_does_not_start(new_task: NewTask) -> None:
    with pytest.raises(DaqError) as caught:
        new_task().start()
    assert caught.value.error_code == -200478
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(2000.0, sample_mode=AcquisitionType.FINITE, samps_per_chan=10)
    with pytest.raises(DaqError) as caught:
        output.start()
    assert caught.value.error_code == -200462


@pytest.mark.parametrize(("asked", "given"), [(8500.0, 51_200 / 6), (51_200.0, 51_200.0), (1.0, 51_200 / 31)])
def test_rate_ladder_is_read_back(new_task: NewTask, asked: float, given: float) -> None:
    task = new_task()
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0:3")
    task.timing.cfg_samp_clk_timing(asked, samps_per_chan=100)
    assert task.timing.samp_clk_rate == pytest.approx(given, rel=1e-12)
