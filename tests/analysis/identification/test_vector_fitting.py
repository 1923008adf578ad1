import numpy as np

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import COMPLEX_E_F_G
from analysis.identification.vector_fitting import Relocation, start_poles
from tests.synthetic_frf import r10


def test_poles_of_an_exact_rational_function_are_found_from_nothing() -> None:
    case = r10(np.random.default_rng(3), noise=0.0)
    lines = Lines(case.frequency, case.clean[None], np.ones((1, len(case.clean))))
    found = start_poles(lines, 10, COMPLEX_E_F_G, iterations=30)
    for pole in case.poles:
        assert np.abs(found - pole).min() < 1e-6 * abs(pole)


def test_true_poles_stay_where_they_are() -> None:
    case = r10(np.random.default_rng(4), noise=0.0)
    lines = Lines(case.frequency, case.clean[None], np.ones((1, len(case.clean))))
    moved = Relocation.of(lines, COMPLEX_E_F_G).relocated(case.poles)
    np.testing.assert_allclose(moved, case.poles, rtol=1e-7)


def test_noise_cannot_make_poles_unstable_or_lose_a_strong_mode() -> None:
    case = r10(np.random.default_rng(5), noise=0.05)
    lines = Lines(case.frequency, case.h[None], np.full((1, len(case.h)), case.deviation))
    found = start_poles(lines, 24, COMPLEX_E_F_G)
    assert (found.real < 0.0).all()
    strongest = case.poles[np.argmax(np.abs(case.residues) / -case.poles.real)]
    assert np.abs(found - strongest).min() < -strongest.real
