"""Bayesian regularisation of one-hidden-layer networks: Levenberg–Marquardt with MacKay's evidence.

Foresee and Hagan (1997): minimise β E_D + α E_W by Levenberg–Marquardt; after every step re-estimate α and β
(`analysis.compensation.evidence`). Nothing is approximated beyond that: see
`analysis.compensation.schur_complement` for why it is quick all the same.
"""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from analysis.compensation.evidence import (
    Evidence,
    TrainingProblem,
    first_estimate,
    judge,
    reestimate,
    squared_error,
)
from analysis.compensation.linearised import Weights, errors, linearise
from analysis.compensation.schur_complement import step

STILL = 20.0
"""Steps on end without a change after which a training ends."""
LARGEST_DAMPING = 1e10


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
        objective = beta * squared_error(at.error) + alpha * weights.squares()
        proposal = weights.moved(step(weights, at, alpha, beta, damping))
        trial = errors(proposal, problem.inputs, problem.targets, problem.used)
        reached = beta * squared_error(trial) + alpha * proposal.squares()
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
