"""The simulated hammer behind simulated cards: what was drawn is what the driver reads."""

import numpy as np
import pytest

from analysis.arrays import Real
from drivers.clock import VirtualClock
from drivers.hammer.simulated import HandSettings, SimulatedHammer, struck_surroundings
from drivers.ni.daqmx import EndlessInputs
from drivers.ni.modules import NI_9234
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq
from drivers.ni.simulated.surroundings import room
from drivers.ni.wiring import InputWiring

FORCE_VOLTS = 0.01
WIRING = InputWiring(drive_input="cDAQ1Mod1/ai0", responses=("cDAQ1Mod1/ai1",), sample_rate=5120.0)


def late(point: int, force: Real, sample_rate: float, temperature: float) -> Real:
    """Hand the force on, point + 1 times as large, 20 samples later."""
    return np.roll(0.005 * (point + 1) * force, 20)[None]


def parts(**hand: float) -> tuple[SimulatedHammer, EndlessInputs, SimulatedDaq]:
    settings = {"peak": 20.0, "spread": 0.2, "width": 1e-3, "double_hits": 0.0, "overloads": 0.0, "pause": 0.5}
    clock = VirtualClock()
    hammer = SimulatedHammer(
        late, HandSettings(**(settings | hand), ring=1.0), clock, lambda: 20.0, FORCE_VOLTS, 5.0, seed=3
    )
    server = SimulatedDaq(struck_surroundings(WIRING, hammer, {1: NI_9234}, room), clock, 3)
    return hammer, EndlessInputs(WIRING, InProcessChannel(server)), server


def read(inputs: EndlessInputs, seconds: float, block: float = 0.1) -> Real:
    count = round(block * inputs.sample_rate)
    return np.concatenate([inputs.read(count) for _ in range(round(seconds / block))], axis=1)


def test_force_and_response_are_those_drawn() -> None:
    hammer, inputs, _ = parts()
    inputs.begin()
    hammer.ask(2, 0)
    signals = read(inputs, 3.0)
    (strike,) = hammer.strikes
    height = strike.peaks[0][1]
    assert signals[0].max() / FORCE_VOLTS == pytest.approx(height, rel=0.02)
    moment = strike.time * inputs.sample_rate + 38.4  # of the module's filter, in samples
    assert np.argmax(signals[0]) == pytest.approx(moment, abs=1.0)
    assert np.argmax(signals[1]) == pytest.approx(moment + 20.0, abs=1.0)
    assert signals[1].max() == pytest.approx(3 * 0.005 * height, rel=0.02)
    inputs.close()


def test_a_hit_that_is_asked_for_does_not_change_what_was_read_before() -> None:
    hammer, inputs, _ = parts()
    inputs.begin()
    hammer.ask(0, 0)
    one = read(inputs, 3.0)
    inputs.close()
    hammer, inputs, _ = parts()
    inputs.begin()
    hammer.ask(0, 0)
    before = read(inputs, 2.0)
    hammer.ask(1, 1)  # in the middle of a second whose samples were computed already
    assert np.array_equal(before, one[:, : before.shape[1]])
    assert np.array_equal(read(inputs, 0.3), one[:, before.shape[1] :][:, : round(0.3 * inputs.sample_rate)])
    inputs.close()


def test_draws_depend_on_the_number_alone() -> None:
    first, second = parts(double_hits=0.3, overloads=0.3)[0], parts(double_hits=0.3, overloads=0.3)[0]
    for number in (5, 3, 4):
        first.ask(0, number)
        first.clock.sleep(5.0)
    for number in (4, 5):
        second.clock.sleep(1.0)
        second.ask(0, number)
        second.clock.sleep(5.0)
    drawn = {strike.number: (strike.drawn, strike.peaks, strike.width) for strike in first.strikes}
    assert {s.number: (s.drawn, s.peaks, s.width) for s in second.strikes}.items() <= drawn.items()


def test_shares_are_those_asked_for() -> None:
    hammer = parts(double_hits=0.25, overloads=0.1)[0]
    for number in range(2000):
        hammer.ask(0, number)
        hammer.clock.sleep(5.0)
    kinds = [strike.drawn for strike in hammer.strikes]
    assert kinds.count("double hit") / 2000 == pytest.approx(0.25, abs=0.03)  # three standard deviations
    assert kinds.count("overload") / 2000 == pytest.approx(0.1, abs=0.02)
    for strike in hammer.strikes:
        if strike.drawn == "overload":
            assert strike.peaks[0][1] * FORCE_VOLTS > 1.2 * 5.0
        if strike.drawn == "double hit":
            assert strike.peaks[1][1] >= 0.2 * strike.peaks[0][1]
