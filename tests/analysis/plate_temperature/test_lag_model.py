"""The model finds the time constant, the offset and the error of readings that were made with them."""

import itertools

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.plate_temperature.lag_model import LagModel

STEP = 5.0


def air_of_a_campaign() -> Real:
    """Room, way to 49 °C, soak, ramp down to 11 °C: what the oven's air does, every 5 s."""
    corners = np.array([0.0, 540.0, 2340.0, 4620.0])
    return np.interp(np.arange(0.0, 4620.0, STEP), corners, [22.0, 49.0, 49.0, 11.0])


def plate_in(air: Real, tau: float) -> Real:
    """Plate in this air, by steps of 10 ms."""
    fine, plate, found = 500, air[0], [air[0]]
    for before, after in itertools.pairwise(air):
        for moment in range(fine):
            here = before + (after - before) * (moment + 0.5) / fine
            plate += (here - plate) * (STEP / fine) / tau
        found.append(plate)
    return np.array(found)


def learnt(air: Real, readings: Real) -> tuple[LagModel, Real, list[tuple[Real, Real, float]]]:
    """Return the model after all readings, its predictions and moments."""
    model, predicted, moments = LagModel(0.0, air[0], readings[0]), [readings[0]], []
    for number in range(1, len(air)):
        model.advance(number * STEP, air[number])
        predicted.append(model.prediction()[0])
        model.learn(readings[number], STEP)
        moments.append(model.moment())
    return model, np.array(predicted), moments


@pytest.mark.parametrize("tau", [60.0, 180.0, 600.0])
def test_time_constant_and_offset_are_found_within_their_sigma(tau: float) -> None:
    rng, air = np.random.default_rng(1), air_of_a_campaign()
    readings = plate_in(air, tau) + 0.4 + 0.05 * rng.standard_normal(air.size)
    model, predicted, moments = learnt(air, readings)
    found, sigma = model.tau
    assert abs(np.log(found / tau)) < 4.0 * sigma
    assert sigma < 0.05
    offset, sigma_offset = model.offset()
    assert offset == pytest.approx(0.4, abs=4.0 * sigma_offset)
    assert np.abs(predicted - readings)[100:].max() < 0.3  # noise of 0.05 K
    error, sigma_error = model.error(moments[-1])
    assert abs(error) < 3.0 * sigma_error


@pytest.mark.parametrize(
    ("cause", "change"),
    [
        ("scale", lambda plate, air, seconds: plate + 0.05 * (plate - 22.0)),
        ("air", lambda plate, air, seconds: plate + 0.5 * (air - plate)),
        ("drift", lambda plate, air, seconds: plate + 3.0 / 3600.0 * seconds),
    ],
)
def test_error_of_every_label_is_found_with_its_cause(cause: str, change: object) -> None:
    assert callable(change)
    rng, air = np.random.default_rng(2), air_of_a_campaign()
    plate, seconds = plate_in(air, 180.0), STEP * np.arange(air.size)
    wrong = change(plate, air, seconds)
    model, _, moments = learnt(air, wrong + 0.05 * rng.standard_normal(air.size))
    estimated = np.array([model.error(moment)[0] for moment in moments])
    true = (wrong - plate)[1:]
    assert np.abs(estimated - true).max() < 0.3
    worst = int(np.abs(true).argmax())
    parts = model.parts(moments[worst])
    assert max(parts, key=lambda name: abs(parts[name])) == cause
    assert sum(parts.values()) == pytest.approx(model.error(moments[worst])[0], rel=1e-6)


def test_air_that_turns_at_once_makes_the_prediction_less_sure() -> None:
    model = LagModel(0.0, 40.0, 40.0)
    for number in range(1, 200):
        model.advance(number * STEP, 40.0)
        model.learn(40.0, STEP)
    before = model.prediction()[1]
    model.advance(1000.0, 28.0)
    assert model.prediction()[1] > before + 0.05
