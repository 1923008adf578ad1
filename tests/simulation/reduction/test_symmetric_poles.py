import numpy as np
import pytest

from simulation.reduction.modal_form import ModalForm, symmetric_poles


def coupled(rng, size=40, patches=0.1, loss=0.08):
    """Return a plate with losses in proportion to its stiffness, and patches without, from 8 Hz to 80 kHz."""
    q, _ = np.linalg.qr(rng.standard_normal((size, size)))
    squares = np.geomspace((2 * np.pi * 8) ** 2, (2 * np.pi * 8e4) ** 2, size)
    root = (q * np.sqrt(squares)) @ q.T
    glued = rng.standard_normal((size, 5)) / np.sqrt(size)
    return (1 + 1j * loss) * root @ root + patches * root @ glued @ glued.T @ root


@pytest.mark.parametrize("patches", [0.0, 0.1, 1.0])
def test_poles_and_vectors_satisfy_the_eigenproblem(patches):
    k = coupled(np.random.default_rng(5), patches=patches)
    found = symmetric_poles(k)
    assert found is not None
    poles, vectors = found
    expected = np.linalg.eigvals(k)
    rounding = 1e-13 * np.abs(expected).max()
    assert np.abs(np.sort(poles.real) - np.sort(expected.real)).max() < rounding
    assert np.abs(k @ vectors - vectors * poles).max() < rounding
    assert np.abs(vectors.T @ vectors - np.eye(len(k))).max() < 1e-12


def test_defective_matrix_has_no_answer():
    """Its one eigenvector x has x'x = 0."""
    assert symmetric_poles(np.array([[1.0, 1j], [1j, -1.0]])) is None


@pytest.mark.parametrize("split", [0.0, 1e-15, 1e-9, 1e-3])
def test_modal_form_does_not_depend_on_how_far_poles_are_apart(split):
    """Where they meet, ModalForm turns to a general solver."""
    rng = np.random.default_rng(6)
    q, _ = np.linalg.qr(rng.standard_normal((6, 6)))
    squares = np.array([1.0, 2.0, 2.0 * (1 + split), 3.0, 3.0 + split, 9.0])
    coupling = rng.standard_normal((6, 6))
    k = (q * squares) @ q.T + 0.02j * (coupling @ coupling.T)
    form = ModalForm.of(k)
    assert np.abs((form.shapes * form.poles) @ form.inverse - k).max() < 1e-11
