"""Causes whose truth is known, described without their names: where, by which law, on what they depend."""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from analysis.effect_card import Values
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.description.describing import Description
from analysis.gap.fitting.fit import fit_gap
from analysis.gap.report import GapReport
from analysis.recordings.frf import Frf
from analysis.twin_model import HeldEffects
from app.blind_trial.effect_size import EffectSize
from app.blind_trial.specimen import Specimen
from app.files.declarations.experiment import AcquiredExperiment
from app.stages.comparison.compared import Compared
from app.stages.gap import description
from simulation.reduction.effect_operators import EffectOperators
from simulation.tolerances import tolerances

SHARE = 0.01
"""Noise of a line over the response."""


class Bench:
    """A campaign of the small plate, with anything hidden in it."""

    def __init__(self, yard: EffectSize, operators: EffectOperators) -> None:
        self.yard = yard
        twin = yard.specimen.twin
        known = tolerances(yard.specimen.declared, operators.movable)
        self.twin = replace(twin, tolerances=known)

    def described(self, hidden: Mapping[str, Values]) -> Description:
        yard = self.yard
        signal = yard.signal(hidden)
        seen = [
            replace(c, coefficients=c.coefficients + s)
            for c, s in zip(yard.sweeps.compressed, signal, strict=True)
        ]
        sweeps: GapSweeps = replace(yard.sweeps, compressed=tuple(seen))
        model = HeldEffects.around(self.twin)
        fit = fit_gap(model, sweeps, yard.state, (), yard.executor)
        compared = Compared(yard.specimen.declared, UNUSED, self.twin, model, sweeps, fit)
        found, notes = description(compared, UNKNOWN, yard.executor, lambda stage, share: None)
        assert notes == ()
        assert found is not None
        return found


UNUSED: Frf = None  # type: ignore[assignment]


class Unknown:
    """All that is asked of a report here."""

    verdict = "unknown"


UNKNOWN: GapReport = Unknown()  # type: ignore[assignment]


@pytest.fixture(scope="module")
def bench(experiment: AcquiredExperiment, operators: EffectOperators) -> Iterator[Bench]:
    with ThreadPoolExecutor(1) as executor:
        specimen = Specimen.of([experiment], operators)
        yard = EffectSize.of(specimen, specimen.twin, SHARE, np.random.default_rng(2), executor)
        yield Bench(yard, operators)


def near(found: Description, x: float, y: float) -> float:
    """Distance of the nearest place named from the true one, m."""
    assert found.best.place is not None
    places = [tuple(one.value for one in found.best.place), *found.best.also]
    return min(float(np.hypot(a - x, b - y)) for a, b in places)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "name", "amplitude", "value"),
    [
        (
            {"resonator_at_place": {"mass": 1e-3, "x": 0.07, "y": 0.12, "resonance": 170.0, "loss": 0.1}},
            "resonator",
            "resonance",
            170.0,
        ),
        (
            {"spring_at_place": {"stiffness": 800.0, "x": 0.07, "y": 0.12, "loss": 0.05}},
            "spring",
            "stiffness",
            800.0,
        ),
    ],
    ids=["resonator", "spring"],
)
def test_a_load_at_a_place_is_described(
    bench: Bench, hidden: Mapping[str, Values], name: str, amplitude: str, value: float
) -> None:
    found = bench.described(hidden)
    assert found.best.name == name
    assert near(found, 0.07, 0.12) < 0.015
    known = {one.name: one for one in found.best.parameters}
    assert known[amplitude].value == pytest.approx(value, rel=0.05)
    assert found.best.share > 0.95
    assert {one.on for one in found.dependence} >= {"temperature", "ramp", "time"}
    assert all(one.constant for one in found.dependence)


@pytest.mark.slow
def test_a_loss_factor_that_changes_with_frequency_is_a_curve(bench: Bench) -> None:
    found = bench.described({"damping_dispersion": {"p": 0.3}})
    assert found.best.name == "modulus"
    curve = found.best.curve
    assert curve is not None
    true = (curve.frequency / 500.0) ** 0.3
    ratio = (1.0 + curve.value[1]) / true
    np.testing.assert_allclose(ratio / ratio.mean(), 1.0, atol=0.03)
    np.testing.assert_allclose(curve.value[0] - curve.value[0].mean(), 0.0, atol=0.01)
