"""The start grid: a first material near enough that no fit can land in a neighbouring minimum."""

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.typing import NDArray

from analysis.updating.model import TransferModel
from analysis.updating.normal_equations import SweepData, best_gain

MODULUS_STEP = 1.07
"""Resonances of a plate with eta = 0.04 stay within each other's half-power bandwidth over this ratio of E."""


def in_phase(transfer: NDArray[np.complex128], data: SweepData) -> NDArray[np.float64]:
    """Correlation of a transfer (K, F) with the data of each channel, (K,), -1 to 1: negative where inverted."""
    product = (data.weight * (transfer.conj() * data.h).real).sum(1)
    power = (data.weight * np.abs(transfer) ** 2).sum(1) * (data.weight * np.abs(data.h) ** 2).sum(1)
    correlation: NDArray[np.float64] = product / np.sqrt(power)
    return correlation


def start_material(
    model: TransferModel,
    data: SweepData,
    progress: Callable[[float], None] = lambda share: None,
    *,
    signed: bool = True,
) -> NDArray[np.float64]:
    """Best (E, nu, eta), a (3,) ndarray, of a grid over the model's box, the gain eliminated.

    The grid of E and nu is walked at a loss factor near the top of the box, where the minima are widest;
    eta follows on its own. Unless `signed`, every channel may have either sign.
    """

    def misfit(e: float, nu: float, eta: float) -> float:
        transfer = model.frf(e, nu, eta, data.frequency)
        sign = 1.0 if signed else np.where(in_phase(transfer, data) < 0.0, -1.0, 1.0)[:, None]
        return best_gain(sign * transfer, data)[1]

    box = model.box
    low, high = box.youngs_modulus
    moduli = np.geomspace(low, high, int(np.ceil(np.log(high / low) / np.log(MODULUS_STEP))) + 1)
    nu_low, nu_high = box.poisson_ratio
    ratios = nu_low + (nu_high - nu_low) * np.array([0.2, 0.5, 0.85])
    eta_low, eta_high = max(box.loss_factor[0], 0.005), 0.8 * box.loss_factor[1]
    grid = list(product(moduli, ratios))
    misfits = []
    for done, (e, nu) in enumerate(grid):
        misfits.append(misfit(e, nu, eta_high))
        progress((done + 1) / len(grid))
    e, nu = grid[int(np.argmin(misfits))]
    etas = np.geomspace(eta_low, eta_high, 5)
    misfits = [misfit(e, nu, eta) for eta in etas]
    return np.array([e, nu, etas[int(np.argmin(misfits))]])
