import numpy as np
import pytest

from simulation.reduction.damped_modes import EnergySums
from simulation.reduction.modal_form import ModalForm

F = np.linspace(5.0, 60.0, 200)


@pytest.fixture
def rng():
    return np.random.default_rng(4)


def stiffness(rng, squares, loss):
    """Complex symmetric with these squared angular frequencies, not proportionally damped."""
    q, _ = np.linalg.qr(rng.standard_normal((len(squares), len(squares))))
    other, _ = np.linalg.qr(rng.standard_normal(q.shape) + 8 * q)
    return (q * squares) @ q.T + 1j * (other * (loss * squares)) @ other.T


def relative(found, expected):
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize("loss", [1e-3, 0.06])
def test_energies_equal_those_of_the_answers_themselves(rng, loss):
    """Poles from a few Hz to far above the lines; loads and the measure of energy are arbitrary."""
    squares = np.geomspace((2 * np.pi * 8) ** 2, 4e7, 14)
    modal = ModalForm.of(stiffness(rng, squares, loss * rng.uniform(0.5, 1.5, 14)))
    force, root, direction = (rng.standard_normal(shape) for shape in ((14, 3), (9, 14), 14))
    sums, answers = EnergySums.of(modal, force, F), modal.solve(force, F)
    image = (answers @ root.T).transpose(1, 2, 0)
    assert relative(sums.energy(root), image.conj().transpose(0, 2, 1) @ image) < 1e-12 / loss
    assert relative(sums.along(direction), (answers.conj() @ direction).T) < 1e-12


@pytest.mark.parametrize(
    ("apart", "within"), [(1.0, 1e-11), (1e-2, 1e-11), (1e-4, 1e-10), (1e-6, 1e-8)], ids=lambda x: f"{x:g}"
)
def test_poles_that_meet(rng, apart, within):
    """Two equal poles, and two that damping couples until, at `apart` 0, they would share one eigenvector."""
    squares = np.geomspace((2 * np.pi * 8) ** 2, 4e6, 12)
    squares[5], squares[3] = squares[4], squares[2]
    k, split = np.diag(squares * (1 + 0.05j)), 0.02 * squares[2]
    k[2:4, 2:4] += split * np.array([[1.0, 1j * (1.0 - apart)], [1j * (1.0 - apart), -1.0]])
    q, _ = np.linalg.qr(rng.standard_normal(k.shape))
    modal = ModalForm.of(q @ k @ q.T)
    force, root = rng.standard_normal((12, 3)), rng.standard_normal((12, 12))
    answers = [np.linalg.solve(q @ k @ q.T - (2 * np.pi * f) ** 2 * np.eye(12), force) for f in F]
    expected = np.array([(x.conj().T @ root.T) @ (root @ x) for x in answers])
    assert relative(EnergySums.of(modal, force, F).energy(root), expected) < within


def test_rigid_motions_that_no_damping_parts_from_their_mirror_images(rng):
    """A free plate: three poles at zero, but for rounding, whose products are no differences."""
    squares = np.concatenate([[0.0, 1e-9, -1e-9], np.geomspace((2 * np.pi * 8) ** 2, 4e6, 9)])
    k = (q := np.linalg.qr(rng.standard_normal((12, 12)))[0]) * (squares * (1 + 0.05j)) @ q.T
    force, root = rng.standard_normal((12, 3)), rng.standard_normal((12, 12))
    answers = [np.linalg.solve(k - (2 * np.pi * f) ** 2 * np.eye(12), force) for f in F]
    expected = np.array([(x.conj().T @ root.T) @ (root @ x) for x in answers])
    assert relative(EnergySums.of(ModalForm.of(k), force, F).energy(root), expected) < 1e-10


def test_dashpots_are_refused(rng):
    modal = ModalForm.of(stiffness(rng, np.array([1.0, 2.0]), 0.1), rng.standard_normal((2, 1)))
    with pytest.raises(ValueError, match="1 columns of dashpots"):
        EnergySums.of(modal, np.ones((2, 1)), F)
