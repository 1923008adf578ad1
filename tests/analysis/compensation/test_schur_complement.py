import numpy as np
import pytest
import torch

from analysis.compensation.linearised import Weights, inverse_trace, linearise, log_determinant, predict, step

NODES, SAMPLES, OUTPUTS, NETWORKS = 3, 7, 4, 2


@pytest.fixture
def case(rng):
    def tensor(*shape):
        return torch.as_tensor(rng.normal(size=shape))

    weights = Weights(tensor(NETWORKS, NODES), tensor(NETWORKS, NODES), tensor(NETWORKS, NODES + 1, OUTPUTS))
    used = torch.ones(NETWORKS, SAMPLES, dtype=torch.float64)
    used[1, 2] = 0.0
    inputs = torch.linspace(-1.0, 1.0, SAMPLES, dtype=torch.float64)
    return weights, inputs, tensor(NETWORKS, SAMPLES, OUTPUTS), used


def plain(dense, case, b):
    """Parameters, Jacobian and error of network b, samples left out dropped."""
    weights, inputs, targets, used = case
    w = np.concatenate([part[b].numpy().ravel() for part in (weights.slope, weights.bias, weights.output)])
    kept = used[b].numpy() > 0.0
    reached, jacobian = dense.network(w, inputs.numpy()[kept], NODES, OUTPUTS)
    return w, jacobian, (reached - targets[b].numpy()[kept]).ravel()


ALPHA = torch.tensor([0.3, 2.0], dtype=torch.float64)
BETA = torch.tensor([40.0, 5.0], dtype=torch.float64)


def test_the_dense_jacobian_is_the_derivative_of_the_network(dense, case):
    """The reference's own check, against differences of `predict`."""
    inputs = case[1]
    w, jacobian, _ = plain(dense, case, 0)

    def outputs(parameters):
        parts = np.split(parameters, [NODES, 2 * NODES])
        single = Weights(
            *(torch.as_tensor(p)[None] for p in (parts[0], parts[1], parts[2].reshape(NODES + 1, OUTPUTS)))
        )
        return predict(single, inputs)[0].numpy().ravel()

    h = 1e-6
    for p in range(len(w)):
        shift = h * np.eye(len(w))[p]
        numeric = (outputs(w + shift) - outputs(w - shift)) / (2 * h)
        np.testing.assert_allclose(jacobian[:, p], numeric, atol=1e-8)


def test_the_step_solves_the_full_normal_equations(dense, case):
    damping = torch.tensor([1e-3, 0.7], dtype=torch.float64)
    found = step(case[0], linearise(*case), ALPHA, BETA, damping)
    for b in range(NETWORKS):
        w, jacobian, error = plain(dense, case, b)
        alpha, beta = ALPHA[b].item(), BETA[b].item()
        matrix = beta * jacobian.T @ jacobian + (alpha + damping[b].item()) * np.eye(len(w))
        exact = -np.linalg.solve(matrix, beta * jacobian.T @ error + alpha * w)
        flat = np.concatenate([part[b].numpy().ravel() for part in (found.slope, found.bias, found.output)])
        np.testing.assert_allclose(flat, exact, rtol=1e-10, atol=1e-12)


def test_trace_and_determinant_equal_those_of_the_full_matrix(dense, case):
    at = linearise(*case)
    trace = inverse_trace(at, ALPHA, BETA, OUTPUTS)
    determinant = log_determinant(at, ALPHA, BETA, OUTPUTS)
    for b in range(NETWORKS):
        w, jacobian, _ = plain(dense, case, b)
        matrix = BETA[b].item() * jacobian.T @ jacobian + ALPHA[b].item() * np.eye(len(w))
        assert trace[b].item() == pytest.approx(np.trace(np.linalg.inv(matrix)), rel=1e-11)
        assert determinant[b].item() == pytest.approx(np.linalg.slogdet(matrix)[1], rel=1e-11)


def test_outputs_that_carry_no_weights_count_in_closed_form(case):
    """Five more outputs add five blocks S and leave the border alone."""
    at = linearise(*case)
    gram = at.features.mT @ at.features
    block = BETA[:, None, None] * gram + ALPHA[:, None, None] * torch.eye(NODES + 1, dtype=torch.float64)
    more = inverse_trace(at, ALPHA, BETA, OUTPUTS + 5) - inverse_trace(at, ALPHA, BETA, OUTPUTS)
    torch.testing.assert_close(more, 5.0 * torch.linalg.inv(block).diagonal(dim1=1, dim2=2).sum(1))
    grown = log_determinant(at, ALPHA, BETA, OUTPUTS + 5) - log_determinant(at, ALPHA, BETA, OUTPUTS)
    torch.testing.assert_close(grown, 5.0 * torch.logdet(block))


def test_a_rotation_of_the_outputs_rotates_the_step_and_nothing_else(case, rng):
    weights, inputs, targets, used = case
    turn = torch.as_tensor(np.linalg.qr(rng.normal(size=(OUTPUTS, OUTPUTS)))[0])
    turned = Weights(weights.slope, weights.bias, weights.output @ turn)
    at, at_turned = linearise(*case), linearise(turned, inputs, targets @ turn, used)
    damping = torch.full((NETWORKS,), 0.01, dtype=torch.float64)
    one, two = step(weights, at, ALPHA, BETA, damping), step(turned, at_turned, ALPHA, BETA, damping)
    torch.testing.assert_close(one.slope, two.slope)
    torch.testing.assert_close(one.output @ turn, two.output)


def test_more_nodes_than_samples_are_solved_too(dense, rng):
    inputs = torch.linspace(-1.0, 1.0, 3, dtype=torch.float64)
    weights = Weights(*(torch.as_tensor(rng.normal(size=s)) for s in ((1, 5), (1, 5), (1, 6, 2))))
    targets = torch.as_tensor(rng.normal(size=(1, 3, 2)))
    at = linearise(weights, inputs, targets, torch.ones(1, 3, dtype=torch.float64))
    w = np.concatenate([part[0].numpy().ravel() for part in (weights.slope, weights.bias, weights.output)])
    _, jacobian = dense.network(w, inputs.numpy(), 5, 2)
    matrix = 40.0 * jacobian.T @ jacobian + 0.3 * np.eye(len(w))
    found = inverse_trace(at, ALPHA[:1], BETA[:1], 2)
    assert found.item() == pytest.approx(np.trace(np.linalg.inv(matrix)), rel=1e-10)
