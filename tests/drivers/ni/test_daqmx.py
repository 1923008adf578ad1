"""The cards' driver against the simulated server: what is measured is what is there."""

import gc
import time
import tracemalloc
from dataclasses import replace
from typing import Any

import nidaqmx
import numpy as np
import pytest
from nidaqmx.constants import TaskMode
from nidaqmx.stream_writers import AnalogSingleChannelWriter

from analysis.arrays import Real
from drivers.clock import SystemClock
from drivers.ni.cards import KNOWN_ERRORS, Action, DaqError, KnownError
from drivers.ni.connection import set_up_inputs, set_up_output
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.modules import NI_9234, NI_9263
from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq, serving
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring

RATE = 51_200.0 / 6.0


def ratios(drive: Real, responses: Real, band: tuple[float, float]) -> tuple[Real, Real]:
    """Frequencies (F,) within the band and the ratio of each response's spectrum to the drive's (K, F).

    The record begins and ends in silence, so no window is needed.
    """
    frequency = np.fft.rfftfreq(drive.size, 1.0 / RATE)
    inside = (frequency > band[0]) & (frequency < band[1])
    return frequency[inside], (np.fft.rfft(responses) / np.fft.rfft(drive))[:, inside]


def test_rate_is_read_back_not_taken_for_granted(cards: DaqmxCards) -> None:
    assert cards.sample_rate == pytest.approx(8533.333333, rel=1e-9)


@pytest.mark.parametrize(("routes", "drift"), [(True, 0.0), (False, 1.2)])
def test_output_runs_on_the_inputs_timebase_where_the_chassis_routes_it(
    wiring: Wiring, surroundings: Surroundings, drive: Real, routes: bool, drift: float
) -> None:
    """Crystals 100 ppm apart: 1.2 samples at the end of a record of 12,000."""
    chassis = replace(surroundings, clock_errors=(-5e-5, 5e-5), routes_timebases=routes)
    played = np.zeros(12_100)
    played[[100, 12_000]] = 2.0
    record = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(chassis))).sweep(played)
    # where a pulse is: the phase of its spectrum, whose middle is at its top
    first, last = (record.drive[n : n + 200] for n in (50, 11_900))
    slope = np.polyfit(np.arange(1, 40), np.unwrap(np.angle(np.fft.rfft(last) / np.fft.rfft(first)))[1:40], 1)[0]
    assert -slope * 200 / (2.0 * np.pi) == pytest.approx(50.0 - drift, abs=0.02)


def test_rates_that_differ_are_refused_on_opening(wiring: Wiring, surroundings: Surroundings) -> None:
    """An NI 9263 divides 80 MHz: unless it is given the inputs' timebase, it makes 51.216 kHz of 51.2 kHz."""
    other = replace(surroundings, modules=surroundings.modules | {2: NI_9263})
    fast = wiring.model_copy(update={"sample_rate": 51_200.0})
    DaqmxCards(fast, InProcessChannel(SimulatedDaq(other))).sweep(np.zeros(100))
    alone = replace(other, routes_timebases=False)
    with pytest.raises(DaqError, match=r"would run at 51216.4 Hz, the inputs run at 51200 Hz") as caught:
        DaqmxCards(fast, InProcessChannel(SimulatedDaq(alone)))
    assert "cards.sample_rate" in str(caught.value)
    slow = wiring.model_copy(update={"sample_rate": 51_200.0 / 6.0})
    DaqmxCards(slow, InProcessChannel(SimulatedDaq(alone))).sweep(np.zeros(100))


def test_ratio_to_the_recorded_drive_is_the_plate(cards: DaqmxCards, drive: Real, plate: Any) -> None:
    record = cards.sweep(drive)
    frequency, measured = ratios(record.drive, record.responses, (150.0, 1300.0))
    error = np.abs(measured - plate.response(frequency, RATE))
    # 50 uV of noise against a drive whose spectrum is worth about 0.8 V per line
    assert float(np.sqrt(np.mean(error**2))) < 2e-4
    assert float(error.max()) < 1e-3


def test_ratio_to_the_drive_asked_for_is_late_by_the_filter(cards: DaqmxCards, drive: Real) -> None:
    """The reason why the drive is recorded: 38.4 samples and 3.2 us are missing from the array played."""
    record = cards.sweep(drive)
    frequency, measured = ratios(drive, record.responses[1:], (150.0, 1300.0))
    phase = np.unwrap(np.angle(-measured[0]))
    slope = np.polyfit(2.0 * np.pi * frequency, phase, 1)[0]
    assert -slope == pytest.approx(38.4 / RATE + 3.2e-6, rel=1e-4)


@pytest.mark.parametrize("block", [0.05, 0.5, 100.0])
def test_samples_do_not_depend_on_how_they_are_read(
    wiring: Wiring, surroundings: Surroundings, drive: Real, block: float
) -> None:
    def measured(length: float) -> Real:
        cards = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(surroundings, seed=3)), block=length)
        return cards.sweep(drive).responses

    assert np.array_equal(measured(block), measured(1.0))


def test_network_and_process_give_the_same_numbers(
    wiring: Wiring, surroundings: Surroundings, drive: Real
) -> None:
    inside = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(surroundings, seed=3)))
    with (
        serving(SimulatedDaq(surroundings, seed=3)) as address,
        DaqmxCards(wiring.model_copy(update={"grpc": address})) as outside,
    ):
        assert outside.sample_rate == inside.sample_rate
        for _ in range(2):
            here, there = inside.sweep(drive), outside.sweep(drive)
            assert np.array_equal(here.drive, there.drive)
            assert np.array_equal(here.responses, there.responses)
        assert np.array_equal(inside.temperatures(), outside.temperatures())


def test_noise_differs_from_sweep_to_sweep_and_with_the_seed(
    cards: DaqmxCards, surroundings: Surroundings, wiring: Wiring, drive: Real
) -> None:
    first, second = cards.sweep(drive).drive, cards.sweep(drive).drive
    noise = (first - second) / np.sqrt(2.0)
    assert float(np.std(noise)) == pytest.approx(NI_9234.noise, rel=0.05)
    other = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(surroundings, seed=8))).sweep(drive).drive
    assert not np.array_equal(first, other)


def test_message_of_more_than_four_mebibytes_passes(wiring: Wiring, surroundings: Surroundings) -> None:
    drive = np.zeros(600_000)
    drive[:1000] = 1.0
    fast = wiring.model_copy(update={"sample_rate": 51_200.0})
    with (
        serving(SimulatedDaq(surroundings)) as address,
        DaqmxCards(fast.model_copy(update={"grpc": address}), block=60.0) as cards,
    ):
        assert cards.sweep(drive).responses.shape == (2, 600_000)


def test_plate_is_asked_once_a_sweep_and_knows_its_temperature(
    wiring: Wiring, surroundings: Surroundings, plate: Any, drive: Real
) -> None:
    warming = replace(surroundings, plate_temperature=lambda moments: 20.0 + 0.4 / 60.0 * moments)
    server = SimulatedDaq(warming)
    cards = DaqmxCards(wiring, InProcessChannel(server))
    server.clock.sleep(600.0)
    began = server.clock.now()
    cards.sweep(drive)
    assert plate.seen == [(drive.size, pytest.approx(RATE))]  # the rehearsal plays zeros
    assert plate.temperature[0] == pytest.approx(20.0 + 0.4 / 60.0 * began)
    assert plate.temperature[-1] - plate.temperature[0] == pytest.approx(0.4 / 60.0 * (drive.size - 1) / RATE)


def test_thermocouples_are_read_in_their_order_and_take_their_time(
    wiring: Wiring, surroundings: Surroundings
) -> None:
    touched = {
        "cDAQ1Mod3/ai0": lambda moments: np.full(moments.shape, 37.5),
        "cDAQ1Mod3/ai1": lambda moments: np.full(moments.shape, -12.0),
    }
    server = SimulatedDaq(replace(surroundings, thermocouples=touched))
    both = wiring.model_copy(update={"thermocouples": ("cDAQ1Mod3/ai1", "cDAQ1Mod3/ai0")})
    cards = DaqmxCards(both, InProcessChannel(server))
    before = server.clock.now()
    assert cards.temperatures() == pytest.approx([-12.0, 37.5], abs=0.1)
    assert server.clock.now() - before == pytest.approx(2.0 / 14.0)


def test_rig_without_thermocouples_has_no_temperatures(wiring: Wiring, channel: InProcessChannel) -> None:
    assert DaqmxCards(wiring.model_copy(update={"thermocouples": ()}), channel).temperatures().size == 0


def test_clipping_is_seen_on_the_channel_that_clips(
    wiring: Wiring, surroundings: Surroundings, drive: Real
) -> None:
    def loud(volts: Real, rate: float, temperature: Real) -> Real:
        return np.stack([volts, 4.0 * volts])

    cards = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(replace(surroundings, plate=loud))))
    record = cards.sweep(drive)
    assert record.overloaded.tolist() == [False, False, True]
    assert record.responses[1].max() == pytest.approx(5.0 - NI_9234.quantum, abs=1e-12)
    assert record.responses[1].min() == pytest.approx(-5.0, abs=1e-12)


def test_every_sample_is_a_code_of_the_converter(cards: DaqmxCards, drive: Real) -> None:
    codes = cards.sweep(drive).responses / NI_9234.quantum
    assert np.array_equal(codes, np.round(codes))


@pytest.mark.parametrize("configuration", ["DEFAULT", "PSEUDO_DIFF"])
def test_inputs_are_wired_as_declared(wiring: Wiring, channel: InProcessChannel, configuration: str) -> None:
    declared = wiring.model_copy(update={"terminal_configuration": configuration, "coupling": "DEFAULT"})
    assert DaqmxCards(declared, channel).sample_rate == pytest.approx(51_200.0 / 6.0)


def test_a_wiring_that_the_module_does_not_have_is_refused(wiring: Wiring, channel: InProcessChannel) -> None:
    declared = wiring.model_copy(update={"terminal_configuration": "RSE"})
    with pytest.raises(DaqError, match="TermCfg") as caught:
        DaqmxCards(declared, channel)
    assert caught.value.action is Action.STOP


@pytest.mark.parametrize(("coupling", "gain"), [("DC", 1.0), ("AC", np.sqrt(0.5))])
def test_coupling_takes_the_slow_part_away(
    wiring: Wiring, channel: InProcessChannel, coupling: str, gain: float
) -> None:
    slow = wiring.model_copy(update={"coupling": coupling, "sample_rate": 2000.0})
    cards = DaqmxCards(slow, channel)
    moments = np.arange(round(12.0 * cards.sample_rate)) / cards.sample_rate
    record = cards.sweep(2.0 * np.sin(2.0 * np.pi * 0.5 * moments))
    settled = moments > 4.0
    level = 2.0 * np.abs(np.mean(record.drive[settled] * np.exp(-2j * np.pi * 0.5 * moments[settled])))
    assert level == pytest.approx(2.0 * gain, rel=2e-3)


@pytest.mark.parametrize("known", KNOWN_ERRORS, ids=lambda known: known.name)
@pytest.mark.parametrize("call", ["StartTask", "ReadAnalogF64", "WaitUntilTaskDone"])
def test_every_status_comes_out_as_its_action_with_the_output_at_rest(
    cards: DaqmxCards, server: SimulatedDaq, drive: Real, known: KnownError, call: str
) -> None:
    server.inject(Faults(calls=(FailingCall(call, known.code),)))
    with pytest.raises(DaqError, match=r"the sweep of 1\.5 s failed") as caught:
        cards.sweep(drive)
    # A name that was good when the cards were opened and is not now belongs to a device that has gone.
    expected = Action.LOST_DEVICE if known.action is Action.LIST_EXISTING else known.action
    assert caught.value.action is expected
    assert caught.value.code == known.code
    assert server.output_voltage() == 0.0
    assert server.tasks_open() == ()
    assert cards.sweep(drive).drive.size == drive.size


@pytest.mark.parametrize(
    ("change", "status", "action", "told"),
    [
        ({"output": "cDAQ1Mod7/ao0"}, -200220, Action.LIST_EXISTING, "cDAQ1Mod2/ao0"),
        ({"drive_input": "cDAQ1Mod1/ai9"}, -200170, Action.LIST_EXISTING, "cDAQ1Mod1/ai0"),
        ({"thermocouples": ("cDAQ2Mod1/ai0",)}, -200220, Action.LIST_EXISTING, "cDAQ1Mod3/ai3"),
        ({"sample_rate": 60_000.0}, -200077, Action.STOP, "60000"),
        ({"input_range": 10.0}, -200077, Action.STOP, "NI-9234"),
        ({"output_range": 10.0}, -200077, Action.STOP, "4.24"),
        ({"thermocouples": ("cDAQ1Mod1/ai3",)}, -200077, Action.STOP, "thermocouple"),
    ],
)
def test_wiring_that_does_not_fit_is_refused_on_opening(
    wiring: Wiring,
    channel: InProcessChannel,
    server: SimulatedDaq,
    change: dict[str, object],
    status: int,
    action: Action,
    told: str,
) -> None:
    with pytest.raises(DaqError) as caught:
        DaqmxCards(wiring.model_copy(update=change), channel)
    assert (caught.value.code, caught.value.action) == (status, action)
    assert told in str(caught.value)
    assert server.tasks_open() == ()


def test_card_taken_by_another_program_is_named_with_its_holder(
    cards: DaqmxCards, channel: InProcessChannel, drive: Real
) -> None:
    with nidaqmx.Task("test panel", grpc_options=nidaqmx.GrpcSessionOptions(channel, "")) as other:
        other.ai_channels.add_ai_voltage_chan("cDAQ1Mod1/ai3")
        other.timing.cfg_samp_clk_timing(1000.0)
        other.control(TaskMode.TASK_RESERVE)
        with pytest.raises(DaqError, match="cDAQ1Mod1 is reserved by task test panel") as caught:
            cards.sweep(drive)
    assert caught.value.action is Action.RESERVED
    cards.sweep(drive)


def killed_in_a_sweep(wiring: Wiring, channel: InProcessChannel, drive: Real) -> None:
    """Begin a sweep, and leave its tasks as a process does that is killed: nothing is stopped or cleared."""
    cards = DaqmxCards(wiring, channel, block=0.1)
    connection = cards._connection  # nothing but a kill leaves tasks behind
    inputs = connection._new_task("inputs", wiring.inputs[0])
    output = connection._new_task("output", wiring.output)
    set_up_inputs(inputs, wiring, drive.size)
    set_up_output(output, wiring, cards.sample_rate, drive.size)
    AnalogSingleChannelWriter(output.out_stream, auto_start=False).write_many_sample(drive)
    output.start()
    inputs.start()


def test_what_a_killed_process_left_on_a_server_is_cleared(
    wiring: Wiring, server: SimulatedDaq, channel: InProcessChannel, drive: Real
) -> None:
    """A server keeps the tasks of a process that is gone: they held the modules, and the output its voltage."""
    killed_in_a_sweep(wiring, channel, drive)
    assert len(server.tasks_open()) == 2
    with DaqmxCards(wiring, channel) as cards:
        assert server.output_voltage() == 0.0
        assert cards.sweep(drive).drive.size == drive.size
    assert server.tasks_open() == ()


def test_tasks_of_another_computer_are_left_alone(
    wiring: Wiring, channel: InProcessChannel, drive: Real, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("socket.gethostname", lambda: "other-laboratory.example")
    killed_in_a_sweep(wiring, channel, drive)
    monkeypatch.setattr("socket.gethostname", lambda: "here")
    with pytest.raises(
        DaqError, match="reserved by task flexura_output_cDAQ1Mod2_other_laboratory_example"
    ) as caught:
        DaqmxCards(wiring, channel)
    assert caught.value.action is Action.RESERVED
    assert "restart the NI gRPC Device Server" in caught.value.next_step


def test_larger_output_module_reaches_further(wiring: Wiring, surroundings: Surroundings) -> None:
    other = replace(surroundings, modules=surroundings.modules | {2: NI_9263})
    cards = DaqmxCards(wiring.model_copy(update={"output_range": 10.0}), InProcessChannel(SimulatedDaq(other)))
    drive = np.zeros(2000)
    drive[:1000] = 8.0
    record = cards.sweep(drive)
    assert record.overloaded[0]
    assert not record.overloaded[2]
    assert record.responses[1, 900] == pytest.approx(-4.0, abs=1e-3)


@pytest.mark.parametrize(
    "drive", [np.zeros(1), np.zeros((2, 10)), np.full(10, np.nan), np.full(10, 4.3), np.full(10, -5.0)]
)
def test_drive_that_cannot_be_played_is_refused(cards: DaqmxCards, server: SimulatedDaq, drive: Real) -> None:
    calls = server.calls.total()
    with pytest.raises(ValueError, match=r"allowed|allows"):
        cards.sweep(drive)
    assert server.calls.total() == calls


def test_broken_cable_reads_noise_only(cards: DaqmxCards, server: SimulatedDaq, drive: Real) -> None:
    server.inject(Faults(dead_inputs=frozenset({"cDAQ1Mod1/ai2"})))
    record = cards.sweep(drive)
    assert float(np.std(record.responses[1])) == pytest.approx(NI_9234.noise, rel=0.05)
    assert float(np.std(record.responses[0])) > 0.1


def test_trigger_that_does_not_come_is_found_out(cards: DaqmxCards, server: SimulatedDaq, drive: Real) -> None:
    server.inject(Faults(stuck_trigger=True))
    with pytest.raises(DaqError) as caught:
        cards.sweep(drive)
    assert caught.value.code == -200560
    assert caught.value.action is Action.RETRY_ONCE


@pytest.mark.slow
def test_long_campaign_leaves_nothing_behind(cards: DaqmxCards, server: SimulatedDaq) -> None:
    drive = np.zeros(4000)
    drive[:2000] = 1.0

    def kept_after(sweeps: int) -> int:
        for _ in range(sweeps):
            cards.sweep(drive)
            server.clock.sleep(300.0)
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    tracemalloc.start()
    try:
        first = kept_after(3)
        grown = kept_after(10) - first
    finally:
        tracemalloc.stop()
    assert grown < 3 * drive.nbytes  # ten sweeps keep less than what one records
    assert server.tasks_open() == ()


def test_real_time_can_be_kept_as_well(wiring: Wiring, surroundings: Surroundings) -> None:
    cards = DaqmxCards(wiring, InProcessChannel(SimulatedDaq(surroundings, clock=SystemClock())))
    before = time.monotonic()
    cards.sweep(np.full(2000, 0.5))
    assert time.monotonic() - before >= 2000 / RATE
