"""The heat balance against closed forms and against itself."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drivers.ovens.simulated.regulated_oven import Chamber, Heat

CHAMBER = Chamber()


def closed_form(chamber, power, seconds, air=0.0, plate=0.0):
    """Both temperatures above the room's, from the two real roots of the characteristic polynomial."""
    a, p = chamber.air_capacity, chamber.plate_capacity
    w, g = chamber.wall_conductance, chamber.plate_conductance
    trace, determinant = (w + g) / a + g / p, w * g / (a * p)
    root = math.sqrt(trace**2 - 4.0 * determinant)
    slow, fast = (-trace + root) / 2.0, (-trace - root) / 2.0
    final = power / w
    # the plate satisfies x'' + trace x' + determinant x = determinant * final
    x0, v0 = plate - final, g / p * (air - plate)
    c_slow = (v0 - fast * x0) / (slow - fast)
    c_fast = x0 - c_slow
    e_slow, e_fast = c_slow * math.exp(slow * seconds), c_fast * math.exp(fast * seconds)
    plate_now = final + e_slow + e_fast
    air_now = plate_now + p / g * (slow * e_slow + fast * e_fast)
    return air_now, plate_now


@pytest.mark.parametrize("seconds", [1, 30, 600, 20_000])
@pytest.mark.parametrize("step", [0.25, 1.0])
def test_step_of_power_follows_the_closed_form(seconds, step):
    heat = Heat(CHAMBER, step, air=CHAMBER.room + 5.0, plate=CHAMBER.room - 3.0)
    for _ in range(round(seconds / step)):
        heat.advance(800.0)
    air, plate = closed_form(CHAMBER, 800.0, seconds, 5.0, -3.0)
    assert heat.air - CHAMBER.room == pytest.approx(air, abs=1e-9 * 800)
    assert heat.plate - CHAMBER.room == pytest.approx(plate, abs=1e-9 * 800)


def test_settles_where_the_walls_lose_what_comes_in():
    heat = Heat(CHAMBER, 60.0)
    for _ in range(1000):
        heat.advance(300.0)
    assert heat.air == pytest.approx(CHAMBER.room + 300.0 / CHAMBER.wall_conductance, abs=1e-6)
    assert heat.plate == pytest.approx(heat.air, abs=1e-6)


def test_energy_in_is_energy_stored_plus_energy_lost():
    rng = np.random.default_rng(3)
    powers = rng.uniform(-1500.0, 2500.0, 200)
    heat = Heat(CHAMBER, 7.0, air=15.0, plate=35.0)
    before, lost = heat.stored, 0.0
    rates = CHAMBER.rates()
    for power in powers:
        # the loss of one step, integrated by a solver that knows nothing of the matrix exponential
        start = [heat.air - CHAMBER.room, heat.plate - CHAMBER.room, 0.0]

        def slope(_, y, power=power):
            air, plate = rates @ y[:2]
            return [air + power / CHAMBER.air_capacity, plate, CHAMBER.wall_conductance * y[0]]

        lost += solve_ivp(slope, (0.0, 7.0), start, rtol=1e-10, atol=1e-8).y[2, -1]
        heat.advance(power)
    brought = 7.0 * powers.sum()
    assert heat.stored - before == pytest.approx(brought - lost, abs=1e-6 * np.abs(powers).sum() * 7.0)


def test_plate_lags_a_steady_ramp_by_its_time_constant():
    # air forced along a ramp: huge capacity, power for the rate wanted
    chamber = Chamber(air_capacity=1e9, heating=1e9, wall_conductance=1e-6)
    heat = Heat(chamber, 1.0)
    rate = 0.4 / 60.0
    for _ in range(3600):
        heat.advance(rate * 1e9)
    time_constant = chamber.plate_capacity / chamber.plate_conductance
    assert heat.air - heat.plate == pytest.approx(rate * time_constant, rel=1e-4)


def test_power_is_finite():
    strong, limited = Heat(CHAMBER, 1.0), Heat(CHAMBER, 1.0)
    for _ in range(100):
        strong.advance(1e9)
        limited.advance(CHAMBER.heating)
    assert strong.air == limited.air
    for _ in range(100):
        strong.advance(-1e9)
        limited.advance(-CHAMBER.cooling)
    assert strong.air == limited.air


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"air_capacity": 0.0}, "air_capacity"),
        ({"plate_conductance": -1.0}, "plate_conductance"),
        ({"heating": math.inf}, "heating"),
        ({"room": 500.0}, "room"),
    ],
)
def test_nonsense_is_refused(change, told):
    with pytest.raises(ValueError, match=told):
        Chamber(**change)


def test_step_must_be_positive():
    with pytest.raises(ValueError, match="step"):
        Heat(CHAMBER, 0.0)
