"""Bayesian regularisation of one-hidden-layer networks: Levenberg–Marquardt with MacKay's evidence.

Foresee and Hagan (1997): minimise β E_D + α E_W by Levenberg–Marquardt; after every step re-estimate the weights
of parameters and errors from the data, with γ = P - α tr(β JᵀJ + α I)⁻¹ the parameters the data determine,

    α = γ/(2 E_W),   β = (n M - γ)/(2 E_D).

Nothing else is approximated; `analysis.compensation.linearised` explains why it is fast nevertheless.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

from analysis.compensation.linearised import (
    Linearised,
    Tensor,
    Weights,
    errors,
    inverse_trace,
    linearise,
    log_determinant,
    namespace,
    step,
)

STILL_STEPS = 20.0
"""Number of successive steps without a change after which a training ends."""
LARGEST_DAMPING = 1e10
"""Damping at which a training ends: no step lets the objective fall in double precision."""


@dataclass(frozen=True)
class TrainingProblem:
    """Training data of B networks, with rotated outputs.

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

    def of(self, which: Tensor) -> Self:
        """Return the training data of those networks for which `which` (B,) is true."""
        return replace(self, targets=self.targets[which], used=self.used[which])

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


def first_estimate(problem: TrainingProblem, weights: Weights, at: Linearised) -> tuple[Tensor, Tensor]:
    """Estimate α, β with γ = P, or γ = half the number of errors where P is as large.

    Foresee and Hagan begin with γ = P. Where there are as many parameters as errors, this gives no β, and β = 1
    instead destroys the ridge fit of the output layer: the evidence then converges to constant outputs.

    Parameters
    ----------
    weights : Weights
        First weights.
    at : Linearised
        The networks at `weights`.

    Returns
    -------
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    """
    xp = namespace(problem.inputs)
    count = xp.full_like(problem.error_count, parameter_count(weights, problem.outputs))
    gamma = xp.where(count < problem.error_count, count, 0.5 * problem.error_count)
    return _maximised(problem, weights, at, gamma)


def reestimate(
    problem: TrainingProblem, weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor
) -> tuple[Tensor, Tensor]:
    """One round of MacKay's α = γ/(2 E_W) and β = (n M - γ)/(2 E_D).

    Parameters
    ----------
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
    # An exact fit would send beta to infinity, weights that are all zero alpha; the floor is far below rounding.
    xp, least = namespace(problem.inputs), 1e-30 * float(problem.outputs)
    squares = xp.clip(squared_error(at.error), least, None)
    sizes = xp.clip(weights.squares(), least, None)
    return gamma / (2.0 * sizes), xp.clip(problem.error_count - gamma, 1e-3, None) / (2.0 * squares)


def determined(problem: TrainingProblem, weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor) -> Tensor:
    """Count the parameters the data determine: γ = P - α tr(β JᵀJ + α I)⁻¹.

    Parameters
    ----------
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
    LinAlgError
        Of numpy or torch, where the border matrix is numerically singular.
    """
    count = parameter_count(weights, problem.outputs)
    return count - alpha * inverse_trace(at, alpha, beta, problem.outputs)


def judge(problem: TrainingProblem, weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor) -> Evidence:
    """Evidence of networks at their weights, by Laplace's approximation.

    ln p(D) = -β E_D - α E_W - ½ ln|β JᵀJ + α I| + P/2 ln α + nM/2 ln(β/π).

    Parameters
    ----------
    at : Linearised
        The networks at `weights`.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.

    Returns
    -------
    Evidence
        α, β, γ and the logarithm of the evidence of each of the B networks.
    """
    xp, count = namespace(problem.inputs), parameter_count(weights, problem.outputs)
    fit = -beta * squared_error(at.error) - alpha * weights.squares()
    occam = -0.5 * log_determinant(at, alpha, beta, problem.outputs) + 0.5 * count * xp.log(alpha)
    noise = 0.5 * problem.error_count * xp.log(beta / xp.pi)
    return Evidence(alpha, beta, determined(problem, weights, at, alpha, beta), fit + occam + noise)


def parameter_count(weights: Weights, outputs: int) -> int:
    """Parameters of one network with `outputs` outputs."""
    nodes: int = weights.slope.shape[1]
    return 2 * nodes + outputs * (nodes + 1)


def squared_error(error: Tensor) -> Tensor:
    """Sum (B,) of the squared errors (B, n, k): E_D."""
    return (error**2).sum((1, 2))


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
