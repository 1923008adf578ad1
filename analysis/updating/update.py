"""Model updating of a campaign: E, nu, eta of every sweep and one gain over all of them.

The misfit is the paper's eq. (12), each line weighted by its variance. First every sweep is fitted on its
own, gain included, walking outwards from a sweep in the middle so that each starts from its neighbour; then
the gains are tied into one.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from analysis.frf import Frf
from analysis.material import Material, MaterialBox
from analysis.updating.common_gain import fit_common_gain
from analysis.updating.model import TransferModel
from analysis.updating.normal_equations import NormalEquations, SweepData
from analysis.updating.start import start_material
from analysis.updating.sweep_fit import SweepFit, fit_sweep

Progress = Callable[[str, float], None]

LINES_OF_THE_WALK = 500
"""Lines that take part while sweeps are fitted on their own, where modes are many lines wide; the end uses all."""
LINES_OF_A_MODE = 2.0
"""Lines that a resonance keeps over its half-power width, at the middle of the box's loss factors."""
STRAYED = 3.0
"""A misfit this many times the neighbour's is taken for a wrong minimum: the sweep starts from the grid."""


@dataclass(frozen=True)
class Updated:
    """Result of model updating, one row per sweep in the order of the FRFs.

    Attributes
    ----------
    temperature : (T,) ndarray
        Mean oven reading, degrees Celsius.
    material, sigma : Material
        Estimates and their standard deviations, (T,) arrays; sigma is that of the noise, inflated by
        sqrt(chi2_per_dof) where the twin misses more than the noise.
    correlation : (T, 4, 4) ndarray
        Of log E, nu, log eta and log gain, as one sweep alone would see them.
    gain, sigma_gain : float
        Amplifier gain common to all sweeps, V/V.
    misfit_start, misfit : (T,) ndarray
        rms|H - gV| / rms|H| where a sweep's fit began, and at the end.
    noise_floor : (T,) ndarray
        What the misfit would be were the twin perfect.
    chi2_per_dof : (T,) ndarray
    settled : (T,) bool ndarray
        False where the fit ran into the model's box or did not converge.
    """

    temperature: NDArray[np.float64]
    material: Material
    sigma: Material
    correlation: NDArray[np.float64]
    gain: float
    sigma_gain: float
    misfit_start: NDArray[np.float64]
    misfit: NDArray[np.float64]
    noise_floor: NDArray[np.float64]
    chi2_per_dof: NDArray[np.float64]
    settled: NDArray[np.bool_]


def update(
    frf: Frf,
    model: TransferModel,
    *,
    begin: NDArray[np.float64] | None = None,
    progress: Progress | None = None,
) -> Updated:
    """Fit the model's material to every sweep of `frf`, with one gain over all sweeps.

    Parameters
    ----------
    frf : Frf
        Measured; lines in `frf.excluded` take no part.
    model : TransferModel
        The twin, asked inside its box only.
    begin : (3,) ndarray, optional
        E, nu and eta near those of `middle_sweep`; else the start grid finds them.
    progress : callable, optional
        Called with a stage's name and the share of it done.

    Raises
    ------
    ValueError
        Where lines carry no variance, so that no weight can be given.
    """
    frf.require_noise()
    report = progress or (lambda stage, share: None)
    coarse = [SweepData.of(frf, t, stride(frf, model.box)) for t in range(len(frf.temperature))]
    data = [SweepData.of(frf, t) for t in range(len(frf.temperature))]
    order = [int(t) for t in np.argsort(frf.temperature, kind="stable")]
    middle = order.index(middle_sweep(frf))
    if begin is None:
        begin = start_material(model, coarse[order[middle]], lambda share: report("start grid", share))
    fits = {order[middle]: fit_sweep(model, coarse[order[middle]], begin)}

    def advance() -> None:
        report("sweeps", len(fits) / len(order))

    with ThreadPoolExecutor(2) as pool:
        ways = (order[middle:], order[middle::-1])
        for walk in [pool.submit(_walk, model, coarse, way, fits, advance) for way in ways]:
            walk.result()
        report("common gain", 0.0)
        points, sigma = fit_common_gain(model, data, [fits[t].point for t in range(len(order))], pool)
    report("common gain", 1.0)
    return _summary(frf, model, points, sigma, [fits[t] for t in range(len(order))])


def middle_sweep(frf: Frf) -> int:
    """Return the sweep from which the others are reached."""
    return int(np.argsort(frf.temperature, kind="stable")[len(frf.temperature) // 2])


def stride(frf: Frf, box: MaterialBox) -> int:
    """Return how many lines on is the next that takes part in fits of single sweeps."""
    lines = frf.frequency
    width = float(np.sqrt(np.prod(box.loss_factor)) * np.sqrt(lines[0] * lines[-1]))
    enough = width / (LINES_OF_A_MODE * float(lines[1] - lines[0]))
    return max(1, min(len(lines) // LINES_OF_THE_WALK, int(enough)))


def _walk(
    model: TransferModel,
    data: Sequence[SweepData],
    way: Sequence[int],
    fits: dict[int, SweepFit],
    advance: Callable[[], None],
) -> None:
    """Fit sweep after sweep along `way`, whose first is fitted, each from where its neighbours point."""
    trend = np.ones(3)
    for before, sweep in pairwise(way):
        known = fits[before].point
        fit = fit_sweep(model, data[sweep], known.material * trend)
        if not fit.settled or fit.point.misfit > STRAYED * known.misfit:
            again = fit_sweep(model, data[sweep], start_material(model, data[sweep]))
            fit = min(fit, again, key=lambda f: f.point.chi2)
        fits[sweep] = fit
        trend = np.clip(fit.point.material / known.material, 0.8, 1.25)
        advance()


def _summary(
    frf: Frf,
    model: TransferModel,
    points: Sequence[NormalEquations],
    sigma_log_gain: float,
    fits: Sequence[SweepFit],
) -> Updated:
    """Collect the settled sweeps into one value."""
    materials = np.array([p.material for p in points])
    chi2_per_dof = np.array([p.chi2 / p.dof for p in points])
    covariance = np.array([np.linalg.inv(p.matrix) for p in points])
    spread = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    gain = points[0].gain
    # with the gain common, a sweep's material has its own noise and what the gain's leaves
    own = np.array([np.linalg.inv(p.matrix[:3, :3]) for p in points])
    lever = np.array([np.linalg.solve(p.matrix[:3, :3], p.matrix[:3, 3]) for p in points])
    variance = np.diagonal(own, axis1=1, axis2=2) + (lever * sigma_log_gain) ** 2
    sigma = np.sqrt(variance * np.maximum(chi2_per_dof, 1.0)[:, None])
    inside = np.all(np.isclose(model.box.clip(materials * (1 + 1e-6)), materials * (1 + 1e-6), rtol=1e-12), axis=1)
    inside &= np.all(
        np.isclose(model.box.clip(materials * (1 - 1e-6)), materials * (1 - 1e-6), rtol=1e-12), axis=1
    )
    return Updated(
        temperature=frf.temperature,
        material=Material(*materials.T),
        sigma=Material(sigma[:, 0] * materials[:, 0], sigma[:, 1], sigma[:, 2] * materials[:, 2]),
        correlation=covariance / (spread[:, :, None] * spread[:, None, :]),
        gain=gain,
        sigma_gain=gain * sigma_log_gain * float(np.sqrt(max(float(np.mean(chi2_per_dof)), 1.0))),
        misfit_start=np.array([f.misfit_start for f in fits]),
        misfit=np.array([p.misfit for p in points]),
        noise_floor=frf.noise_floor,
        chi2_per_dof=chi2_per_dof,
        settled=np.array([f.settled for f in fits]) & model.box.inside(materials),
    )
