"""A sweep by itself is fitted as far as a joint fit needs, and no evaluation further."""

import numpy as np
import pytest

from analysis.updating.normal_equations import SETTLED, SweepData, fit_sweep, normal_equations

TRUTH = np.array([2.1e9, 0.38, 0.06])


def asked(model, monkeypatch):
    """Materials at which a model is linearised from now on."""
    materials, linearise = [], model.linearise

    def counted(laws, *rest):
        materials.append(laws.value)
        return linearise(laws, *rest)

    monkeypatch.setattr(model, "linearise", counted)
    return materials


@pytest.mark.parametrize(("off", "most"), [(2e-3, 1), (0.02, 3), (0.1, 8)])
def test_what_a_fit_leaves_is_within_its_bound(twin, monkeypatch, off: float, most: int) -> None:
    frf = twin.measured(np.array([20.0]), [TRUTH], 14.3, np.random.default_rng(4), 0.01)
    data = SweepData.of(frf, 0, 4)
    materials = asked(twin, monkeypatch)
    fit = fit_sweep(twin, data, TRUTH * np.array([1.0 + off, 1.0, 1.0 - off]))
    assert fit.settled
    assert len(materials) <= most
    best = fit.point
    for _ in range(6):
        best = normal_equations(twin, data, best.ahead, best.gain * float(np.exp(best.full_step[3])))
    ratio, difference = np.log(fit.point.ahead / best.material), fit.point.ahead - best.material
    away = np.array([ratio[0], difference[1], ratio[2]])
    covariance = np.linalg.inv(best.matrix)[:3, :3]
    assert away @ np.linalg.solve(covariance, away) < SETTLED


def test_a_fit_that_settles_is_at_a_minimum(affine_modes) -> None:
    """Far from sharp resonances chi2 hardly changes with the material: a small decrease is no minimum."""
    truth, moves, count = np.array([2.1e9, 0.38, 0.012]), [], 0
    for seed in range(2):
        twin = affine_modes(np.random.default_rng(seed))
        frf = twin.measured(np.array([20.0]), [truth], 14.3, np.random.default_rng(4), 0.01)
        data = SweepData.of(frf, 0, 3)
        for off in np.linspace(-0.3, 0.3, 13):
            fit, count = fit_sweep(twin, data, truth * np.array([1.0 + off, 1.05, 1.7])), count + 1
            if fit.settled:
                best = fit.point
                for _ in range(6):
                    best = normal_equations(twin, data, best.ahead, best.gain * float(np.exp(best.full_step[3])))
                moves.append(abs(np.log(fit.material[0] / best.material[0])))
    assert 5 < len(moves) < count
    assert max(moves) < 0.1 * truth[2]


@pytest.mark.parametrize("truth", [(2.1e9, 0.38, 0.004), (2.1e9, 0.2, 0.06), (2.1e9, 0.38, 0.3)])
def test_a_fit_at_the_wall_of_the_box_says_what_it_has_reached(twin, truth: tuple[float, float, float]) -> None:
    frf = twin.measured(np.array([20.0]), [truth], 14.3, np.random.default_rng(4), 0.01)
    data = SweepData.of(frf, 0, 4)
    fit = fit_sweep(twin, data, np.array(truth))
    assert not fit.settled
    there = normal_equations(twin, data, twin.box.clip(fit.material), float(np.exp(fit.log_gain)))
    assert fit.misfit == pytest.approx(there.misfit, rel=1e-9)
