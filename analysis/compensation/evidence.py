"""MacKay's evidence of networks: weights of parameters and errors, estimated from the data.

Foresee and Hagan (1997): γ = P - α tr(β JᵀJ + α I)⁻¹ (the parameters the data determine), α = γ/(2 E_W),
β = (n M - γ)/(2 E_D).
"""

from dataclasses import dataclass, replace
from typing import Self

from analysis.compensation.linearised import Linearised, Weights, inverse_trace, log_determinant
from analysis.compensation.tensors import Tensor, namespace


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
    # An exact fit would send beta to infinity; the floor is far below any rounding of the errors.
    xp = namespace(problem.inputs)
    squares = xp.clip(squared_error(at.error), 1e-30 * float(problem.outputs), None)
    return gamma / (2.0 * weights.squares()), xp.clip(problem.error_count - gamma, 1e-3, None) / (2.0 * squares)


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
