"""Whatever ends a sweep, the output is at 0 V afterwards; where it cannot be, that is said."""

import signal
from collections.abc import Callable
from typing import Any

import nidaqmx
import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.ni.cards import Action, DaqError
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.simulated.faults import FailingCall, Faults
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring

LOUD = np.full(8000, 3.0)
LOST = (-201003, -88705, -88709, -88710, -50405, -200324)


@pytest.fixture
def interrupted(wiring: Wiring, surroundings: Surroundings) -> Callable[[str, Callable[[], None]], Any]:
    """Cards whose server does something just before its first answer to a call once a sweep is running."""

    def build(call: str, what: Callable[[], None]) -> tuple[DaqmxCards, SimulatedDaq, list[float]]:
        found: list[float] = []
        started: list[int] = []

        class Interrupting(SimulatedDaq):
            def notice(self, name: str) -> Any:
                if name == call and not found and started and self.calls["StartTask"] >= started[0] + 2:
                    found.append(self.output_voltage())
                    what()
                return super().notice(name)

        server = Interrupting(surroundings)
        cards = DaqmxCards(wiring, InProcessChannel(server), block=0.1)
        started.append(server.calls["StartTask"])
        return cards, server, found

    return build


def press() -> None:
    signal.raise_signal(signal.SIGINT)


def fail() -> None:
    raise OSError("disk full")


@pytest.mark.parametrize("call", ["ReadAnalogF64", "WaitUntilTaskDone", "StopTask", "ClearTask"])
def test_after_an_exception(interrupted: Any, call: str) -> None:
    cards, server, found = interrupted(call, fail)
    with pytest.raises(OSError, match="disk full"):
        cards.sweep(np.append(LOUD, np.full(500, 0.5)))
    assert found
    assert server.output_voltage() == 0.0
    if call != "ClearTask":
        assert server.tasks_open() == ()


@pytest.mark.parametrize("call", ["ReadAnalogF64", "WaitUntilTaskDone", "GetSystemInfoAttributeUInt32"])
def test_after_ctrl_c(interrupted: Any, call: str) -> None:
    cards, server, found = interrupted(call, press)
    with pytest.raises(KeyboardInterrupt):
        cards.sweep(LOUD)
    # The last is a call of the task that brings the output to rest.
    assert found == [pytest.approx(3.0 if call == "ReadAnalogF64" else 0.0, abs=1e-6)]
    assert server.output_voltage() == 0.0
    assert server.tasks_open() == ()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_ends_the_sweep_at_the_next_block(interrupted: Any) -> None:
    cards, server, _ = interrupted("ReadAnalogF64", press)
    before = server.calls["ReadAnalogF64"]
    with pytest.raises(KeyboardInterrupt):
        cards.sweep(LOUD)
    assert server.calls["ReadAnalogF64"] - before < LOUD.size / (0.1 * cards.sample_rate) / 2


def test_after_a_request_to_end(interrupted: Any) -> None:
    cards, server, found = interrupted("ReadAnalogF64", lambda: signal.raise_signal(signal.SIGTERM))
    with pytest.raises(SystemExit):
        cards.sweep(LOUD)
    assert found
    assert server.output_voltage() == 0.0


def test_after_ctrl_c_while_the_output_is_being_brought_down(wiring: Wiring, surroundings: Surroundings) -> None:
    pressed: list[int] = []
    readings: list[int] = []

    class Impatient(SimulatedDaq):
        def notice(self, name: str) -> Any:
            # The sweep has failed at its third block: a task made after that plays zeros.
            if len(readings) > 3 and not pressed and name == "CreateTask":
                pressed.append(1)
                press()
            if name == "ReadAnalogF64":
                readings.append(1)
            return super().notice(name)

    server = Impatient(surroundings)
    cards = DaqmxCards(wiring, InProcessChannel(server), block=0.1)
    server.inject(Faults(calls=(FailingCall("ReadAnalogF64", -200279, first=3),)))
    with pytest.raises(KeyboardInterrupt) as caught:
        cards.sweep(LOUD)
    assert pressed
    assert isinstance(caught.value.__context__, DaqError)
    assert server.output_voltage() == 0.0


@pytest.mark.parametrize("code", LOST)
@pytest.mark.parametrize("after", [0.0, 0.31, 0.93])
def test_device_lost_in_the_middle(
    wiring: Wiring, cards: DaqmxCards, server: SimulatedDaq, code: int, after: float
) -> None:
    now = server.clock.now()
    server.inject(Faults(unplugged=(now + after, now + 60.0), unplugged_code=code))
    with pytest.raises(DaqError) as caught:
        cards.sweep(LOUD)
    assert caught.value.action is Action.LOST_DEVICE
    # Nobody can reach the output now: the error must say so, and the next opening must see to it.
    assert "turn the amplifier off" in caught.value.__notes__[-1]
    with pytest.raises(DaqError) as again:
        cards.sweep(LOUD)
    assert again.value.action is Action.LOST_DEVICE
    server.clock.sleep(60.0)
    if after:
        assert server.output_voltage() == pytest.approx(3.0, abs=1e-6)
    back = DaqmxCards(wiring, InProcessChannel(server))
    assert server.output_voltage() == 0.0
    assert back.sweep(LOUD).drive.size == LOUD.size


def test_zeros_that_cannot_be_played_are_written(cards: DaqmxCards, server: SimulatedDaq) -> None:
    server.chassis.lines["cDAQ1Mod2/ao0"].hold(2.5, server.clock.now())
    server.inject(Faults(calls=(FailingCall("CfgSampClkTiming", -200452),)))
    cards.zero()
    assert server.output_voltage() == 0.0


def test_output_that_cannot_be_brought_down_is_an_error_that_names_it(
    cards: DaqmxCards, server: SimulatedDaq
) -> None:
    server.inject(Faults(calls=(FailingCall("WriteAnalogF64", -200018, times=99),)))
    with pytest.raises(DaqError, match="cDAQ1Mod2/ao0 may hold a voltage"):
        cards.zero()


def test_voltage_left_by_another_program_is_taken_away_on_opening(
    wiring: Wiring, channel: InProcessChannel, server: SimulatedDaq
) -> None:
    with nidaqmx.Task(grpc_options=nidaqmx.GrpcSessionOptions(channel, "")) as other:
        other.ao_channels.add_ao_voltage_chan("cDAQ1Mod2/ao0", min_val=-4.24, max_val=4.24)
        other.write(1.25, auto_start=True)
    assert server.output_voltage() == pytest.approx(1.25, abs=1e-6)
    DaqmxCards(wiring, channel)
    assert server.output_voltage() == 0.0


def test_voltage_is_taken_away_even_when_the_inputs_are_wrong(
    wiring: Wiring, channel: InProcessChannel, server: SimulatedDaq
) -> None:
    server.chassis.lines["cDAQ1Mod2/ao0"].hold(2.5, server.clock.now())
    with pytest.raises(DaqError):
        DaqmxCards(wiring.model_copy(update={"drive_input": "cDAQ1Mod1/ai9"}), channel)
    assert server.output_voltage() == 0.0


def test_closing_leaves_the_output_at_rest(wiring: Wiring, server: SimulatedDaq) -> None:
    with DaqmxCards(wiring, InProcessChannel(server)):
        server.chassis.lines["cDAQ1Mod2/ao0"].hold(2.5, server.clock.now())
    assert server.output_voltage() == 0.0


def test_after_a_sweep_that_ends_well(cards: DaqmxCards, server: SimulatedDaq, drive: NDArray[np.float64]) -> None:
    cards.sweep(np.append(drive, 2.0))
    assert server.output_voltage() == 0.0
    assert server.tasks_open() == ()
