"""A measured FRF transformed to that of a plate with more damping, so that fits converge from poor start values.

A causal response is analytic where damping grows: its mean over a Cauchy (Lorentz) kernel of half-width s is the
response at the frequency f - js. With s = eta f/2 that is the plate with a loss factor larger by eta; noise is
averaged as well. A fit starts with wide resonances, whose minima overlap, and follows the data to narrow ones.
"""

from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.twin_model import TwinModel
from analysis.updating.normal_equations import SweepData
from analysis.updating.sweep_fit import fit_sweep

PER_WIDTH = 3.0
"""Number of lines within the half-power width of a broadened resonance."""
NARROWER = 3.0
"""Ratio of the broadenings of two stages."""
RATIOS = 5
"""Poisson's ratios from which fits start."""
NARROWEST = 1.5
"""Width of the lowest resonance, in lines, above which the data are not broadened."""


def broadened(data: SweepData, loss_factor: float) -> SweepData:
    """Return the data of the plate with a loss factor larger by `loss_factor`, on as few lines as needed."""
    f = data.frequency
    count = int(np.ceil(np.log(f[-1] / f[0]) * PER_WIDTH / loss_factor)) + 1
    centers = np.geomspace(f[0], f[-1], min(count, f.size))
    kernel = cauchy_kernel(f, centers, loss_factor)
    variance = (1.0 / data.weight) @ (kernel**2).T
    return replace(data, frequency=centers, h=data.h @ kernel.T, weight=1.0 / variance)


def cauchy_kernel(frequency: Real, centers: Real, loss_factor: float) -> Real:
    """Weights of the lines in responses with a loss factor larger by `loss_factor`.

    Parameters
    ----------
    frequency : (F,) ndarray
        Lines, Hz.
    centers : (C,) ndarray
        Where the responses are wanted, Hz.

    Returns
    -------
    (C, F) ndarray
        Of sum 1 over the lines.
    """
    half = 0.5 * loss_factor * centers[:, None]
    kernel = half / ((frequency[None, :] - centers[:, None]) ** 2 + half**2) * np.gradient(frequency)
    kernel /= kernel.sum(axis=1, keepdims=True)
    return np.asarray(kernel)


def narrowed(model: TwinModel, data: SweepData, moduli: Real) -> list[Real]:
    """Return start values reached by fits to data of less and less added damping.

    `moduli` (N,) lie as close as resonances of half the box's largest loss factor need them.

    Parameters
    ----------
    moduli : (N,) ndarray
        Young's moduli to start from, Pa, spaced for resonances with half the box's largest loss factor.

    Returns
    -------
    list of (3,) ndarray
        E [Pa], nu and eta, best first.
    """
    broad = 0.5 * model.box.loss_factor[1]
    own = max(model.box.loss_factor[0], 0.1 * broad)
    wide = broadened(data, broad)
    places = []
    for nu in np.linspace(*model.box.poisson_ratio, RATIOS + 2)[1:-1]:
        misfits = [_misfit(model, wide, float(e), float(nu), broad + own) for e in moduli]
        places.append((min(misfits), float(moduli[int(np.argmin(misfits))]), float(nu)))
    return [_followed(model, data, np.array([e, nu, broad + own]), broad) for _, e, nu in sorted(places)]


def _followed(model: TwinModel, data: SweepData, material: Real, broad: float) -> Real:
    """Material (3,) fitted to data of decreasing broadening, from `broad` to none."""
    spacing = float(np.median(np.diff(data.frequency)))
    least = model.box.loss_factor[0]
    while True:
        fitted = fit_sweep(model, broadened(data, broad), material).material
        own = max(float(fitted[2]) - broad, least)
        broad /= NARROWER
        if broad * data.frequency[0] < NARROWEST * spacing:
            return np.array([fitted[0], fitted[1], own])
        material = np.array([fitted[0], fitted[1], own + broad])


def _misfit(model: TwinModel, data: SweepData, e: float, nu: float, eta: float) -> float:
    """Unexplained share of the data's power with the best real gain; half of each power where signs disagree."""
    transfer = data.answer(model, (e, nu, eta))
    product = float((transfer.conj() * data.h).real.sum())
    size = float((np.abs(transfer) ** 2).sum() * (np.abs(data.h) ** 2).sum())
    return 1.0 - max(product, 0.0) ** 2 / size
