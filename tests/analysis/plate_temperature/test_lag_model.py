"""The model finds the time constant, the offset and the error of readings that were made with them."""

import itertools

import numpy as np
import pytest

from analysis.arrays import Real
from analysis.plate_temperature import sensor_check
from analysis.plate_temperature.sensor_check import FAULTS, INDEPENDENT, NOISE, PRIOR, LagModel

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


def log_evidence(model: LagModel) -> float:
    """Return ln of the evidence of all time constants together."""
    evidence = model._evidence[model._inside]
    return float(np.log(np.exp(evidence - evidence.max()).sum()) + evidence.max())


@pytest.mark.parametrize("share", [0.0, 0.05, 0.5])
def test_evidence_of_an_error_is_that_of_two_filters(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """One with a, g and d, one without: Savage's ratio needs the first only."""
    rng, air = np.random.default_rng(3), air_of_a_campaign()[:100]
    plate = plate_in(air, 180.0)
    readings = plate + share * (air - plate) + 0.05 * rng.standard_normal(air.size)
    free, _, _ = learnt(air, readings)
    found = free.evidence_of_error()
    without = PRIOR.copy()
    without[FAULTS] = 1e-9
    monkeypatch.setattr(sensor_check, "PRIOR", without)
    fixed, _, _ = learnt(air, readings)
    assert found == pytest.approx(log_evidence(free) - log_evidence(fixed), abs=1e-3)
    assert (found > 10.0) == (share == 0.5)


def test_evidence_of_a_sound_sensor_seldom_speaks_for_an_error_at_any_time() -> None:
    """Ville's inequality: above c at some time with a probability of at most 1 / c."""
    rng, count, ratio, exceeded = np.random.default_rng(4), 300, 20.0, 0
    seconds = INDEPENDENT * np.arange(60)
    air = np.interp(seconds, [0.0, 300.0, 600.0, 900.0], [22.0, 12.0, 12.0, 22.0])
    for _ in range(count):
        tau = float(np.exp(rng.uniform(np.log(60.0), np.log(600.0))))
        plate, largest = [air[0]], -np.inf
        for before, after in itertools.pairwise(air):
            slope, decay = (after - before) / INDEPENDENT, np.exp(-INDEPENDENT / tau)
            plate.append(after - slope * tau + decay * (plate[-1] - before + slope * tau))
        readings = np.array(plate) + 0.4 * (1.0 - np.exp(-seconds / tau)) * rng.standard_normal()
        readings[1:] += NOISE * rng.standard_normal(seconds.size - 1)
        model = LagModel(0.0, air[0], float(readings[0]))
        for now, here, reading in zip(seconds[1:], air[1:], readings[1:], strict=True):
            model.advance(now, here)
            model.learn(reading, INDEPENDENT)
            largest = max(largest, model.evidence_of_error())
        exceeded += largest > np.log(ratio)
    assert exceeded <= count / ratio + 5.0 * np.sqrt(count / ratio)
