import numpy as np
import pytest

from simulation.reduction.modal_form import ModalForm, ModalSlopes

F = np.linspace(5.0, 60.0, 200)


def stiffness(size, rng, highest=4e7):
    """Complex symmetric, poles from a few Hz to far above the lines, not proportionally damped."""
    q, _ = np.linalg.qr(rng.standard_normal((size, size)))
    squares = np.geomspace((2 * np.pi * 8) ** 2, highest, size)
    loss = rng.uniform(0.02, 0.12, size)
    other, _ = np.linalg.qr(rng.standard_normal((size, size)) + 8 * q)
    return (q * squares) @ q.T + 1j * (other * (loss * squares)) @ other.T


def direct(k, left, right):
    solved = [np.linalg.solve(k - (2 * np.pi * f) ** 2 * np.eye(len(k)), right.astype(complex)) for f in F]
    return np.stack([left.T @ x for x in solved], axis=-1)


@pytest.fixture
def system():
    rng = np.random.default_rng(2)
    return stiffness(14, rng), rng.standard_normal((14, 2)), rng.standard_normal((14, 3))


def test_compliance_equals_direct_solution(system):
    k, a, b = system
    answer, expected = ModalForm.of(k).compliance(a, b, F), direct(k, a, b)
    assert np.abs(answer - expected).max() < 1e-10 * np.abs(expected).max()


def test_far_poles_are_summed_to_rounding(system):
    """Few lines are summed term by term, many through a polynomial: both must agree."""
    k, a, b = system
    form = ModalForm.of(k)
    assert (np.abs(form.poles) > 4 * (2 * np.pi * F.max()) ** 2).sum() > 3
    one_by_one = np.concatenate([form.compliance(a, b, F[i : i + 10]) for i in range(0, F.size, 10)], axis=-1)
    assert np.abs(form.compliance(a, b, F) - one_by_one).max() < 1e-13 * np.abs(one_by_one).max()


def slopes_directly(k, a, b, changes):
    out = []
    for change in changes:
        z = [k - (2 * np.pi * f) ** 2 * np.eye(len(k)) for f in F]
        out.append(
            np.stack(
                [-a.T @ np.linalg.solve(m, change @ np.linalg.solve(m, b.astype(complex))) for m in z], axis=-1
            )
        )
    return np.array(out)


def test_derivatives_equal_their_definition(system):
    k, a, b = system
    changes = [k.real, np.diag(np.arange(14.0)), k.imag]
    found = ModalSlopes.of(ModalForm.of(k), a, b, F)
    value, slopes = found.compliance, found.connected(found.by_stiffness(np.array(changes)))
    expected = slopes_directly(k, a, b, changes)
    assert np.abs(value - direct(k, a, b)).max() < 1e-10 * np.abs(value).max()
    for slope, truth in zip(slopes, expected, strict=True):
        assert np.abs(slope - truth).max() < 1e-9 * np.abs(truth).max()


def test_derivatives_by_many_parameters_at_once_are_those_one_by_one(system):
    """With two dashpots, by the stiffness and by the columns; those of the columns against a difference."""
    k, a, b = system
    dashpots = 30.0 * np.random.default_rng(4).standard_normal((14, 2))
    form = ModalForm.of(k, dashpots)
    slopes = ModalSlopes.of(form, a, b, F)
    changes = np.array([k.real, np.diag(np.arange(14.0)), k.imag])
    together = slopes.by_stiffness(changes)
    for change, found in zip(changes, together, strict=True):
        (alone,) = slopes.by_stiffness(change[None])
        assert np.abs(found - alone).max() < 1e-12 * np.abs(found).max()
    for found, change in zip(slopes.connected(together), changes, strict=True):
        ahead, behind = (ModalForm.of(k + s * change, dashpots).compliance(a, b, F) for s in (1e-6, -1e-6))
        expected = (ahead - behind) / 2e-6
        assert np.abs(found - expected).max() < 2e-4 * np.abs(expected).max()
    da, db = np.random.default_rng(5).standard_normal((14, 2)), np.random.default_rng(6).standard_normal((14, 3))
    moved = slopes.connected(slopes.by_columns(np.array([da, 0 * da]), np.array([db, db])))
    for found, left in zip(moved, (da, 0 * da), strict=True):
        ahead, behind = (form.compliance(a + s * left, b + s * db, F) for s in (1e-3, -1e-3))
        expected = (ahead - behind) / 2e-3
        assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("split", [0.0, 1e-12, 1e-8, 1e-5])
def test_derivatives_hold_where_poles_meet(split):
    """A square plate has double modes; patches and temperature bring others arbitrarily close."""
    rng = np.random.default_rng(3)
    squares = (2 * np.pi * np.array([10.0, 20.0, 20.0 * (1 + split), 45.0])) ** 2
    q, _ = np.linalg.qr(rng.standard_normal((4, 4)))
    k = (q * (squares * (1 + 0.05j))) @ q.T
    a, b = rng.standard_normal((4, 1)), rng.standard_normal((4, 1))
    change = rng.standard_normal((4, 4))
    change = change + change.T
    (slope,) = ModalSlopes.of(ModalForm.of(k), a, b, F).by_stiffness(change[None])
    expected = slopes_directly(k, a, b, [change])[0]
    assert np.abs(slope - expected).max() < 1e-5 * np.abs(expected).max()


def test_solve_returns_coordinates(system):
    k, _, b = system
    x = ModalForm.of(k).solve(b, F)
    assert x.shape == (3, F.size, 14)
    residual = np.einsum("rs,nfs->nfr", k, x) - (2 * np.pi * F[:, None]) ** 2 * x - b.T[:, None, :]
    assert np.abs(residual).max() < 1e-7 * np.abs(b).max()
