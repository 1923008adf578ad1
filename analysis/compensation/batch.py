"""Training data scaled and rotated for a batch of networks, and their initial weights."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.compensation.evidence import TrainingProblem
from analysis.compensation.linearised import Weights, predict
from analysis.compensation.network import InputMap, NetworkBank
from analysis.compensation.settings import Training
from analysis.compensation.tensors import on_device, on_processor


@dataclass(frozen=True)
class Batch:
    """Scaled and rotated training data of B networks, and their first weights.

    Attributes
    ----------
    problem : TrainingProblem
    start : Weights
    axes : (B, k, M) ndarray
        Orthonormal rows: the directions of tap space that matter.
    scale, offset : (B, M) ndarray
        Taps are scale · output + offset.
    """

    problem: TrainingProblem
    start: Weights
    axes: Real
    scale: Real
    offset: Real

    def bank(self, weights: Weights, chosen: NDArray[np.int64], inputs: InputMap) -> NetworkBank:
        """Networks with rotation and scale undone, of the `chosen` members.

        Parameters
        ----------
        weights : Weights
            Of all B networks.
        chosen : (N,) ndarray of int
            Members of the batch, one per actuator.
        """
        output = on_processor(weights.output)[chosen] @ self.axes[chosen] * self.scale[chosen, None, :]
        output[:, -1] += self.offset[chosen]
        return NetworkBank(inputs, on_processor(weights.slope)[chosen], on_processor(weights.bias)[chosen], output)


def prepare(
    inputs: Real,
    targets: Real,
    used: Real,
    settings: Training,
    rng: np.random.Generator,
    device: str = "cpu",
    hidden: tuple[Real, Real] | None = None,
) -> Batch:
    """Scale and rotate targets, and draw first weights.

    Parameters
    ----------
    inputs : (n,) ndarray
        On -1..1.
    targets : (B, n, M) ndarray
        Taps, V per unit of audio signal.
    used : (B, n) ndarray
        1 for samples trained on, 0 for samples left out.
    rng : numpy Generator
        Draws the first weights.
    device : str
        To train on: ``cpu``, or torch's name of another.
    hidden : ((B, H) ndarray, (B, H) ndarray), optional
        Slope and bias of known hidden layers to start from; drawn where left out.
    """
    seen = np.where(used[:, :, None] > 0.0, targets, np.nan)
    low, high = np.nanmin(seen, axis=1), np.nanmax(seen, axis=1)
    offset, half = 0.5 * (high + low), 0.5 * (high - low)
    largest = half.max(axis=1, keepdims=True)
    # A tap that is the same at all temperatures has no scale of its own: only its offset is learnt.
    own: Real = np.where(half > 1e-12 * largest, half, largest)
    scale: Real = own if settings.scale == "tap" else np.broadcast_to(largest, half.shape)
    stretched = (targets - offset[:, None]) / scale[:, None]
    slope, bias = hidden if hidden is not None else _spread_nodes(len(targets), settings.nodes, rng)
    if settings.start == "warm":
        axes = np.linalg.svd(stretched, full_matrices=False)[2]
        rotated = stretched @ axes.transpose(0, 2, 1)
        output = _ridge(inputs, rotated, used, slope, bias)
    else:
        drawn = rng.uniform(-1.0, 1.0, size=(len(targets), settings.nodes + 1, targets.shape[-1]))
        joined = np.concatenate([stretched, drawn], axis=1)
        axes = np.linalg.svd(joined, full_matrices=False)[2]
        rotated = stretched @ axes.transpose(0, 2, 1)
        output = drawn @ axes.transpose(0, 2, 1)

    fed, wanted, counted = (on_device(array, device) for array in (inputs, rotated, used))
    start = Weights(*(on_device(array, device) for array in (slope, bias, output)))
    return Batch(TrainingProblem(fed, wanted, counted, targets.shape[-1]), start, axes, scale, offset)


def outputs_at(batch: Batch, weights: Weights, inputs: Real) -> Real:
    """Taps of a batch's networks, rotation and scale undone.

    Parameters
    ----------
    inputs : (n,) ndarray
        On -1..1.

    Returns
    -------
    (B, n, M) ndarray
        V per unit of audio signal.
    """
    held = Weights(*(on_processor(part) for part in (weights.slope, weights.bias, weights.output)))
    rotated = predict(held, inputs)
    taps: Real = rotated @ batch.axes * batch.scale[:, None, :] + batch.offset[:, None, :]
    return taps


def _spread_nodes(networks: int, nodes: int, rng: np.random.Generator) -> tuple[Real, Real]:
    """Hidden layers after Nguyen and Widrow (1990): bends spread evenly over -1..1, jittered."""
    slope = 0.7 * nodes * rng.choice([-1.0, 1.0], size=(networks, nodes))
    bends = np.linspace(-1.0, 1.0, nodes) if nodes > 1 else np.zeros(1)
    bends = bends + rng.uniform(-0.5, 0.5, size=(networks, nodes)) / nodes
    return slope, -slope * bends


def _ridge(inputs: Real, targets: Real, used: Real, slope: Real, bias: Real) -> Real:
    hidden = np.tanh(inputs[:, None] * slope[:, None, :] + bias[:, None, :])
    features = np.concatenate([hidden, np.ones((*hidden.shape[:2], 1))], axis=2) * used[:, :, None]
    gram: Real = features.transpose(0, 2, 1) @ features + 1e-6 * np.eye(features.shape[2])
    weights = np.linalg.solve(gram, features.transpose(0, 2, 1) @ (targets * used[:, :, None]))
    return np.asarray(weights, dtype=np.float64)
