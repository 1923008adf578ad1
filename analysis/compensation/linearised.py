"""Networks of one hidden layer with linear outputs: their parameters, their outputs, and both linearised.

All tensors carry a leading axis B: independent networks (actuators, restarts, left-out folds) advance
together.
"""

from dataclasses import dataclass, fields
from typing import Self

from analysis.compensation.tensors import Tensor, namespace


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
