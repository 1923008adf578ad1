"""Bayesian regularisation of one-hidden-layer networks: Levenberg–Marquardt with MacKay's evidence.

Foresee and Hagan (1997): minimise β E_D + α E_W by Levenberg–Marquardt; after every step re-estimate α and β
(`analysis.compensation.evidence`). Nothing else is approximated; `analysis.compensation.linearised` explains
why it is fast nevertheless.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

from analysis.compensation.evidence import (
    Evidence,
    TrainingProblem,
    first_estimate,
    judge,
    reestimate,
    squared_error,
)
from analysis.compensation.linearised import Linearised, Weights, errors, linearise, step
from analysis.compensation.tensors import Tensor, namespace

STILL_STEPS = 20.0
"""Number of successive steps without a change after which a training ends."""
LARGEST_DAMPING = 1e10
"""Damping at which a training ends: no step lets the objective fall in double precision."""


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


@dataclass(frozen=True)
class _Training:
    """State of some networks of a batch between two steps; tensors are (b,), or (b, ...).

    Attributes
    ----------
    problem : TrainingProblem
    weights : Weights
    at : Linearised
        The networks at `weights`.
    alpha, beta, damping : (b,) Tensor
    still, tried : (b,) Tensor
        Successive steps without a change, and all steps.
    members : (b,) Tensor of int
        Which networks of the whole batch these are.
    """

    problem: TrainingProblem
    weights: Weights
    at: Linearised
    alpha: Tensor
    beta: Tensor
    damping: Tensor
    still: Tensor
    tried: Tensor
    members: Tensor

    def of(self, which: Tensor) -> Self:
        """Return those of the networks for which `which` (b,) is true."""
        names = ("alpha", "beta", "damping", "still", "tried", "members")
        kept = {name: getattr(self, name)[which] for name in names}
        return replace(
            self,
            problem=self.problem.of(which),
            weights=self.weights.of(which),
            at=self.at.of(which),
            **kept,
        )

    def stepped(self, tolerance: float) -> Self:
        """Try a step of every network; keep the steps that reduce the objective, and estimate α and β again."""
        xp, problem, weights = namespace(self.alpha), self.problem, self.weights
        alpha, beta, damping, still = self.alpha, self.beta, self.damping, self.still
        objective = beta * squared_error(self.at.error) + alpha * weights.squares()
        proposal = weights.moved(step(weights, self.at, alpha, beta, damping))
        trial = errors(proposal, problem.inputs, problem.targets, problem.used)
        reached = beta * squared_error(trial) + alpha * proposal.squares()
        better = reached < objective
        damping = xp.where(better, xp.clip(0.1 * damping, 1e-20, None), 10.0 * damping)
        changed = replace(self, tried=self.tried + 1, damping=damping)
        if not better.any():
            return changed
        weights = proposal.chosen(better, weights)
        at = linearise(weights, problem.inputs, problem.targets, problem.used)
        new_alpha, new_beta = reestimate(problem, weights, at, alpha, beta)
        sound = (new_alpha > 0.0) & xp.isfinite(new_alpha)
        quiet = (objective - reached < tolerance * objective) & (abs(new_alpha / alpha - 1) < tolerance)
        still = xp.where(better, xp.where(quiet, still + 1, 0.0), still)
        still = xp.where(better & ~sound, STILL_STEPS, still)
        kept = better & sound
        alpha, beta = xp.where(kept, new_alpha, alpha), xp.where(kept, new_beta, beta)
        return replace(changed, weights=weights, at=at, alpha=alpha, beta=beta, still=still)


def train(
    problem: TrainingProblem,
    start: Weights,
    epochs: int = 1000,
    tolerance: float = 1e-6,
    progress: Callable[[int], None] | None = None,
) -> BayesianFit:
    """Train B networks from `start` until each has converged or has had `epochs` steps.

    A network has converged when in `STILL_STEPS` successive steps neither its objective nor α changed by more than
    `tolerance`, relative, or when the damping exceeds 1e10: the objective no longer falls in double precision.
    Training also stops where the evidence collapses, so that numerically the data determine no parameter.

    Parameters
    ----------
    start : Weights
        First weights of the B networks.
    epochs : int
        Largest number of steps tried.
    tolerance : float
        Relative change below which objective and α count as unchanged.
    progress : callable, optional
        Called with the number of every step done, from 0.

    Returns
    -------
    BayesianFit
        Weights, evidence and steps tried of every network.
    """
    at = linearise(start, problem.inputs, problem.targets, problem.used)
    alpha, beta = first_estimate(problem, start, at)
    xp, none = namespace(alpha), 0.0 * alpha
    members = xp.arange(len(alpha), device=alpha.device)
    now = _Training(problem, start, at, alpha, beta, none + 5e-3, none, none, members)
    ended = []
    for epoch in range(epochs):
        running = (now.still < STILL_STEPS) & (now.damping <= LARGEST_DAMPING)
        if not running.all():  # networks that have ended are no longer computed
            ended.append(now.of(~running))
            now = now.of(running)
        if not len(now.members):
            break
        now = now.stepped(tolerance)
        if progress is not None:
            progress(epoch)
    ended.append(now)
    order = xp.argsort(xp.concat([one.members for one in ended]))

    def joined(parts: list[Tensor]) -> Tensor:
        return xp.concat(parts)[order]

    alpha, beta = joined([one.alpha for one in ended]), joined([one.beta for one in ended])
    slope, bias = joined([one.weights.slope for one in ended]), joined([one.weights.bias for one in ended])
    weights = Weights(slope, bias, joined([one.weights.output for one in ended]))
    at = linearise(weights, problem.inputs, problem.targets, problem.used)
    evidence = judge(problem, weights, at, alpha, beta)
    return BayesianFit(weights, evidence, joined([one.tried for one in ended]))
