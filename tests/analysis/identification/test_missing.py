import numpy as np
import pytest

from analysis.identification.averaging import averaged
from analysis.identification.lines import Lines
from analysis.identification.missing import add_missing, gains, matched, residual
from analysis.identification.pole_residue import REAL_E_F
from analysis.identification.pole_search import fit, misfit_at
from tests.synthetic_frf import r10

CASE = r10(np.random.default_rng(81))
LINES = Lines(CASE.frequency, CASE.h[None], np.full((1, len(CASE.h)), CASE.deviation))


@pytest.mark.parametrize("lost", range(10))
def test_a_lost_mode_is_proposed_and_brought_back(lost: int) -> None:
    blocks = averaged(LINES)
    fitted = fit(blocks, np.delete(CASE.poles, lost), REAL_E_F)
    again = add_missing(LINES, blocks, fitted)
    assert len(again.poles) >= 10
    assert np.abs(again.poles - CASE.poles[lost]).min() < 0.2 * -CASE.poles[lost].real


def test_nothing_is_added_to_a_complete_model() -> None:
    fitted = fit(LINES, CASE.poles, REAL_E_F)
    assert add_missing(LINES, LINES, fitted) is fitted


def test_gain_is_the_fall_of_the_misfit() -> None:
    fitted = fit(LINES, CASE.poles[:9], REAL_E_F, max_iterations=0)
    new = CASE.poles[9:] * 1.01
    fall = fitted.projection.misfit - misfit_at(LINES, np.append(CASE.poles[:9], new), REAL_E_F)
    assert gains(LINES, fitted, new)[0] == pytest.approx(fall, rel=1e-6)


def test_filters_find_a_needle_and_a_hump_where_they_are() -> None:
    s = LINES.s
    for f, half_width in ((400.0, 1.0), (900.0, 30.0)):
        pole = 2 * np.pi * complex(-half_width, f)
        left = (1.0 / (s - pole))[None, :] * abs(pole.real) * 20 * CASE.deviation
        found = matched(LINES, left)[0]
        assert abs(found.imag - pole.imag) < half_width * np.pi
        assert 0.5 < found.real / pole.real < 2.0


def test_residual_is_what_the_synthesis_leaves() -> None:
    fitted = fit(LINES, CASE.poles, REAL_E_F)
    left = np.abs(residual(LINES, fitted) / LINES.deviation) ** 2
    assert left.sum() == pytest.approx(fitted.projection.misfit, rel=1e-9)
