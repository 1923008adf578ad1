"""Baselines and later dates of the panel in closed form, with noise."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from analysis.arrays import Complex, Real
from analysis.gap.data.compression import Nodes
from analysis.health.baseline import HealthBaseline, SelfCheck, self_check
from analysis.health.candidates import change_candidates
from analysis.health.recording import DatedRecording, ExpectedResponse, recordings_of
from analysis.health.watch import HealthWatch
from analysis.material import MaterialLaws
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, Effects
from tests.analysis.health.navier_panel import CARDS, NavierPanel

LINES = np.arange(100.0, 1000.0, 4.0)
TWIN = NavierPanel()
REAL = NavierPanel(
    actuators=((0.2003, 0.1548), (0.0448, 0.1201)), sensors=((0.0402, 0.0353), (0.1748, 0.0549)), half=0.01005
)
"""As built: patches lie a few tenths of a millimetre beside their declared places."""
NOISE = 1e-3
"""Standard deviation of a line over the root mean square of its FRF."""


def laws(shift: float = 0.0) -> MaterialLaws:
    """E from 2.6 GPa at -10 °C to 1.6 GPa at 60 °C; `shift` bends log E over T by that much."""
    t = np.array([-10.0, 13.3, 36.7, 60.0])
    bent = shift * np.cos(np.pi * (t + 10.0) / 70.0)
    coefficients = np.array(
        [
            np.log(2.6e9) - 0.007 * (t + 10.0) + bent,
            0.34 + 0.0006 * (t + 10.0),
            np.log(0.03) + 0.009 * (t + 10.0) - 3 * bent,
        ]
    )
    return MaterialLaws(np.array([-10.0] * 4 + [60.0] * 4), coefficients, np.zeros((3, 4, 4)), (-10.0, 60.0))


def measured(
    temperature: float,
    rng: np.random.Generator,
    effects: Effects = NO_EFFECTS,
    *,
    stiffer: float = 0.0,
    beyond: bool = False,
) -> Frf:
    """FRFs of the real panel at a temperature, a sweep for each input; the label is wrong by a kelvin or two."""
    law = laws().local(60.0 if beyond else temperature)
    law = replace(law, value=law.value + np.array([stiffer, 0.0, 0.0]))
    h = np.array([REAL.frf(law, LINES, effects, SweepPoint(temperature, 0.0, 1.0, s)) for s in range(2)])
    return noisy(h, temperature + float(rng.normal(0.0, 1.5)), rng)


def noisy(h: Complex, label: float, rng: np.random.Generator) -> Frf:
    sigma = NOISE * np.sqrt((np.abs(h) ** 2).mean(axis=-1, keepdims=True)) + 0.0 * np.abs(h)
    spread = rng.standard_normal(h.shape) + 1j * rng.standard_normal(h.shape)
    return Frf(
        np.full(2, label),
        ("up", "up"),
        np.ones(2),
        LINES,
        h + sigma / np.sqrt(2.0) * spread,
        sigma**2,
        np.ones(h.shape),
        np.zeros(LINES.size, dtype=bool),
        ("S1", "S2"),
        source=np.array([0, 1]),
        sources=("A1", "A2"),
    )


NODES = Nodes.over(LINES, 0.03, spacing=4.0)


def recorded(frf: Frf, date: str = "") -> list[DatedRecording]:
    return recordings_of(frf, NODES, np.zeros(LINES.size, dtype=bool), date, 2)


def baseline(temperatures: Real, shift: float, seed: int) -> HealthBaseline:
    """Baseline with a twin of other discretisation whose laws are wrong by a share."""
    rng = np.random.default_rng(seed)
    rows = []
    for t in temperatures:
        frf = measured(float(t), rng)
        rows += recorded(replace(frf, temperature=np.full(2, float(t))))
    candidates = change_candidates(CARDS, NO_EFFECTS, ("A1", "A2", "S1", "S2"))
    return HealthBaseline.of(
        TWIN, laws(shift), NO_EFFECTS, np.ones(2), rows, candidates, ("S1", "S2"), ("A1", "A2")
    )


@lru_cache
def checked_baseline() -> tuple[HealthBaseline, SelfCheck, tuple[ExpectedResponse, ...]]:
    found = baseline(np.linspace(-10.0, 60.0, 15), 0.001, 1)
    twins = [found.linearised(float(t)) for t in found.temperature]
    return found, self_check(found, twins), tuple(found.completed(one) for one in twins)


def usual_watch() -> HealthWatch:
    found, check, starts = checked_baseline()
    return HealthWatch(found, check, 1e-3, found, starts)
