"""Where networks are trained: arrays of numpy on the processor, tensors of torch on any other device.

What stands in `linearised`, `schur_complement`, `evidence` and `bayesian` is written with the functions that both
share (those of the array API standard), so that torch, two seconds of processor time to import, is loaded where
it is asked for and nowhere else.
"""

from typing import Any, TypeAlias

import numpy as np

from analysis.arrays import Real

Tensor: TypeAlias = Any
"""A float64 ndarray or torch.Tensor."""


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
