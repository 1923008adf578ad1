import math

import numpy as np
import pytest

from drivers.clock import VirtualClock
from drivers.ovens.simulated.regulated_oven import Chamber, RegulatedOven, Regulator


def make(clock, **changes):
    return RegulatedOven(clock, np.random.default_rng(1), air=20.0, plate=20.0, **changes)


def followed(oven, clock, seconds, every=5.0):
    """Air and plate every few seconds."""
    trace = []
    for _ in range(int(seconds / every)):
        clock.sleep(every)
        trace.append((oven.air, oven.plate))
    return np.array(trace)


def test_follows_a_ramp_overshoots_a_little_and_settles():
    clock = VirtualClock()
    oven = make(clock)
    oven.go(60.0, 0.4)
    ramp = followed(oven, clock, 90 * 60.0)
    wanted = 20.0 + 0.4 / 60.0 * 5.0 * np.arange(1, len(ramp) + 1)
    assert np.abs(ramp[100:, 0] - wanted[100:]).max() < 0.3
    after = followed(oven, clock, 3600.0)
    assert oven.working == 60.0
    assert abs(after[-1, 0] - 60.0) < 0.05
    # the plate is behind by rate times its time constant, C/G = 150 s
    assert wanted[-1] - ramp[-1, 1] == pytest.approx(0.4 / 60.0 * 150.0, rel=0.2)


def test_step_overshoots_and_power_stays_within_its_means():
    clock = VirtualClock()
    oven = make(clock, regulator=Regulator(noise=0.0))
    oven.go(40.0, math.inf)
    outputs, airs = [], []
    for _ in range(3600):
        clock.sleep(1.0)
        outputs.append(oven.output)
        airs.append(oven.air)
    assert max(outputs) == 1.0
    assert min(outputs) >= -1.0
    assert 0.1 < max(airs) - 40.0 < 5.0
    assert airs[-1] == pytest.approx(40.0, abs=0.01)


def test_a_ramp_beyond_its_power_is_as_fast_as_the_power_allows():
    clock = VirtualClock()
    chamber = Chamber(heating=700.0, room=20.0)
    oven = make(clock, chamber=chamber, regulator=Regulator(noise=0.0))
    oven.go(60.0, 30.0)
    clock.sleep(300.0)
    # 700 W on 20 kJ/K for 300 s, less what walls and plate take
    assert 7.0 < oven.air - 20.0 < 10.5
    assert oven.output == 1.0


def test_does_not_depend_on_how_often_it_is_looked_at():
    ends = []
    for every in (1.0, 7.0, 600.0):
        clock = VirtualClock()
        oven = make(clock)
        oven.go(30.0, 2.0)
        while clock.now() < 4200.0:
            clock.sleep(every)
            _ = oven.air
        ends.append((oven.air, oven.plate, oven.measured))
    assert ends[0] == ends[1] == ends[2]


def test_noise_is_the_sensors_not_the_airs():
    clock = VirtualClock()
    oven = make(clock, regulator=Regulator(noise=0.5), chamber=Chamber(room=20.0))
    readings = []
    for _ in range(2000):
        clock.sleep(1.0)
        readings.append(oven.measured)
        assert oven.air == pytest.approx(20.0, abs=1e-9)
    assert np.std(readings) == pytest.approx(0.5, rel=0.1)


def test_at_rest_it_drifts_to_the_room():
    clock = VirtualClock()
    oven = make(clock)
    oven.go(50.0, math.inf)
    clock.sleep(1800.0)
    assert oven.air == pytest.approx(50.0, abs=0.5)
    oven.stop()
    assert oven.output == 0.0
    clock.sleep(20_000.0)
    assert oven.air == pytest.approx(Chamber().room, abs=0.01)
    assert oven.working == pytest.approx(oven.air, abs=0.2)


def test_stops_by_itself_at_the_time_given_not_when_looked_at():
    clock = VirtualClock()
    looked_late, looked_at_once = make(clock), make(clock)
    for oven in (looked_late, looked_at_once):
        oven.go(60.0, math.inf)
        oven.stop_at = 100.0
    clock.sleep(100.0)
    looked_at_once.stop()
    clock.sleep(900.0)
    assert looked_late.air == looked_at_once.air
    assert not looked_late.regulating
