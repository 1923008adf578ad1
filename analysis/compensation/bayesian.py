"""Bayesian regularisation of one-hidden-layer networks: Levenberg–Marquardt with MacKay's evidence.

Foresee and Hagan (1997): minimise β E_D + α E_W by Levenberg–Marquardt; after every step re-estimate
γ = P - α tr(β JᵀJ + α I)⁻¹ (the parameters the data determine), α = γ/(2 E_W), β = (n M - γ)/(2 E_D).
Nothing is approximated beyond that: see `analysis.compensation.schur_complement` for why it is quick all the same.
"""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from analysis.compensation.schur_complement import (
    Linearised,
    Weights,
    errors,
    inverse_trace,
    linearise,
    log_determinant,
    step,
)

STILL = 20.0
"""Steps on end without a change after which a training ends."""
LARGEST_DAMPING = 1e10


@dataclass(frozen=True)
class TrainingProblem:
    """What B networks have to learn, outputs rotated.

    Attributes
    ----------
    inputs : (n,) Tensor
    targets : (B, n, k) Tensor
    used : (B, n) Tensor
        1 for samples trained on, 0 for samples left out.
    outputs : int
        Outputs before the rotation, M; the M - k left away have zero targets and zero weights.
    """

    inputs: Tensor
    targets: Tensor
    used: Tensor
    outputs: int

    @property
    def error_count(self) -> Tensor:
        """Number (B,) of errors n M."""
        return self.used.sum(1) * self.outputs


@dataclass(frozen=True)
class Evidence:
    """State of the regularisation of B networks; every field is (B,).

    Attributes
    ----------
    alpha, beta : Tensor
        Weight of the squared parameters and of the squared errors.
    gamma : Tensor
        Parameters the data determine.
    log_evidence : Tensor
        ln p(targets | network), up to a constant of the data.
    """

    alpha: Tensor
    beta: Tensor
    gamma: Tensor
    log_evidence: Tensor


@dataclass(frozen=True)
class BayesianFit:
    """Trained networks and how the training ended.

    Attributes
    ----------
    weights : Weights
    evidence : Evidence
    epochs : (B,) Tensor
        Steps tried.
    """

    weights: Weights
    evidence: Evidence
    epochs: Tensor


def train(
    problem: TrainingProblem,
    start: Weights,
    epochs: int = 1000,
    tolerance: float = 1e-6,
    progress: Callable[[int], None] | None = None,
) -> BayesianFit:
    """Train B networks from `start` until each stands still or has had `epochs` steps.

    A network stands still when in `STILL` steps on end neither its objective nor α moved by more than
    `tolerance` of itself, or when the damping has passed 1e10: no descent left in the digits at hand. One whose
    evidence collapses, so that to the digits at hand the data determine no parameter, stops where it is.

    Parameters
    ----------
    problem : TrainingProblem
    start : Weights
        First weights of the B networks.
    epochs : int
        Steps tried at most.
    tolerance : float
        Relative change under which objective and α count as unmoved.
    progress : callable, optional
        Told the number of every step done, from 0.

    Returns
    -------
    BayesianFit
        Weights, evidence and steps tried of every network.
    """
    weights = start
    at = linearise(weights, problem.inputs, problem.targets, problem.used)
    alpha, beta = first_estimate(problem, weights, at)
    damping = torch.full_like(alpha, 5e-3)
    still = torch.zeros_like(alpha)
    tried = torch.zeros_like(alpha)
    for epoch in range(epochs):
        running = (still < STILL) & (damping <= LARGEST_DAMPING)
        if not running.any():
            break
        tried = tried + running
        objective = beta * _squares(at.error) + alpha * weights.squares()
        proposal = weights.moved(step(weights, at, alpha, beta, damping))
        trial = errors(proposal, problem.inputs, problem.targets, problem.used)
        reached = beta * _squares(trial) + alpha * proposal.squares()
        better = running & (reached < objective)
        damping = torch.where(
            better, (0.1 * damping).clamp(min=1e-20), torch.where(running, 10.0 * damping, damping)
        )
        if better.any():
            weights = proposal.chosen(better, weights)
            at = linearise(weights, problem.inputs, problem.targets, problem.used)
            new_alpha, new_beta = reestimate(problem, weights, at, alpha, beta)
            sound = (new_alpha > 0.0) & new_alpha.isfinite()
            quiet = (objective - reached < tolerance * objective) & ((new_alpha / alpha - 1).abs() < tolerance)
            still = torch.where(better, torch.where(quiet, still + 1, 0.0), still)
            still = torch.where(better & ~sound, STILL, still)
            kept = better & sound
            alpha, beta = torch.where(kept, new_alpha, alpha), torch.where(kept, new_beta, beta)
        if progress is not None:
            progress(epoch)
    return BayesianFit(weights, judge(problem, weights, at, alpha, beta), tried)


def first_estimate(problem: TrainingProblem, weights: Weights, at: Linearised) -> tuple[Tensor, Tensor]:
    """Estimate α, β as though the data determined every parameter; half their errors' number where P is as many.

    Foresee and Hagan begin with γ = P. Where parameters are as many as errors that leaves no β, and a β of
    1 in its place flattens what the output layer knows already: the evidence then settles on constant outputs.

    Parameters
    ----------
    problem : TrainingProblem
    weights : Weights
        First weights.
    at : Linearised
        The networks at `weights`.

    Returns
    -------
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    """
    count = torch.full_like(problem.error_count, parameter_count(weights, problem.outputs))
    gamma = torch.where(count < problem.error_count, count, 0.5 * problem.error_count)
    return _maximised(problem, weights, at, gamma)


def reestimate(
    problem: TrainingProblem, weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor
) -> tuple[Tensor, Tensor]:
    """One round of MacKay's α = γ/(2 E_W) and β = (n M - γ)/(2 E_D).

    Parameters
    ----------
    problem : TrainingProblem
    weights : Weights
    at : Linearised
        The networks at `weights`.
    alpha, beta : (B,) Tensor
        The estimates before.

    Returns
    -------
    alpha, beta : (B,) Tensor
        The estimates after.
    """
    return _maximised(problem, weights, at, determined(problem, weights, at, alpha, beta))


def _maximised(problem: TrainingProblem, weights: Weights, at: Linearised, gamma: Tensor) -> tuple[Tensor, Tensor]:
    """Return α and β (B,) of highest evidence where the data determine `gamma` (B,) parameters."""
    # An exact fit would send beta to infinity; the floor is far below any rounding of the errors.
    squares = _squares(at.error).clamp(min=1e-30 * float(problem.outputs))
    return gamma / (2.0 * weights.squares()), (problem.error_count - gamma).clamp(min=1e-3) / (2.0 * squares)


def determined(problem: TrainingProblem, weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor) -> Tensor:
    """Count the parameters the data determine: γ = P - α tr(β JᵀJ + α I)⁻¹.

    Parameters
    ----------
    problem : TrainingProblem
    weights : Weights
    at : Linearised
        The networks at `weights`.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.

    Returns
    -------
    (B,) Tensor
        γ, of the P = 2H + M(H+1) parameters of each network.

    Raises
    ------
    torch.linalg.LinAlgError
        Where the border matrix is not positive definite to the digits at hand.
    """
    count = parameter_count(weights, problem.outputs)
    return count - alpha * inverse_trace(weights, at, alpha, beta, problem.outputs)


def judge(problem: TrainingProblem, weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor) -> Evidence:
    """Evidence of networks at their weights, by Laplace's approximation about them.

    ln p(D) = -β E_D - α E_W - ½ ln|β JᵀJ + α I| + P/2 ln α + nM/2 ln(β/π).

    Parameters
    ----------
    problem : TrainingProblem
    weights : Weights
    at : Linearised
        The networks at `weights`.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.

    Returns
    -------
    Evidence
        α, β, γ and the logarithm of the evidence of each of the B networks.
    """
    count = parameter_count(weights, problem.outputs)
    fit = -beta * _squares(at.error) - alpha * weights.squares()
    occam = -0.5 * log_determinant(weights, at, alpha, beta, problem.outputs) + 0.5 * count * torch.log(alpha)
    noise = 0.5 * problem.error_count * torch.log(beta / torch.pi)
    return Evidence(alpha, beta, determined(problem, weights, at, alpha, beta), fit + occam + noise)


def parameter_count(weights: Weights, outputs: int) -> int:
    """Parameters of one network with `outputs` outputs."""
    nodes = weights.slope.shape[1]
    return 2 * nodes + outputs * (nodes + 1)


def _squares(error: Tensor) -> Tensor:
    return (error**2).sum((1, 2))
