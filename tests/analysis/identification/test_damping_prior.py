from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from analysis.identification.automatic import identify
from analysis.identification.averaging import averaged
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import DampingPrior
from analysis.identification.pole_residue import REAL_E_F, to_parameters, to_poles
from analysis.identification.pole_search import project
from tests.synthetic_frf import crowded, r10

BAND = (2 * np.pi * 100.0, 2 * np.pi * 1500.0)


def poles_of(damping: np.ndarray) -> np.ndarray:
    place = 2 * np.pi * np.linspace(150.0, 1400.0, len(damping))
    return to_poles(np.column_stack([np.log(place), np.log(damping)]))


def test_middle_and_deviation_are_those_of_most_modes() -> None:
    damping = 0.02 * np.exp(0.1 * np.random.default_rng(0).normal(size=40))
    damping[[3, 17]] = 0.1, 0.002
    estimated = DampingPrior.estimated(poles_of(damping), np.full(40, 0.01), BAND)
    assert estimated is not None
    assert estimated.middle == pytest.approx(np.log(0.02), abs=0.05)
    assert estimated.deviation == pytest.approx(0.1, rel=0.4)


def test_nothing_is_estimated_where_every_mode_is_well_known() -> None:
    damping = np.linspace(0.02, 0.05, 10)
    poles = poles_of(damping)
    assert DampingPrior.estimated(poles, np.full(10, 0.01), BAND) is None
    assert DampingPrior.estimated(poles, np.full(10, 0.3), BAND) is not None
    assert DampingPrior.estimated(poles[:5], np.full(5, 0.3), BAND) is None
    assert DampingPrior.estimated(poles[:0], np.zeros(0), BAND) is None


@pytest.mark.parametrize("thinned", [False, True])
def test_derivatives_are_those_of_the_misfit(thinned: bool) -> None:
    """Of the damping alone, whose share is the difference between misfits with it and without."""
    case = r10(np.random.default_rng(3))
    plain = Lines(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation), correlation=3.0)
    lines = replace(plain, damping=DampingPrior(np.log(0.03), 0.1, BAND))
    if thinned:
        plain, lines = averaged(plain), averaged(lines)
    x = to_parameters(case.poles)
    step = np.zeros_like(x)
    step[4, 1] = 1e-5

    def added(x: np.ndarray) -> np.ndarray:
        one, other = project(lines, to_poles(x), REAL_E_F), project(plain, to_poles(x), REAL_E_F)
        return np.array([one.misfit - other.misfit, (one.gradient - other.gradient)[9]])

    slope = (added(x + step) - added(x - step)) / 2e-5
    assert slope[0] == pytest.approx(2.0 * added(x)[1], rel=1e-4)
    bend = np.diag(project(lines, case.poles, REAL_E_F).hessian - project(plain, case.poles, REAL_E_F).hessian)
    assert bend[::2] == pytest.approx(0.0)
    assert (bend[1::2] > 0.0).all()
    assert added(x)[0] > 0.0


def test_a_mode_unlike_the_others_is_left_alone() -> None:
    """Twice the others' damping, known to 0.5 %: moved by less than a tenth of that."""
    alike = DampingPrior(np.log(0.02), 0.02, BAND)
    slope = alike.departure(poles_of(np.array([0.02, 0.04, 0.02])))[1]
    assert abs(slope[1]) * 0.005**2 < 0.1 * 0.005


def test_one_of_more_damping_may_be_two_where_modes_overlap_only() -> None:
    """Ten modes of 2 %: 3.4 % among them is reported, 2.2 %, and 3.4 % in a band by itself, are not."""
    close, alone = np.full(10, 0.02), np.full(10, 0.02)
    close[[4, 6]] = 0.034, 0.022
    alone[9] = 0.034
    alike = DampingPrior(np.log(0.02), 0.05, BAND)
    crowd = poles_of(close) / np.abs(poles_of(close)) * 2 * np.pi * np.linspace(400.0, 600.0, 10)
    far = poles_of(alone) / np.abs(poles_of(alone)) * 2 * np.pi * np.append(np.linspace(400.0, 600.0, 9), 1300.0)
    assert np.flatnonzero(alike.shared(crowd)).tolist() == [4]
    assert not alike.shared(far).any()


def test_a_peak_of_two_modes_is_not_called_one() -> None:
    """Three FRFs of forty modes, in which a pole with half as much damping again takes the place of two."""
    doubtful = 0
    for seed in (1007, 1010, 1020):
        case = crowded(np.random.default_rng(seed))
        modes = identify(Measured(case.frequency, case.h[None]))
        damping = np.exp(to_parameters(modes.poles)[:, 1])
        kept = np.array([status == "kept" for status in modes.status])
        assert damping[kept].max() < 0.0375
        more = modes.real & ~kept & (damping > 0.0375)
        doubtful += int(more.any())
        assert all("possibly two unresolved modes" in modes.reason[j] for j in np.flatnonzero(more))
    assert doubtful >= 2  # one of them may be found as two modes


def test_modes_that_overlap_are_told_apart_by_the_damping_of_the_others() -> None:
    """Of 80 modes in two FRFs, at least 1.5 % apart with damping of 2.5 %, 10 were missed without."""
    missed = 80
    for seed in (1000, 1020):
        case = crowded(np.random.default_rng(seed))
        modes = identify(Measured(case.frequency, case.h[None]))
        found = to_parameters(modes.poles[[status == "kept" for status in modes.status]])
        away = np.abs(to_parameters(case.poles)[:, None] - found)
        near = away[linear_sum_assignment(np.minimum(away[:, :, 0], 0.2))]
        missed -= int(((near[:, 0] < 0.025) & (near[:, 1] < 0.4)).sum())
    assert missed <= 5
