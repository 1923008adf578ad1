import numpy as np
import pytest

from analysis.identification.lines import Lines
from analysis.identification.order import (
    attempt,
    bic,
    choose_terms,
    drop_unsupported,
    duplicates,
    eliminate,
    misfit_worth,
    pole_penalty,
    support,
)
from analysis.identification.pole_residue import COMPLEX_E_F_G, NONE, REAL_E_F
from analysis.identification.pole_search import fit
from tests.synthetic_frf import SyntheticFrf, r10


@pytest.fixture(scope="module")
def case() -> SyntheticFrf:
    return r10(np.random.default_rng(71))


@pytest.fixture(scope="module")
def lines(case: SyntheticFrf) -> Lines:
    return Lines(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation))


def test_bic_and_the_misfit_it_is_worth_are_inverse(lines: Lines, case: SyntheticFrf) -> None:
    fitted = fit(lines, case.poles, REAL_E_F)
    assert misfit_worth(lines, bic(fitted, lines), len(fitted.poles), fitted.terms) == pytest.approx(
        fitted.projection.misfit
    )


def test_support_bounds_what_dropping_and_refitting_costs(lines: Lines, case: SyntheticFrf) -> None:
    fitted = fit(lines, case.poles, REAL_E_F)
    bound = support(fitted, lines)
    for j in (0, 4, 9):
        dropped = fit(lines, np.delete(case.poles, j), REAL_E_F)
        assert 0.0 < bic(dropped, lines) - bic(fitted, lines) <= bound[j] + 1e-6


def test_poles_of_noise_go_and_those_of_the_plate_stay(lines: Lines, case: SyntheticFrf) -> None:
    noise = 2 * np.pi * np.array([137.0, 512.0, 731.0, 1333.0]) * complex(-0.01, 1.0)
    crowded = fit(lines, np.concatenate([case.poles, noise]), COMPLEX_E_F_G, max_iterations=3)
    for left in (drop_unsupported(lines, crowded), eliminate(lines, crowded)):
        assert len(left.poles) == 10
    np.testing.assert_allclose(np.sort(np.abs(left.poles)), np.abs(case.poles), rtol=2e-3)


def test_two_poles_on_one_peak_become_one(lines: Lines, case: SyntheticFrf) -> None:
    twins = np.append(case.poles, case.poles[3] * (1 + 0.004j))
    assert duplicates(twins)[0] == (3, 10)
    assert len(eliminate(lines, fit(lines, twins, REAL_E_F, max_iterations=0)).poles) == 10


def test_residual_terms_are_those_the_case_was_made_with(lines: Lines, case: SyntheticFrf) -> None:
    for start in (COMPLEX_E_F_G, NONE):
        assert choose_terms(lines, fit(lines, case.poles, start)).terms == REAL_E_F


def test_a_rival_that_cannot_win_is_no_fit(lines: Lines, case: SyntheticFrf) -> None:
    level = bic(fit(lines, case.poles, REAL_E_F), lines)
    assert attempt(lines, case.poles[:8], REAL_E_F, level) is None
    won = attempt(lines, case.poles * 1.002, REAL_E_F, level + 0.5 * pole_penalty(lines))
    assert won is not None
    assert bic(won, lines) < level + 0.5 * pole_penalty(lines)
