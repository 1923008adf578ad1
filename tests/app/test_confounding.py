"""Effects that no sensor layout tells apart are one class, with the experiment that would separate them."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from analysis.gap.data.preparation import prepare
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.fitting.state import plain_state
from analysis.gap.search.confidence import equivalents
from analysis.gap.search.observability import signal_cosine
from analysis.gap.search.score_test import score_test
from analysis.material import LocalLaws, Material
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated
from app.files.campaigns.loading import load_campaign
from app.twins.campaign_twin import effect_twin
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

pytestmark = pytest.mark.slow

TEMPERATURE = np.array([5.0, 20.0, 35.0, 50.0])
FREQUENCY = np.arange(100.0, 1500.0, 2.0)
GAIN = 12.0


def laws(temperature: float) -> np.ndarray:
    step = temperature - 25.0
    softening = 0.018 * step + 0.1 * np.tanh((temperature - 10.0) / 12.0)
    return np.array([np.log(2e9) - softening, 0.37 + 0.0012 * step, np.log(0.06) + 0.004 * step])


def local(temperature: float) -> LocalLaws:
    slope = laws(temperature + 0.5) - laws(temperature - 0.5)
    return LocalLaws(temperature, laws(temperature), slope, np.zeros(3))


@pytest.fixture(scope="module")
def twin() -> Twin[EffectPlate]:
    example = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"
    made = effect_twin(load_campaign(example).experiment, lambda stage, share: None)
    return made.referred(local(25.0))


@pytest.mark.parametrize(
    ("effect", "values", "alike", "separated_by"),
    [
        ("viscoelastic_dispersion", {"kappa": 0.5}, "air_loading", "vacuum"),
        ("thickness_taper", {"tx": 0.01, "ty": 0.005}, "draught_gradient", "thermocouples"),
    ],
)
def test_look_alikes_are_one_class(
    twin: Twin[EffectPlate], effect: str, values: dict[str, float], alike: str, separated_by: str
) -> None:
    rng = np.random.default_rng(0)
    point = [SweepPoint(float(t), 0.4 / 60.0, 1.0) for t in TEMPERATURE]
    clean = GAIN * np.array([twin.frf(local(p.temperature), FREQUENCY, {effect: values}, p) for p in point])
    variance = np.full(clean.shape, 1e-4 * (np.abs(clean) ** 2).mean())
    error = rng.standard_normal((2, *clean.shape)) * np.sqrt(variance / 2.0)
    zeros, count = np.zeros(len(TEMPERATURE)), len(TEMPERATURE)
    frf = Frf(
        temperature=TEMPERATURE,
        direction=("up",) * count,
        level=np.ones(count),
        frequency=FREQUENCY,
        h=clean + error[0] + 1j * error[1],
        variance=variance,
        coherence=np.ones(clean.shape),
        excluded=np.zeros(FREQUENCY.size, dtype=bool),
        channels=("S1",),
    )
    truth = np.array([laws(t) for t in TEMPERATURE])
    material = Material(np.exp(truth[:, 0]), truth[:, 1], np.exp(truth[:, 2]))
    done = np.ones(count, dtype=bool)
    unity = np.zeros((count, 4, 4))
    updated = Updated(TEMPERATURE, material, material, unity, GAIN, 0.0, zeros, zeros, zeros, zeros, done)
    sweeps, _ = prepare(frf, twin.experiment.protocol, updated)
    start = plain_state(sweeps.groups, truth, np.log([GAIN]), {effect: values})
    with ThreadPoolExecutor(2) as executor:
        fit = fit_gap(twin, sweeps, start, (effect,), executor)
        seen = score_test(twin, sweeps, fit, executor, effects=(alike, "orthotropy"))
    cosines = {other: signal_cosine(seen, effect, other) for other in (alike, "orthotropy")}
    # beside the tolerances of the declaration, dispersion and air load are alike to 0.94: a class by evidence only
    by_signal = () if alike == "air_loading" else (alike,)
    assert cosines[alike] > 0.93
    assert cosines["orthotropy"] < 0.5
    assert equivalents(dict.fromkeys(cosines, -1000.0), cosines) == by_signal
    assert equivalents({alike: -1.0, "orthotropy": -1000.0}, cosines) == (alike,)
    assert separated_by in twin.cards[effect].separated_by
