"""Bayesian regularisation the plain way: every Jacobian, normal matrix and inverse written out in full.

This is what a general toolbox does for a network of P parameters: matrices P by P, the inverse for the
evidence. It is the reference that `analysis.compensation` is tested against on small cases and timed
against on the paper's, 5652 parameters; it knows nothing of arrows and rotations.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from analysis.arrays import Real


@dataclass(frozen=True)
class DenseState:
    """Parameters (slope, bias, output row by row) and regularisation after some epochs."""

    parameters: Real
    alpha: float
    beta: float
    gamma: float
    log_determinant: float


def network(parameters: Real, inputs: Real, nodes: int, outputs: int) -> tuple[Real, Real]:
    """Return outputs (n, M) and Jacobian (n M, P) of a network of `nodes` tanh nodes."""
    slope, bias = parameters[:nodes], parameters[nodes : 2 * nodes]
    output = parameters[2 * nodes :].reshape(nodes + 1, outputs)
    hidden = np.tanh(np.outer(inputs, slope) + bias)
    features = np.column_stack([hidden, np.ones(len(inputs))])
    derivative = 1.0 - hidden**2
    jacobian = np.zeros((len(inputs), outputs, len(parameters)))
    jacobian[:, :, :nodes] = np.einsum("ih,i,hm->imh", derivative, inputs, output[:nodes])
    jacobian[:, :, nodes : 2 * nodes] = np.einsum("ih,hm->imh", derivative, output[:nodes])
    blocks = jacobian[:, :, 2 * nodes :].reshape(len(inputs), outputs, nodes + 1, outputs)
    for m in range(outputs):
        blocks[:, m, :, m] = features
    return features @ output, jacobian.reshape(-1, len(parameters))


def train_dense(inputs: Real, targets: Real, slope: Real, bias: Real, output: Real, epochs: int) -> DenseState:
    """Levenberg–Marquardt with MacKay's evidence for `epochs` steps tried, from the given weights.

    `inputs` (n,), `targets` (n, M), `slope` and `bias` (H,), `output` (H+1, M).
    """
    nodes, (samples, outputs) = len(slope), targets.shape
    w = np.concatenate([slope, bias, output.ravel()])
    count, error_count = len(w), samples * outputs
    reached, jacobian = network(w, inputs, nodes, outputs)
    error = (reached - targets).ravel()
    normal = jacobian.T @ jacobian
    gamma, damping = float(count) if count < error_count else 0.5 * error_count, 5e-3
    alpha, beta = gamma / (2.0 * w @ w), (error_count - gamma) / (2.0 * error @ error)
    identity = np.eye(count)
    for _ in range(epochs):
        objective = beta * error @ error + alpha * w @ w
        factor = cho_factor(beta * normal + (alpha + damping) * identity)
        proposal = w - cho_solve(factor, beta * (jacobian.T @ error) + alpha * w)
        trial, trial_jacobian = network(proposal, inputs, nodes, outputs)
        trial_error = (trial - targets).ravel()
        if beta * trial_error @ trial_error + alpha * proposal @ proposal < objective:
            w, error, jacobian = proposal, trial_error, trial_jacobian
            damping = max(0.1 * damping, 1e-20)
            normal = jacobian.T @ jacobian
            inverse = cho_solve(cho_factor(beta * normal + alpha * identity), identity)
            gamma = count - alpha * np.trace(inverse)
            alpha, beta = gamma / (2.0 * w @ w), (error_count - gamma) / (2.0 * error @ error)
        else:
            damping *= 10.0
    determinant = float(np.linalg.slogdet(beta * normal + alpha * identity)[1])
    return DenseState(w, float(alpha), float(beta), float(gamma), determinant)
