"""Sizes in sigma: nothing for what the baseline can do itself, the plain norm for what it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.gap.thresholds import MODEL_ERROR, MODEL_ERROR_ALONG
from app.blind_trial.draw_effects import answered, of_size
from app.blind_trial.effect_size import EffectSize
from app.blind_trial.plates import PlateKind
from app.files.declarations.experiment import AcquiredExperiment
from simulation.reduction.effect_operators import EffectOperators
from simulation.tolerances import tolerances
from simulation.twin.effect_plate import EffectPlate


def white(yard: EffectSize, signal: np.ndarray) -> float:
    """Norm of a signal in sigma, with nothing taken out of it."""
    seen = [s.whitened(row) for s, row in zip(yard.sweeps.compressed, signal, strict=True)]
    return float(np.linalg.norm(np.array(seen)))


def test_another_gain_is_no_signal_at_all(yard: EffectSize):
    one = np.array([s.coefficients for s in yard.sweeps.compressed])
    assert white(yard, 0.05 * one) > 100.0
    noise = np.sqrt(2.0 * yard.sweeps.numbers)  # the coefficients are those of a noisy campaign
    assert yard.size(0.05 * one) < 0.05 * 2.0 * noise + 0.5


def test_a_feedthrough_keeps_nearly_all_of_its_size(yard: EffectSize):
    signal = yard.signal({"feedthrough": {"gain": 2e-4}})
    kept = yard.size(signal) * yard.sigma / white(yard, signal)
    assert 0.5 < kept <= 1.0


def test_what_a_tolerance_can_do_has_no_size(yard: EffectSize, operators: EffectOperators):
    """A plate longer by 0.2 mm is some sigma of noise, and one standard deviation of what is declared."""
    twin = yard.specimen.twin
    judging = replace(twin, tolerances=tolerances(yard.specimen.declared, operators.movable))
    other = EffectSize.of(yard.specimen, judging, 0.02, np.random.default_rng(0), yard.executor)
    (place,) = [k for k, (name, _) in enumerate(other.declared.names) if name == "plate_length_x"]
    laws = yard.sweeps.smoothness.laws(yard.state.laws)
    tangent = (*other.declared.names[place], judging.tolerance_cards["plate_length_x"].zero())
    moved = []
    for sweep, point in enumerate(yard.sweeps.points):
        here = laws[yard.sweeps.groups.of_sweep[sweep]]
        line = judging.linearise(here, yard.sweeps.nodes.frequency, {}, point, [tangent])
        moved.append(np.exp(yard.state.log_gain[0]) * line.by_parameter[0])
    signal = other.declared.sigma[place] * yard.sweeps.nodes.coefficients(np.array(moved))
    assert yard.size(signal) > 3.0
    assert other.size(signal) < 1.0
    feedthrough = yard.signal({"feedthrough": {"gain": 2e-4}})
    assert 0.3 * yard.size(feedthrough) < other.size(feedthrough) <= yard.size(feedthrough)


def test_a_less_accurate_twin_makes_the_same_signal_smaller(
    yard: EffectSize, experiment: AcquiredExperiment, kind: PlateKind, operators: EffectOperators
):
    """As the gap workflow counts it: the estimated error of the twin that judges is part of sigma."""
    rough = replace(operators, plain_error=operators.plain_error + 3e-3)
    loss_factor = float(yard.specimen.laws.at(yard.sweeps.groups.reference).loss_factor.min())
    signal = yard.signal({"feedthrough": {"gain": 2e-4}})
    judging = replace(yard.specimen.twin, plate=EffectPlate(rough))
    other = EffectSize.of(yard.specimen, judging, 0.02, np.random.default_rng(0), yard.executor)
    assert other.sweeps.twin_error == pytest.approx(
        np.hypot(rough.numerical_error(loss_factor), MODEL_ERROR), rel=1e-2
    )
    expected = np.sqrt(1.0 + MODEL_ERROR_ALONG**2 * other.sweeps.twin_error**2 * yard.sweeps.power)
    assert other.sigma == pytest.approx(expected)
    assert other.size(signal) * other.sigma == pytest.approx(yard.size(signal) * yard.sigma, rel=1e-9)


def test_sizes_grow_with_the_signal_and_cosines_do_not(yard: EffectSize):
    mass, skew = (yard.signal(e) for e in ({"point_mass": {"mass": 2e-5}}, {"channel_skew": {"delay": 1e-6}}))
    assert yard.size(3.0 * mass) == pytest.approx(3.0 * yard.size(mass), rel=1e-6)
    assert yard.cosine(mass, mass) == pytest.approx(1.0, rel=1e-6)
    assert yard.cosine(mass, -2.0 * mass) == pytest.approx(-1.0, rel=1e-6)
    assert yard.cosine(3.0 * mass, skew) == pytest.approx(yard.cosine(mass, skew), abs=1e-6)


def test_an_effect_is_brought_to_size_and_imitates_itself(yard: EffectSize):
    values = of_size(yard, "orthotropy", 20.0, np.random.default_rng(2))
    signal = yard.signal({"orthotropy": values})
    assert yard.left(signal) == pytest.approx(20.0, rel=0.05)
    found = yard.imitations(signal)
    assert found["orthotropy"] == pytest.approx(1.0, abs=0.01)
    assert max(found, key=lambda name: found[name]) == "orthotropy"


def test_what_is_physically_impossible_is_not_hidden(yard: EffectSize):
    """No filter hides a million sigma: its corner ends at nine tenths of the range."""
    values = of_size(yard, "high_pass", 1e6, np.random.default_rng(2))
    assert values == {"corner": pytest.approx(90.0)}


def test_what_no_operator_answers_for_is_not_hidden_either(yard: EffectSize):
    """A bond of 0.9 that softens further is within its card, and beyond what was certified."""
    values = of_size(yard, "bond_shear_lag", 1e6, np.random.default_rng(2))
    assert 0.1 < values["gamma25"] < 0.9
    assert answered(yard, {"bond_shear_lag": values}) is not None
    assert answered(yard, {"bond_shear_lag": {**values, "gamma25": 1.0}}) is None
