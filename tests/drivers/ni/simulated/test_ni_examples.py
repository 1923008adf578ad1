"""The calls that National Instruments' public examples of analog input and output make, each by its name.

Each function makes the calls of the example it is named after (ni/nidaqmx-python, folder ``examples``) in their
order, with the simulated chassis' names of devices. Those that wait for the Enter key wait here for some samples.
"""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from nidaqmx import GrpcSessionOptions, Task
from nidaqmx.constants import (
    READ_ALL_AVAILABLE,
    WAIT_INFINITELY,
    AcquisitionType,
    LoggingMode,
    LoggingOperation,
    ProductCategory,
    RegenerationMode,
    TemperatureUnits,
    ThermocoupleType,
)
from nidaqmx.errors import DaqError
from nidaqmx.system import System

from drivers.ni.modules import NI_9211, NI_9215, NI_9234, NI_9260, NI_9263
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings

NewTask = Callable[..., Any]
FINITE, CONTINUOUS = AcquisitionType.FINITE, AcquisitionType.CONTINUOUS
AI, AO, TC = "cDAQ1Mod4/ai0", "cDAQ1Mod5/ao0", "cDAQ1Mod3/ai0"
SINE = np.sin(2.0 * np.pi * 10.0 * np.arange(1000) / 1000.0)


@pytest.fixture
def new_task(server: SimulatedDaq) -> Iterator[NewTask]:
    """Close what was made: an event that nobody takes back keeps a thread."""
    session = GrpcSessionOptions(InProcessChannel(server), "")
    with ExitStack() as tasks:
        yield lambda: tasks.enter_context(Task(grpc_options=session))


@pytest.fixture
def surroundings(plate: Any) -> Surroundings:
    modules = {1: NI_9234, 2: NI_9260, 3: NI_9211, 4: NI_9215, 5: NI_9263}
    return Surroundings(plate, {"cDAQ1Mod1/ai1": 0}, frozenset({AI}), output=AO, modules=modules)


def counting(task: Any, every: int, times: int) -> tuple[Callable[..., int], Callable[[], int]]:
    """Return a callback that reads, and a function that waits for so many calls and tells the samples read."""
    read: list[int] = []
    enough = threading.Event()

    def callback(handle: object, kind: int, count: int, data: object) -> int:
        if len(read) < times:
            read.append(len(task.read(number_of_samples_per_channel=every)))
        if len(read) >= times:
            enough.set()
        return 0

    def waited() -> int:
        assert enough.wait(60.0)
        return sum(read)

    return callback, waited


def ai_voltage(task: Any, samples: int = 50, mode: AcquisitionType = FINITE, **clock: Any) -> None:
    task.ai_channels.add_ai_voltage_chan(AI)
    task.timing.cfg_samp_clk_timing(1000.0, sample_mode=mode, samps_per_chan=samples, **clock)


def test_voltage_sample(new_task: NewTask) -> None:
    task = new_task()
    task.ai_channels.add_ai_voltage_chan(AI)
    assert abs(task.read()) < 5e-3


@pytest.mark.parametrize("raw", [False, True], ids=["ai_voltage_sw_timed", "ai_raw"])
def test_one_and_many_channels_on_demand(new_task: NewTask, raw: bool) -> None:
    task = new_task()
    task.ai_channels.add_ai_voltage_chan(AI)
    read = task.in_stream.read if raw else task.read
    assert np.size(read(number_of_samples_per_channel=1)) == 1
    assert np.size(read(number_of_samples_per_channel=8)) == 8
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod4/ai1:3")
    assert np.size(read(number_of_samples_per_channel=1)) == 4
    assert np.size(read(number_of_samples_per_channel=8)) == 32


def test_raw_codes_are_volts_over_the_quantum(new_task: NewTask) -> None:
    output, task = new_task(), new_task()
    output.ao_channels.add_ao_voltage_chan(AO)
    output.write(2.5)
    task.ai_channels.add_ai_voltage_chan(AI)
    codes = task.in_stream.read(number_of_samples_per_channel=100)
    assert codes.dtype == np.int16
    assert np.mean(codes) * NI_9215.quantum == pytest.approx(2.5, abs=1e-3)


def test_voltage_acq_int_clk(new_task: NewTask) -> None:
    task = new_task()
    ai_voltage(task)
    assert len(task.read(READ_ALL_AVAILABLE)) == 50


def test_ai_voltage_acq_int_clk_and_waveform_finite_acq(new_task: NewTask) -> None:
    task = new_task()
    ai_voltage(task, 1000)
    task.start()
    assert isinstance(task.read(), float)
    task.stop()


def test_ai_voltage_hw_timed(new_task: NewTask) -> None:
    """A task that is started again records anew, on channels that have joined it as well."""
    task = new_task()
    task.ai_channels.add_ai_voltage_chan(AI)
    task.timing.cfg_samp_clk_timing(1000.0)
    runs = []
    for _ in range(2):
        runs.append(task.read(number_of_samples_per_channel=100))
        task.wait_until_done()
        task.stop()
    assert runs[0] != runs[1]
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod4/ai1:3")
    data = np.array(task.read(number_of_samples_per_channel=100))
    task.wait_until_done()
    task.stop()
    assert data.shape == (4, 100)
    assert np.all(np.std(data, axis=1) > 0.0)


def test_voltage_acq_int_clk_plot_data(new_task: NewTask) -> None:
    task = new_task()
    task.ai_channels.add_ai_voltage_chan("cDAQ1Mod4/ai0:1")
    task.timing.cfg_samp_clk_timing(1000.0, sample_mode=FINITE, samps_per_chan=50)
    assert np.shape(task.read(READ_ALL_AVAILABLE)) == (2, 50)


@pytest.mark.parametrize("count", [READ_ALL_AVAILABLE, 50], ids=["voltage_acq_int_clk_wfm", "plot_wfm"])
def test_waveforms(new_task: NewTask, count: int) -> None:
    task = new_task()
    ai_voltage(task)
    waveform = task.read_waveform(count)
    assert waveform.sample_count == 50
    assert (waveform.channel_name, waveform.units) == (AI, "Volts")
    assert waveform.timing.sample_interval.total_seconds() == pytest.approx(1e-3)
    assert waveform.timing.start_time is not None


def test_ai_voltage_acq_ext_clk(new_task: NewTask) -> None:
    task = new_task()
    ai_voltage(task, 1000, source="/cDAQ1/PFI0")
    task.start()
    assert isinstance(task.read(), float)


def test_cont_voltage_acq_int_clk(new_task: NewTask) -> None:
    task = new_task()
    ai_voltage(task, 1000, CONTINUOUS)
    task.start()
    assert [len(task.read(number_of_samples_per_channel=1000)) for _ in range(3)] == [1000] * 3
    task.stop()


@pytest.mark.parametrize("trigger", [None, "/cDAQ1/PFI0"], ids=["every_n_samples_event", "dig_start"])
def test_cont_voltage_acq_int_clk_with_events(new_task: NewTask, trigger: str | None) -> None:
    task = new_task()
    ai_voltage(task, 1000, CONTINUOUS)
    if trigger:
        task.triggers.start_trigger.cfg_dig_edge_start_trig(trigger)
    callback, waited = counting(task, 1000, 2)
    task.register_every_n_samples_acquired_into_buffer_event(1000, callback)
    task.start()
    assert waited() == 2000
    task.stop()


@pytest.mark.parametrize("stops", [True, False], ids=["every_n_samples_event", "without_stop"])
def test_a_task_ends_after_its_callback(channel: InProcessChannel, stops: bool) -> None:
    """At virtual speed a callback is under way whenever the Enter key comes; it still finds its task."""
    failures: list[Exception] = []
    began = threading.Event()

    def callback(*_: object) -> int:
        began.set()
        time.sleep(0.01)
        try:
            task.read(number_of_samples_per_channel=1000)
        except DaqError as error:
            failures.append(error)
        return 0

    for _ in range(5):
        with Task(grpc_options=GrpcSessionOptions(channel, "")) as task:
            ai_voltage(task, 1000, CONTINUOUS)
            task.register_every_n_samples_acquired_into_buffer_event(1000, callback)
            task.start()
            assert began.wait(60.0)
            if stops:
                task.stop()
        began.clear()
    assert not failures


@pytest.mark.parametrize("start", [None, "/cDAQ1/PFI0"], ids=["dig_ref", "dig_start_ref"])
def test_voltage_acq_int_clk_with_a_reference_trigger(
    new_task: NewTask, server: SimulatedDaq, start: str | None
) -> None:
    """A pulse comes every 0.1 s: half of the record lies before one."""
    output = new_task()
    output.ao_channels.add_ao_voltage_chan(AO)
    output.write(1.0)
    task = new_task()
    ai_voltage(task, 100)
    if start:
        task.triggers.start_trigger.cfg_dig_edge_start_trig(start)
    task.triggers.reference_trigger.cfg_dig_edge_ref_trig("/cDAQ1/PFI1", pretrigger_samples=50)
    task.start()
    assert np.mean(task.read(READ_ALL_AVAILABLE)) == pytest.approx(1.0, abs=2e-3)
    assert (server.clock.now() - 0.05) % 0.1 == pytest.approx(0.0, abs=1e-6)


def test_thrmcpl_sample(new_task: NewTask) -> None:
    task = new_task()
    task.ai_channels.add_ai_thrmcpl_chan(TC, units=TemperatureUnits.DEG_C, thermocouple_type=ThermocoupleType.K)
    assert task.read() == pytest.approx(20.0, abs=0.2)


def test_cont_thrmcpl_samples_int_clk(new_task: NewTask) -> None:
    """At 1000 Hz the module, which converts 14 times a second, gives every conversion some seventy times."""
    task = new_task()
    task.ai_channels.add_ai_thrmcpl_chan(TC, units=TemperatureUnits.DEG_C, thermocouple_type=ThermocoupleType.K)
    task.timing.cfg_samp_clk_timing(1000.0, sample_mode=CONTINUOUS)
    task.start()
    data = np.array([task.read(number_of_samples_per_channel=1000) for _ in range(2)])
    assert data == pytest.approx(20.0, abs=0.2)
    assert np.unique(data[0]).size in (14, 15)


@pytest.mark.parametrize("name", ["gen_voltage_sample", "voltage_update", "ao_voltage_sw_timed"])
def test_single_values(new_task: NewTask, server: SimulatedDaq, name: str) -> None:
    task = new_task()
    task.ao_channels.add_ao_voltage_chan(AO)
    assert task.write(1.1) == 1
    task.stop()
    assert server.output_voltage() == pytest.approx(1.1, abs=1e-3)


@pytest.mark.parametrize("source", ["", "/cDAQ1/PFI0"], ids=["gen_voltage_wfm_int_clk", "ao_voltage_gen_ext_clk"])
def test_finite_generation(new_task: NewTask, server: SimulatedDaq, source: str) -> None:
    task = new_task()
    task.ao_channels.add_ao_voltage_chan(AO)
    task.timing.cfg_samp_clk_timing(1000.0, source=source, sample_mode=FINITE, samps_per_chan=1000)
    assert task.write(np.linspace(0.0, 1.1, 1000), auto_start=True) == 1000
    task.wait_until_done()
    task.stop()
    assert server.output_voltage() == pytest.approx(1.1, abs=1e-3)


@pytest.mark.parametrize("events", [False, True], ids=["cont_gen_voltage_wfm_int_clk", "every_n_samples_event"])
def test_continuous_generation(new_task: NewTask, server: SimulatedDaq, events: bool) -> None:
    task, transferred = new_task(), threading.Event()

    def callback(*_: object) -> int:
        transferred.set()
        return 0

    task.ao_channels.add_ao_voltage_chan(AO)
    task.timing.cfg_samp_clk_timing(1000.0, sample_mode=CONTINUOUS)
    if events:
        task.register_every_n_samples_transferred_from_buffer_event(1000, callback)
    task.write(SINE)
    task.start()
    assert not events or transferred.wait(60.0)
    task.stop()


def test_cont_gen_voltage_wfm_int_clk_non_regen(new_task: NewTask, server: SimulatedDaq) -> None:
    """The writer is held back until there is room: it writes at the pace at which the card plays."""
    task = new_task()
    task.ao_channels.add_ao_voltage_chan(AO)
    task.out_stream.regen_mode = RegenerationMode.DONT_ALLOW_REGENERATION
    task.timing.cfg_samp_clk_timing(1000.0, sample_mode=CONTINUOUS)
    for number in range(30):
        task.write(SINE)
        if not number:
            task.start()
    assert 15.0 < server.clock.now() < 30.0
    task.stop()


def terminal_with_device(task: Any, terminal: str) -> str:
    """Return a terminal's full name the way NI's examples find it: modules have none of their own."""
    modules = (ProductCategory.C_SERIES_MODULE, ProductCategory.SCXI_MODULE)
    (chassis,) = [device.name for device in task.devices if device.product_category not in modules]
    return f"/{chassis}/{terminal}"


@pytest.mark.parametrize("prefixed", [False, True], ids=["short", "with_dev_prefix"])
def test_ai_ao_sync(new_task: NewTask, prefixed: bool) -> None:
    inputs, output = new_task(), new_task()
    ai_voltage(inputs, 1000, CONTINUOUS)
    trigger = terminal_with_device(inputs, "ai/StartTrigger") if prefixed else "ai/StartTrigger"
    callback, waited = counting(inputs, 1000, 2)
    inputs.register_every_n_samples_acquired_into_buffer_event(1000, callback)
    output.ao_channels.add_ao_voltage_chan(AO)
    output.timing.cfg_samp_clk_timing(1000.0, sample_mode=CONTINUOUS)
    output.triggers.start_trigger.cfg_dig_edge_start_trig(trigger)
    assert output.timing.samp_clk_rate == 1000.0
    output.write(SINE)
    output.start()
    inputs.start()
    assert waited() == 2000
    inputs.stop()
    output.stop()


def test_ao_voltage_hw_timed(new_task: NewTask, server: SimulatedDaq) -> None:
    """Channels that join a task find nothing of the others' in its buffer."""
    task = new_task()
    task.ao_channels.add_ao_voltage_chan(AO)
    task.timing.cfg_samp_clk_timing(1000.0)
    assert task.write([1.1, 2.2, 3.3, 4.4, 5.5], auto_start=True) == 5
    task.wait_until_done()
    task.stop()
    task.ao_channels.add_ao_voltage_chan("cDAQ1Mod5/ao1:3")
    levels = [[1.1, 2.2, 3.3], [1.1, 2.2, 4.4], [2.2, 3.3, 4.4], [2.2, 3.3, 4.4]]
    assert task.write(levels, auto_start=True) == 3
    task.wait_until_done()
    task.stop()
    assert server.output_voltage() == pytest.approx(
        1.1, abs=1e-3
    )  # the thousandth sample of three again and again


def test_ranges_as_playrec_asks_for_them(channel: InProcessChannel) -> None:
    devices = System(GrpcSessionOptions(channel, "")).devices
    assert devices[AO].ao_voltage_rngs == [-10.0, 10.0]
    assert devices["cDAQ1Mod2"].ao_voltage_rngs == [-4.24, 4.24]
    assert devices["cDAQ1Mod1"].ai_voltage_rngs == [-5.0, 5.0]
    assert (devices["cDAQ1"].ai_voltage_rngs, devices["cDAQ1Mod3"].ai_voltage_rngs) == ([], [])
    with pytest.raises(DaqError, match="DEVICE_ATTRIBUTE_AI_CURRENT_RNGS"):
        _ = devices["cDAQ1"].ai_current_rngs


def test_playrec(new_task: NewTask) -> None:
    reader, writer = new_task(), new_task()
    writer.ao_channels.add_ao_voltage_chan(AO, min_val=-10.0, max_val=10.0)
    for number in range(3):
        reader.ai_channels.add_ai_voltage_chan(f"cDAQ1Mod4/ai{number}")
    for task in (reader, writer):
        task.timing.cfg_samp_clk_timing(96_000, source="OnboardClock", samps_per_chan=5000)
    writer.triggers.start_trigger.cfg_dig_edge_start_trig(reader.triggers.start_trigger.term)
    played = np.random.default_rng(1).normal(size=5000) * 0.01
    writer.write(played, auto_start=False)
    writer.start()
    recorded = np.array(reader.read(5000, timeout=WAIT_INFINITELY))
    assert recorded.shape == (3, 5000)
    assert np.std(recorded[0]) == pytest.approx(np.std(played), rel=0.1)


def test_a_channel_may_begin_with_a_slash(new_task: NewTask) -> None:
    """As in ai_multi_task_pxie_ref_clk."""
    task = new_task()
    assert task.ai_channels.add_ai_voltage_chan(f"/{AI}").physical_channel.name == AI


def test_channel_properties(new_task: NewTask) -> None:
    task = new_task()
    channel = task.ai_channels.add_ai_voltage_chan(AI, max_val=0.1, min_val=-0.1)
    assert (channel.ai_max, channel.ai_min) == (10.0, -10.0)  # the module has one range
    channel.ai_max = 5
    others = task.ai_channels.add_ai_voltage_chan("cDAQ1Mod4/ai1:3", max_val=10, min_val=-10)
    assert (others.ai_max, others.ai_min) == (10.0, -10.0)
    assert task.ai_channels["cDAQ1Mod4/ai2"].physical_channel.name == "cDAQ1Mod4/ai2"


def test_system_properties(channel: InProcessChannel) -> None:
    system = System(GrpcSessionOptions(channel, ""))
    assert system.driver_version.major_version == 24
    listed = {device.name: (device.product_category.name, device.product_type) for device in system.devices}
    assert listed["cDAQ1"] == ("COMPACT_DAQ_CHASSIS", "cDAQ-9178")
    assert listed["cDAQ1Mod4"] == ("C_SERIES_MODULE", "NI 9215")


def retrigger(task: Any) -> None:
    ai_voltage(task, 1000)
    task.triggers.start_trigger.cfg_dig_edge_start_trig("/cDAQ1/PFI0")
    task.triggers.start_trigger.retriggerable = True


def log_to_tdms(task: Any) -> None:
    ai_voltage(task, 10)
    task.in_stream.configure_logging(
        "TestData.tdms", LoggingMode.LOG_AND_READ, operation=LoggingOperation.CREATE_OR_REPLACE
    )


def reference_clock(task: Any) -> None:
    task.ai_channels.add_ai_voltage_chan(AI)
    task.timing.ref_clk_src = "PXIe_Clk100"


@pytest.mark.parametrize(
    ("example", "lacking"),
    [
        (retrigger, "START_TRIG_RETRIGGERABLE"),
        (log_to_tdms, "ConfigureLogging"),
        (reference_clock, "REF_CLK_SRC"),
    ],
)
def test_what_is_not_simulated_is_named(
    new_task: NewTask, server: SimulatedDaq, example: Callable[[Any], None], lacking: str
) -> None:
    with pytest.raises(DaqError, match="Not simulated by Flexura's cards") as caught:
        example(new_task())
    assert lacking in str(caught.value)
    assert "Upgrade" not in str(caught.value)
    assert any(lacking in one for one in server.lacking)
