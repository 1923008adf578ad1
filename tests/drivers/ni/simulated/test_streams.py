"""Buffers, timeouts and ranges, as a plain nidaqmx program meets them."""

from collections.abc import Callable
from typing import Any

import nidaqmx
import numpy as np
import pytest
from nidaqmx.constants import READ_ALL_AVAILABLE, AcquisitionType, RegenerationMode, TerminalConfiguration
from nidaqmx.errors import DaqError, DaqReadError

from drivers.ni.simulated.faults import Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq

NewTask = Callable[..., Any]


def voltage_task(new_task: NewTask, rate: float = 51_200.0, **timing: Any) -> Any:
    task = new_task()
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0:1")
    task.timing.cfg_samp_clk_timing(rate, **timing)
    return task


def test_reader_moves_the_clock(new_task: NewTask, server: SimulatedDaq) -> None:
    task = voltage_task(new_task, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    before = server.clock.now()
    for _ in range(10):
        task.read(5120)
    assert server.clock.now() - before == pytest.approx(1.0, abs=1e-6)


def test_minutes_of_continuous_reading_loses_nothing(new_task: NewTask, server: SimulatedDaq) -> None:
    task = voltage_task(new_task, 1652.0, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    total = sum(len(task.read(165_200, timeout=200.0)[0]) for _ in range(6))
    assert total == 6 * 165_200
    assert task.in_stream.total_samp_per_chan_acquired == total
    assert len(server.chassis.tasks[task.name].pieces) <= 102


def test_reader_that_falls_behind_loses_samples(new_task: NewTask, server: SimulatedDaq) -> None:
    task = voltage_task(new_task, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    task.read(512)
    server.inject(Faults(stalled_at=0.0, stalled=3.0))
    with pytest.raises(DaqError) as caught:
        task.read(512)
    assert caught.value.error_code == -200279


def test_larger_buffer_forgives_the_same_delay(new_task: NewTask, server: SimulatedDaq) -> None:
    task = voltage_task(new_task, sample_mode=AcquisitionType.CONTINUOUS)
    task.in_stream.input_buf_size = 200_000
    task.start()
    task.read(512)
    server.inject(Faults(stalled_at=0.0, stalled=3.0))
    assert len(task.read(512)[0]) == 512


def test_finite_task_is_never_overrun(new_task: NewTask, server: SimulatedDaq) -> None:
    task = voltage_task(new_task, samps_per_chan=5000)
    task.start()
    server.clock.sleep(3600.0)
    assert len(task.read(READ_ALL_AVAILABLE)[0]) == 5000
    with pytest.raises(DaqError) as caught:
        task.read(1)
    assert caught.value.error_code == -200278


def test_impatient_reader_gets_what_there_is_and_is_told(new_task: NewTask) -> None:
    task = voltage_task(new_task, samps_per_chan=51_200)
    task.start()
    with pytest.raises(DaqReadError) as caught:
        task.read(51_200, timeout=0.25)
    assert caught.value.error_code == -200284
    assert caught.value.samps_per_chan_read == 12_800
    assert len(task.read(51_200 - 12_800)[0]) == 38_400


def test_all_available_of_a_continuous_task(new_task: NewTask, server: SimulatedDaq) -> None:
    task = voltage_task(new_task, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    server.clock.sleep(0.5)
    assert task.in_stream.avail_samp_per_chan == 25_600
    assert len(task.read(READ_ALL_AVAILABLE)[0]) == 25_600


def test_record_in_pieces_is_the_record_in_one(new_task: NewTask, server: SimulatedDaq) -> None:
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(51_200.0, sample_mode=AcquisitionType.CONTINUOUS)
    period = 512
    output.write(np.sin(2.0 * np.pi * np.arange(period) / period), auto_start=True)
    server.clock.sleep(1.0)
    task = voltage_task(new_task, sample_mode=AcquisitionType.CONTINUOUS)
    task.start()
    pieces = np.concatenate([np.array(task.read(3001)) for _ in range(40)], axis=1)
    # The tone runs on over the joints: what is not the tone is the card's noise.
    time = np.arange(pieces.shape[1]) / period
    basis = np.stack([np.sin(2.0 * np.pi * time), np.cos(2.0 * np.pi * time)])
    rest = pieces - pieces @ np.linalg.pinv(basis) @ basis
    assert np.std(rest[:, 100:]) == pytest.approx(50e-6, rel=0.05)
    assert np.abs(rest[:, 100:]).max() < 6.0 * 50e-6


def test_voltage_beyond_the_range_is_refused(new_task: NewTask, server: SimulatedDaq) -> None:
    output = new_task()
    with pytest.raises(DaqError) as caught:
        output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-10.0, max_val=10.0)
    assert caught.value.error_code == -200077
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-2.0, max_val=2.0)
    with pytest.raises(DaqError) as caught:
        output.write(2.5, auto_start=True)
    assert caught.value.error_code == -200561
    assert server.output_voltage() == 0.0


def test_only_pseudodifferential_inputs(new_task: NewTask) -> None:
    task = new_task()
    with pytest.raises(DaqError) as caught:
        task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0", terminal_config=TerminalConfiguration.RSE)
    assert caught.value.error_code == -200077


def test_output_that_is_not_fed_in_time_stops(new_task: NewTask, server: SimulatedDaq) -> None:
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(2000.0, sample_mode=AcquisitionType.CONTINUOUS)
    output.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
    rate = output.timing.samp_clk_rate
    output.write(np.full(round(rate), 1.0), auto_start=False)
    output.start()
    server.clock.sleep(0.9)
    output.write(np.full(round(rate), 2.0))
    server.clock.sleep(0.9)
    assert server.output_voltage() == pytest.approx(2.0, abs=1e-6)
    server.clock.sleep(0.5)
    with pytest.raises(DaqError) as caught:
        output.write(np.full(100, 3.0))
    assert caught.value.error_code == -200290


def test_accelerometer_is_in_g_and_its_supply_couples_ac(new_task: NewTask, server: SimulatedDaq) -> None:
    task = new_task()
    task.ai_channels.add_ai_accel_chan("cDAQ1Mod1/ai1", sensitivity=100.0, min_val=-50.0, max_val=50.0)
    task.timing.cfg_samp_clk_timing(2000.0, samps_per_chan=20_480)
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.timing.cfg_samp_clk_timing(2048.0, sample_mode=AcquisitionType.CONTINUOUS)
    output.write(1.0 + 0.5 * np.sin(2.0 * np.pi * np.arange(64) / 64), auto_start=True)
    server.clock.sleep(10.0)
    recorded = np.array(task.read(READ_ALL_AVAILABLE, timeout=20.0))
    assert recorded[-2048:].mean() == pytest.approx(0.0, abs=2e-2)
    assert recorded[-2048:].std() == pytest.approx(5.0 / np.sqrt(2.0), rel=1e-3)


def test_reset_brings_outputs_down_and_frees_tasks(new_task: NewTask, server: SimulatedDaq) -> None:
    output = new_task()
    output.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.0, max_val=4.0)
    output.write(2.0, auto_start=True)
    output.devices[0].self_test_device()
    output.devices[0].reset_device()
    assert server.output_voltage() == 0.0


def test_a_name_in_use_is_attached_to_unless_a_new_task_is_asked_for(
    new_task: NewTask, server: SimulatedDaq
) -> None:
    """As NI's gRPC Device Server does."""
    new = nidaqmx.SessionInitializationBehavior.INITIALIZE_SERVER_SESSION
    options = nidaqmx.GrpcSessionOptions(InProcessChannel(server), "same", initialization_behavior=new)
    task = new_task("same")
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai0")
    with pytest.raises(DaqError) as caught:
        nidaqmx.Task("same", grpc_options=options)
    assert caught.value.error_code == -200089
    attached = new_task("same")
    assert attached.ai_channels.channel_names == ["cDAQ1Mod1/ai0"]
    attached.close()
    assert server.tasks_open() == ()
    nidaqmx.Task("same", grpc_options=options).close()
