"""Arrays for the training of networks: numpy on the processor, torch tensors on any other device.

The code in `linearised` and `bayesian` uses only functions that both have (array
API standard). So torch, whose import takes two seconds of processor time, is imported only for other devices.
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
