"""The shift of resonances is that of the modulus, and contradicts readings that did not move as they did."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from analysis.arrays import Complex, Real
from analysis.plate_temperature.resonances import FrfThermometer, log_spectrum, shift, unlike_resonances
from analysis.recordings.frf import Frf

FREQUENCY = np.arange(100.0, 800.0, 0.5)
Law = Callable[[float], float]


def polymer(temperature: float) -> float:
    """Return a modulus like that of polypropylene, GPa."""
    knots = [3.30, 3.05, 2.72, 2.30, 1.90, 1.58, 1.33, 1.14, 0.99]
    return float(np.interp(temperature, np.arange(-10.0, 71.0, 10.0), knots))


def aluminium(temperature: float) -> float:
    """Return that of aluminium, GPa."""
    return 70.0 * (1.0 - 5e-4 * (temperature - 20.0))


def softening(temperature: float) -> float:
    """Return that of a polymer whose glass transition begins at 30 °C: half of it is lost over some 30 K, GPa."""
    return 3.0 * float(np.exp(-0.003 * (temperature - 20.0))) / (1.0 + float(np.exp((temperature - 55.0) / 8.0)))


def plate(
    temperature: float,
    law: Law = polymer,
    loss: float = 0.06,
    seed: int = 0,
) -> Complex:
    """Return FRFs (2, F) of twenty-five modes: all move as sqrt(E), but for 1 % that not all move alike."""
    rng = np.random.default_rng(seed)
    at_20 = np.sort(np.exp(rng.uniform(np.log(60.0), np.log(1500.0), 25)))
    residues = rng.choice([-1.0, 1.0], (2, 25)) * rng.uniform(0.3, 1.0, (2, 25))
    own = 1.0 + 0.01 * rng.uniform(-1.0, 1.0, 25) * (temperature - 20.0) / 40.0
    modes = (at_20 * np.sqrt(law(temperature) / law(20.0)) * own)[:, None]
    h = residues @ (at_20[:, None] ** 2 / (modes**2 * (1.0 + 1j * loss) - FREQUENCY**2))
    own_noise = np.random.default_rng([seed, round(1e3 * (temperature + 100.0))])
    drawn = own_noise.standard_normal((2, *h.shape))
    return np.asarray(h + 1e-3 * np.sqrt(np.mean(np.abs(h) ** 2)) * (drawn[0] + 1j * drawn[1]))


@pytest.mark.parametrize("temperature", [10.0, 15.0, 22.0, 30.0, 40.0])
@pytest.mark.parametrize(("law", "loss"), [(polymer, 0.06), (aluminium, 0.005)])
def test_the_shift_is_half_that_of_the_modulus(temperature: float, law: Law, loss: float) -> None:
    before, now = (log_spectrum(FREQUENCY, plate(at, law, loss)) for at in (20.0, temperature))
    found, alike = shift(before, now)
    assert found == pytest.approx(0.5 * np.log(law(temperature) / law(20.0)), abs=0.002)
    assert alike > 0.9


def test_no_shift_between_different_plates_or_evenly_spaced_resonances() -> None:
    one, other = (log_spectrum(FREQUENCY, plate(20.0, seed=seed)) for seed in (0, 1))
    assert not np.isfinite(shift(one, other)[0])
    even = np.cos(2.0 * np.pi * np.log(FREQUENCY) / 0.1)[None] + 2.0 + 0j
    assert not np.isfinite(shift(log_spectrum(FREQUENCY, even), log_spectrum(FREQUENCY, even))[0])


def judged(true: Real, label: Real, law: Law = polymer, loss: float = 0.06, seed: int = 0) -> list[int]:
    """Return the places of the sweeps that are doubted."""
    thermometer = FrfThermometer()
    noise = np.random.default_rng(seed).normal(0.0, 0.3, len(true))
    told = [
        thermometer.judge(0, float(read), log_spectrum(FREQUENCY, plate(float(at), law, loss, seed)))
        for at, read in zip(true, label + noise, strict=True)
    ]
    return [place for place, why in enumerate(told) if why]


UP = np.arange(-5.0, 61.0, 5.0)
DOWN = UP[::-1].copy()
WAYS = {"up": UP, "down": DOWN, "both": np.concatenate([UP, DOWN])}


@pytest.mark.parametrize("way", WAYS)
def test_a_reading_that_moves_while_the_resonances_do_not(way: str) -> None:
    """The plate stays at 45 °C and its sensor falls to 25 °C, or the reverse."""
    for lie in (-19.0, 19.0):
        true, label = WAYS[way].copy(), WAYS[way].copy()
        at = len(label) // 2 + 1
        true[at] = true[at - 1]
        label[at] = label[at - 1] + lie
        assert judged(true, label) == [at]


@pytest.mark.parametrize("way", ["up", "down"])
def test_resonances_that_move_while_the_reading_does_not(way: str) -> None:
    """The sensor stays at its value of the seventh sweep; the air triggers sweeps."""
    true, label = WAYS[way], WAYS[way].copy()
    label[6:] = label[6]
    doubted = judged(true, label)
    assert doubted
    assert min(doubted) > 6
    assert {place for place in range(14) if abs(true[place] - label[place]) >= 20.0} <= set(doubted)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize(
    ("law", "loss"), [(polymer, 0.06), (softening, 0.08), (aluminium, 0.003), (aluminium, 0.01)]
)
def test_healthy_campaigns_are_not_doubted(way: str, law: Law, loss: float) -> None:
    for seed in range(4):
        assert judged(WAYS[way], WAYS[way], law, loss, seed) == []


def test_a_metal_tells_nothing() -> None:
    label = UP.copy()
    label[8] -= 19.0
    assert judged(UP, label, aluminium, 0.005) == []


@pytest.mark.slow
def test_five_hundred_healthy_campaigns() -> None:
    """Of polymers and metals, at steps of 2.5 to 10 K, there and back, with a lag of up to 1 K each way."""
    doubted = []
    for seed in range(500):
        rng = np.random.default_rng([seed, 1])
        way = np.arange(-5.0, 61.0, float(rng.choice([2.5, 5.0, 10.0])))
        way = way[:: int(rng.choice([-1, 1]))]
        lag = rng.uniform(0.0, 1.0)
        both = np.concatenate([way, way[::-1]])
        sign = np.repeat([1.0, -1.0], way.size) * np.sign(way[1] - way[0])
        law, loss = [(polymer, 0.06), (aluminium, 0.005), (lambda t: 3.2 - 0.016 * (t - 20.0), 0.05)][seed % 3]
        if judged(both, both - lag * sign, law, loss, seed):
            doubted.append(seed)
    assert doubted == []


def recorded(true: Real, label: Real) -> Frf:
    """Return the FRFs of a campaign."""
    h = np.array([plate(float(at)) for at in true])
    return Frf(
        temperature=label,
        direction=("up",) * len(label),
        level=np.ones(len(label)),
        frequency=FREQUENCY,
        h=h,
        variance=np.full(h.shape, 1e-6),
        coherence=np.ones(h.shape),
        excluded=np.zeros(FREQUENCY.size, dtype=bool),
        channels=("a", "b"),
    )


@pytest.mark.parametrize("wrong", [1, 6, 11])
def test_recorded_sweeps_are_judged_by_those_before_and_after(wrong: int) -> None:
    label = UP.copy()
    label[wrong] += 15.0
    found = unlike_resonances(recorded(UP, label))
    assert list(found) == [wrong]
    assert f"read {label[wrong]:.1f} °C" in found[wrong]
    assert unlike_resonances(recorded(UP, UP)) == {}
    two = recorded(UP, UP)
    assert unlike_resonances(replace(two, level=np.arange(1.0, 15.0))) == {}  # no two are comparable
