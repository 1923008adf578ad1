import numpy as np
import pytest

from analysis.identification.lines import Lines
from analysis.identification.pole_residue import (
    COMPLEX_E_F_G,
    EVERY_CHOICE,
    NONE,
    REAL_E_F,
    ResidualTerms,
    synthesis,
    to_parameters,
    to_poles,
)
from analysis.identification.pole_search import fit, misfit_at, project

RNG = np.random.default_rng(5)
FREQUENCY = np.linspace(100.0, 400.0, 301)
POLES = 2 * np.pi * np.array([150, 210, 228.0]) * (-np.array([0.02, 0.03, 0.025]) + 1j)
RESIDUES = np.array([[1j, -2j + 0.1, 1.5j], [0.5j, 1j, -2j + 0.3]])


def two_responses(terms: ResidualTerms = REAL_E_F, noise: float = 0.0) -> Lines:
    """Two FRFs that share poles, with deviations that are not proportional."""
    scale = 2 * np.pi * 200.0
    constants = np.array([[0.02 * scale**-p for p in terms.powers]] * 2, dtype=complex)
    h = synthesis(FREQUENCY, POLES, RESIDUES, terms, constants)
    deviation = np.abs(h).mean() * np.array([np.linspace(1.0, 2.0, 301), np.linspace(3.0, 0.5, 301)]) * 0.01
    draw = RNG.normal(size=h.shape) + 1j * RNG.normal(size=h.shape)
    return Lines(FREQUENCY, h + noise * deviation / np.sqrt(2) * draw, deviation)


def moved(factor: float) -> np.ndarray:
    return POLES * np.exp(factor * np.array([1.0, -0.7, 0.5]))


def projected_residual(lines: Lines, x: np.ndarray, terms: ResidualTerms) -> np.ndarray:
    """Return what the best residues leave, by plain least squares, response by response."""
    s = lines.s
    left = []
    for h, deviation in zip(lines.h, lines.deviation, strict=True):
        columns = [c for p in to_poles(x.reshape(-1, 2)) for c in (1 / (s - p) + 1 / (s - p.conjugate()),)]
        columns += [1j * (1 / (s - p) - 1 / (s - p.conjugate())) for p in to_poles(x.reshape(-1, 2))]
        columns += list(terms.columns(s, lines.scale))
        a = np.array(columns) / deviation
        a = np.concatenate([a.real, a.imag], axis=1).T
        y = np.concatenate([(h / deviation).real, (h / deviation).imag])
        left.append(y - a @ np.linalg.lstsq(a, y, rcond=None)[0])
    return np.concatenate(left)


@pytest.mark.parametrize("terms", [REAL_E_F, COMPLEX_E_F_G])
def test_gradient_and_hessian_are_those_of_the_projected_residual(terms: ResidualTerms) -> None:
    lines = two_responses(noise=1.0)
    x = to_parameters(moved(0.01)).ravel()
    jacobian = np.empty((2 * lines.h.size, x.size))
    for i in range(x.size):
        step = np.zeros_like(x)
        step[i] = 1e-6
        ahead, behind = (projected_residual(lines, x + sign * step, terms) for sign in (1, -1))
        jacobian[:, i] = (ahead - behind) / 2e-6
    left = projected_residual(lines, x, terms)
    found = project(lines, to_poles(x.reshape(-1, 2)), terms)
    assert found.misfit == pytest.approx(left @ left, rel=1e-9)
    np.testing.assert_allclose(found.gradient, jacobian.T @ left, rtol=2e-5, atol=1e-5 * abs(found.gradient).max())
    np.testing.assert_allclose(
        found.hessian, jacobian.T @ jacobian, rtol=1e-4, atol=1e-6 * np.abs(found.hessian).max()
    )


def test_loss_is_what_dropping_a_pole_costs() -> None:
    lines = two_responses(noise=1.0)
    found = project(lines, POLES, REAL_E_F)
    for j in range(3):
        without = misfit_at(lines, np.delete(POLES, j), REAL_E_F)
        assert found.loss[j] == pytest.approx(without - found.misfit, rel=1e-6)


@pytest.mark.parametrize("terms", EVERY_CHOICE)
def test_exact_data_give_back_poles_residues_and_terms(terms: ResidualTerms) -> None:
    lines = two_responses(terms)
    found = fit(lines, moved(0.01), terms, tolerance=1e-14, max_iterations=100)
    np.testing.assert_allclose(found.poles, POLES, rtol=1e-7)
    np.testing.assert_allclose(found.projection.residues, RESIDUES, rtol=1e-5, atol=1e-6)
    rebuilt = synthesis(FREQUENCY, found.poles, found.projection.residues, terms, found.projection.coefficients)
    np.testing.assert_allclose(rebuilt, lines.h, rtol=1e-6)


def test_poles_that_nearly_coincide_do_not_break_the_elimination() -> None:
    """Far beyond what normal equations carry, so the orthogonal factor takes over."""
    lines = two_responses(noise=1.0)
    twins = np.append(POLES, POLES[0] * (1 + 1e-9))
    found = project(lines, twins, REAL_E_F)
    assert np.isfinite(found.hessian).all()
    assert found.misfit == pytest.approx(misfit_at(lines, POLES, REAL_E_F), rel=0.05)


def test_search_is_given_up_where_the_target_is_out_of_reach() -> None:
    lines = two_responses(noise=1.0)
    best = fit(lines, moved(0.01), REAL_E_F)
    hopeless = fit(lines, POLES[:2] * 1.02, REAL_E_F, target=1.01 * best.projection.misfit)
    assert hopeless.projection.misfit > 1.01 * best.projection.misfit
    assert hopeless.iterations < fit(lines, POLES[:2] * 1.02, REAL_E_F).iterations


def test_estimates_scatter_as_the_hessian_says() -> None:
    """Mean squared standardised error of 40 draws is 1, within its own scatter (chi-square of 240)."""
    total = 0.0
    for _ in range(40):
        found = fit(two_responses(noise=1.0), POLES, REAL_E_F, tolerance=1e-9)
        error = (to_parameters(found.poles) - to_parameters(POLES)).ravel()
        total += 2.0 * error @ found.projection.hessian @ error / 6.0
    assert total / 40 == pytest.approx(1.0, abs=4 * np.sqrt(2 / 240))


def test_a_fit_takes_half_a_unit_of_misfit_for_every_parameter() -> None:
    """Of 3 poles, 6 residues and 4 residual terms, 22 parameters in all: chi-square of 22, over 100 draws."""
    total, rng = 0.0, np.random.default_rng(6)
    clean = two_responses()
    for _ in range(100):
        noise = clean.deviation / np.sqrt(2) * (rng.normal(size=(2, 301)) + 1j * rng.normal(size=(2, 301)))
        found = fit(Lines(FREQUENCY, clean.h + noise, clean.deviation), POLES, REAL_E_F, tolerance=1e-9)
        total += float((np.abs(noise / clean.deviation) ** 2).sum()) - found.projection.misfit
        assert found.parameters == 3 * 2 + 2 * (3 * 2 + 2)
    assert 2.0 * total / 100 == pytest.approx(found.parameters, abs=3.0 * np.sqrt(2 * 22 / 100))


def test_a_model_of_nothing_leaves_all_and_says_nothing(capfd: pytest.CaptureFixture[str]) -> None:
    """LAPACK writes a line of its own to the terminal where it is given an empty matrix."""
    frequency = np.linspace(10.0, 20.0, 30)
    lines = Lines(frequency, np.full((2, 30), 3.0 + 0j), np.full((2, 30), 1.5))
    found = project(lines, np.zeros(0, complex), NONE)
    assert found.misfit == pytest.approx(2 * 30 * 4.0)
    assert found.residues.shape == (2, 0)
    assert "".join(capfd.readouterr()) == ""
