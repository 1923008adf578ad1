"""Networks of one hidden layer with linear outputs: parameters and outputs, linearised; on any device.

All tensors carry a leading axis B: independent networks (actuators, restarts, left-out folds) advance
together.

Gauss–Newton equations are solved without forming the matrix. A network of H hidden nodes and M outputs has 2H +
M(H+1) parameters. With one α (weights) and one β (errors) for all of them, β JᵀJ + α I is a block arrow: M equal
blocks S = β ZᵀZ + α I of order H+1, one for the weights into each output, and a border of the 2H hidden
parameters. So a step costs one factorization of Z and one system of order 2H, whatever M is, and so do the trace
and the determinant for MacKay's evidence. Moreover ‖·‖² and JᵀJ are invariant under a rotation of the M outputs:
`analysis.compensation.training` rotates 512 taps to the few directions that the training filters span.

Arrays are numpy's on the processor and tensors of torch on any other device. The code here and in `bayesian` uses
only functions that both have (array API standard). So torch, whose import takes two seconds of processor time, is
imported only for other devices.
"""

from dataclasses import dataclass, fields
from typing import Any, Self, TypeAlias

import numpy as np

from analysis.arrays import Real

Tensor: TypeAlias = Any
"""A float64 ndarray or torch.Tensor."""


@dataclass(frozen=True)
class Weights:
    """Parameters of B networks.

    Attributes
    ----------
    slope, bias : (B, H) Tensor
        Of the hidden nodes tanh(slope · x + bias).
    output : (B, H+1, k) Tensor
        Weights from the hidden nodes, and last the output biases, in k rotated outputs.
    """

    slope: Tensor
    bias: Tensor
    output: Tensor

    def squares(self) -> Tensor:
        """Sum (B,) of all squared parameters: E_W."""
        return (self.slope**2).sum(1) + (self.bias**2).sum(1) + (self.output**2).sum((1, 2))

    def moved(self, step: "Weights") -> "Weights":
        """Weights plus a step."""
        return Weights(self.slope + step.slope, self.bias + step.bias, self.output + step.output)

    def of(self, which: Tensor) -> Self:
        """Return those of the networks for which `which` (B,) is true."""
        return type(self)(self.slope[which], self.bias[which], self.output[which])

    def chosen(self, which: Tensor, other: "Weights") -> "Weights":
        """Self where `which` (B,) is true, else `other`."""
        xp, one, two = namespace(which), which[:, None], which[:, None, None]
        return Weights(
            xp.where(one, self.slope, other.slope),
            xp.where(one, self.bias, other.bias),
            xp.where(two, self.output, other.output),
        )


@dataclass(frozen=True)
class Linearised:
    """Networks at their present weights.

    Attributes
    ----------
    features : (B, n, H+1) Tensor
        Z: hidden outputs and a column of ones; rows of samples left out are zero.
    slopes : (B, n, 2H) Tensor
        Derivative of the hidden outputs by slope, then by bias.
    error : (B, n, k) Tensor
        Network minus target.
    rotated : (B, n, 2H) Tensor
        `slopes` along the left singular vectors of Z, all n.
    right : (B, H+1, H+1) Tensor
        Right singular vectors, in rows.
    power : (B, max(n, H+1)) Tensor
        Squared singular values, filled with zeros.
    overlap : (B, 2H, 2H) Tensor
        Products of the hidden nodes' weights into the outputs, for slopes and biases alike.
    """

    features: Tensor
    slopes: Tensor
    error: Tensor
    rotated: Tensor
    right: Tensor
    power: Tensor
    overlap: Tensor

    def of(self, which: Tensor) -> Self:
        """Return those of the networks for which `which` (B,) is true."""
        return type(self)(*(getattr(self, field.name)[which] for field in fields(self)))


def predict(weights: Weights, inputs: Tensor) -> Tensor:
    """Return the outputs (B, n, k) of the networks at `inputs` (n,)."""
    xp = namespace(inputs)
    hidden = xp.tanh(weights.slope[:, None, :] * inputs[:, None] + weights.bias[:, None, :])
    return hidden @ weights.output[:, :-1] + weights.output[:, -1:]


def errors(weights: Weights, inputs: Tensor, targets: Tensor, used: Tensor) -> Tensor:
    """Network minus target, zero for samples that are not used.

    Parameters
    ----------
    inputs : (n,) Tensor
    targets : (B, n, k) Tensor
    used : (B, n) Tensor
        1, or 0 for samples left out.

    Returns
    -------
    (B, n, k) Tensor
    """
    return (predict(weights, inputs) - targets) * used[:, :, None]


def linearise(weights: Weights, inputs: Tensor, targets: Tensor, used: Tensor) -> Linearised:
    """Linearise networks about their weights.

    Parameters
    ----------
    inputs : (n,) Tensor
    targets : (B, n, k) Tensor
    used : (B, n) Tensor
        1, or 0 for samples left out.
    """
    xp = namespace(inputs)
    hidden = xp.tanh(weights.slope[:, None, :] * inputs[:, None] + weights.bias[:, None, :])
    features = xp.concat([hidden, xp.ones_like(hidden[..., :1])], 2) * used[:, :, None]
    derivative = (1.0 - hidden**2) * used[:, :, None]
    left, values, right = xp.linalg.svd(features, full_matrices=True)
    power = xp.zeros_like(left[:, 0] if features.shape[1] > features.shape[2] else right[:, 0])
    power[:, : values.shape[1]] = values**2
    slopes = xp.concat([derivative * inputs[:, None], derivative], 2)
    outward = weights.output[:, :-1]
    return Linearised(
        features,
        slopes,
        errors(weights, inputs, targets, used),
        left.mT @ slopes,
        right,
        power,
        xp.tile(outward @ outward.mT, (1, 2, 2)),
    )


def step(weights: Weights, at: Linearised, alpha: Tensor, beta: Tensor, damping: Tensor) -> Weights:
    """Levenberg–Marquardt step of β E_D + α E_W: solves (β JᵀJ + (α + μ) I) d = -(β Jᵀe + α w).

    Parameters
    ----------
    at : Linearised
        The networks at `weights`.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    damping : (B,) Tensor
        μ, added to α in the matrix alone.

    Returns
    -------
    Weights
        The step d, to be added to `weights`.

    Raises
    ------
    LinAlgError
        Of numpy or torch, where the border matrix is singular to the digits at hand.
    """
    xp, a, b = namespace(alpha), alpha[:, None, None], beta[:, None, None]
    ridge = alpha + damping
    hidden = weights.output[:, :-1]
    gradient = b * at.features.mT @ at.error + a * weights.output
    pulled = at.error @ hidden.mT
    own = beta[:, None] * (at.slopes * xp.concat([pulled, pulled], 2)).sum(1) + alpha[:, None] * xp.concat(
        [weights.slope, weights.bias], 1
    )
    solved = _solve_outputs(at, gradient, ridge, beta)
    coupled = at.features @ solved @ hidden.mT
    own = own - beta[:, None] * (at.slopes * xp.concat([coupled, coupled], 2)).sum(1)
    move = -xp.linalg.solve(_border(at, ridge, beta), own[..., None])[..., 0]
    nodes = weights.slope.shape[1]
    slope, bias = move[:, :nodes], move[:, nodes:]
    by_slope, by_bias = at.slopes[..., :nodes], at.slopes[..., nodes:]
    tilt = by_slope * slope[:, None, :] + by_bias * bias[:, None, :]
    change = _solve_outputs(at, b * at.features.mT @ (tilt @ hidden), ridge, beta)
    return Weights(slope, bias, -solved - change)


def inverse_trace(at: Linearised, alpha: Tensor, beta: Tensor, outputs: int) -> Tensor:
    """Trace of (β JᵀJ + α I)⁻¹, from the blocks of the arrow and its border.

    Parameters
    ----------
    at : Linearised
        The networks at their weights.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    outputs : int
        Outputs M of a network, rotated away or not.

    Returns
    -------
    (B,) Tensor

    Raises
    ------
    LinAlgError
        Of numpy or torch, where the border matrix is singular to the digits at hand.
    """
    order = at.right.shape[-1]
    blocks = outputs * (1.0 / (beta[:, None] * at.power[:, :order] + alpha[:, None])).sum(1)
    count = at.rotated.shape[1]
    weight = beta[:, None] ** 2 * at.power[:, :count] / (beta[:, None] * at.power[:, :count] + alpha[:, None]) ** 2
    through = (at.rotated.mT * weight[:, None, :]) @ at.rotated * at.overlap
    xp = namespace(alpha)
    border = xp.linalg.solve(_border(at, alpha, beta), _identity(through) + through)
    return blocks + xp.linalg.diagonal(border).sum(1)


def log_determinant(at: Linearised, alpha: Tensor, beta: Tensor, outputs: int) -> Tensor:
    """Logarithm of the determinant of β JᵀJ + α I, from the blocks of the arrow and its border.

    Parameters
    ----------
    at : Linearised
        The networks at their weights.
    alpha, beta : (B,) Tensor
        Weights of the squared parameters and of the squared scaled errors.
    outputs : int
        Outputs M of a network, rotated away or not.

    Returns
    -------
    (B,) Tensor

    Raises
    ------
    LinAlgError
        Of numpy or torch, where the border matrix is singular to the digits at hand.
    """
    xp, order = namespace(alpha), at.right.shape[-1]
    blocks = outputs * xp.log(beta[:, None] * at.power[:, :order] + alpha[:, None]).sum(1)
    return blocks + xp.linalg.slogdet(_border(at, alpha, beta))[1]


def _solve_outputs(at: Linearised, right_hand: Tensor, ridge: Tensor, beta: Tensor) -> Tensor:
    order = at.right.shape[-1]
    scale = 1.0 / (beta[:, None] * at.power[:, :order] + ridge[:, None])
    return at.right.mT @ (scale[:, :, None] * (at.right @ right_hand))


def _border(at: Linearised, ridge: Tensor, beta: Tensor) -> Tensor:
    """Schur complement (B, 2H, 2H) of the output blocks.

    Written as Dᵀ(I + β/ridge ZZᵀ)⁻¹D, whose eigenvalues are positive term by term; subtracting
    β² DᵀZ S⁻¹ ZᵀD from β DᵀD loses all digits once β ZᵀZ dwarfs the ridge.
    """
    count = at.rotated.shape[1]
    weight = beta[:, None] * ridge[:, None] / (beta[:, None] * at.power[:, :count] + ridge[:, None])
    schur = (at.rotated.mT * weight[:, None, :]) @ at.rotated * at.overlap
    return schur + ridge[:, None, None] * _identity(schur)


def _identity(like: Tensor) -> Tensor:
    return namespace(like).eye(like.shape[-1], dtype=like.dtype, device=like.device)


def namespace(array: Tensor) -> Any:
    """Return the module whose functions take `array`: numpy or torch."""
    if isinstance(array, np.ndarray):
        return np
    import torch

    return torch


def on_device(array: Real, device: str) -> Tensor:
    """Return the array as it is for ``cpu``, else a tensor on torch's `device`."""
    found = np.ascontiguousarray(array, dtype=np.float64)
    if device == "cpu":
        return found
    import torch

    return torch.as_tensor(found, device=device)


def on_processor(tensor: Tensor) -> Real:
    """Return a numpy array with the values of a `tensor`."""
    return tensor if isinstance(tensor, np.ndarray) else np.asarray(tensor.cpu().numpy())
