"""Start values: a grid of materials, and fits from its minima until one explains the data; broadened data.

A causal response is analytic where damping grows: its mean over a Cauchy (Lorentz) kernel of half-width s is the
response at the frequency f - js. With s = eta f/2 that is the plate with a loss factor larger by eta; noise is
averaged as well. A fit starts with wide resonances, whose minima overlap, and follows the data to narrow ones.

Modulus scan: rough modulus from one sweep's resonances, because building a twin for the box takes minutes.

Power spectra of data and plate are smoothed over `WINDOW` of the frequency, so that neither damping nor model
errors of a per cent matter. They are compared as levels over log frequency, where a change of modulus (and nearly
so of thickness or density) is a shift.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count, product, repeat
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.declaration.plate import Plate
from analysis.declaration.plate_material import material_box
from analysis.forked import ForkedExecutor
from analysis.material import MaterialBox
from analysis.twin_model import TwinModel
from analysis.updating.normal_equations import SweepData, best_gain, fit_sweep

PER_WIDTH = 3.0
"""Number of lines within the half-power width of a broadened resonance."""
NARROWER = 3.0
"""Ratio of the broadenings of two stages."""
RATIOS_OF_BROADENED = 5
"""Poisson's ratios from which fits start."""
NARROWEST = 1.5
"""Width of the lowest resonance, in lines, above which the data are not broadened."""
MODULUS_STEP, RESONANCE_STEP = 1.15, 1.7
"""Largest step of the modulus in the grid, as a ratio and in loss factors: with the grid's damping, resonances of
neighbouring points stay within each other's half-power bandwidth. In 25 campaigns of a blind trial, on four
plates, the first fit explained every sweep, as it did with half the step."""
ROUGH, NOISY = 0.1, 2.0
"""A fit's minimum is accepted if its misfit, and the misfit's ratio to the noise, are below these."""
RATIOS = ((0.5,), (0.2, 0.85))
"""Relative position of Poisson's ratio in the box; the second grid is used if fits from the first fail."""
STARTS = 6
"""Number of a grid's minima from which a fit is started."""
SHARP = 0.05
"""Data are broadened for a start if the box's largest loss factor is below this; else resonances overlap."""
LEAST_LOSS = 0.005
"""Smallest loss factor at which fits start: wide resonances overlap with those of the solution."""


STRAIGHT, FIRST = 1.8, 3.6
"""Wave number times the longest distance on a plate: below the first nothing resonates by bending, a cantilever
(1.875) included; at the second a free plate has its first resonance, a square in torsion."""


def require_bending(plate: Plate, frequency: Real) -> None:
    """Refuse FRFs in whose band a plate is rigid: their unit is another one.

    Parameters
    ----------
    plate : Plate
    frequency : (F,) ndarray
        Hz.

    Raises
    ------
    ValueError
    """
    box = material_box(plate.material)
    stiffness = box.youngs_modulus[0] * plate.thickness**3 / (12.0 * (1.0 - box.poisson_ratio[0] ** 2))
    across = float(np.linalg.norm(np.subtract(*plate.bounds)))
    rigid, first = (
        (k / across) ** 2 * np.sqrt(stiffness / (plate.density * plate.thickness)) / (2.0 * np.pi)
        for k in (STRAIGHT, FIRST)
    )
    highest = float(frequency[-1])
    if highest < rigid:
        raise ValueError(
            f"the FRFs end at {highest:.3g} Hz, and a plate of these dimensions has no resonance below about "
            f"{first:.2g} Hz. Are the frequencies in kHz? Then write the unit where the file names them "
            "(frequency_khz). Else correct length, thickness or mass"
        )


def in_phase(transfer: NDArray[np.complex128], data: SweepData) -> Real:
    """Correlation of a transfer (K, F) with the data of each channel, (K,), -1 to 1: negative where inverted."""
    product = (data.weight * (transfer.conj() * data.h).real).sum(1)
    power = (data.weight * np.abs(transfer) ** 2).sum(1) * (data.weight * np.abs(data.h) ** 2).sum(1)
    correlation: Real = product / np.sqrt(power)
    return correlation


def start_material(
    model: TwinModel,
    data: SweepData,
    progress: Callable[[float], None] = lambda share: None,
    *,
    signed: bool = True,
) -> Real:
    """Best material found by fits that start from a grid over the model's box, with the gain eliminated.

    A grid of E, at the middle nu, is evaluated at a loss factor near the top of the box, where the minima are
    widest; eta is found by the fit. If the fit from the best point ends far from the data, the grid's other minima
    are tried, then those of a grid at other nu. Unless `signed`, every channel may have either sign.

    Parameters
    ----------
    progress : callable
        Called with the share done, which jumps to 1 if the first grid suffices.
    signed : bool
        False where channels may be inverted.

    Returns
    -------
    (3,) ndarray
        E [Pa], nu and eta.
    """
    best, least = np.zeros(3), np.inf
    for start in _starts(model, data, progress, signed=signed):
        matched = data if signed else _with_signs(data.answer(model, start), data)
        found = fit_sweep(model, matched, start)
        if found.misfit < least:
            best, least = found.material, found.misfit
        if least < max(ROUGH, NOISY * _noise(data)):
            break
    progress(1.0)
    return best


def _with_signs(transfer: NDArray[np.complex128], data: SweepData) -> SweepData:
    """Give every channel of the data the sign that agrees better with a transfer (K, F)."""
    return replace(data, h=np.where(in_phase(transfer, data) < 0.0, -1.0, 1.0)[:, None] * data.h)


def _starts(
    model: TwinModel, data: SweepData, progress: Callable[[float], None], *, signed: bool
) -> Iterator[Real]:
    """Yield E [Pa], nu and eta (3,) to start from, the most promising first."""
    moduli = _moduli(model, 0.8 * model.box.loss_factor[1])
    nu_low, nu_high = model.box.poisson_ratio
    points, total = count(1), moduli.size * sum(map(len, RATIOS))

    def step() -> None:
        progress(next(points) / total)

    for places in RATIOS:
        ratios = nu_low + (nu_high - nu_low) * np.array(places)
        yield from _from_grid(model, data, moduli, ratios, step, signed=signed)
    if signed and model.box.loss_factor[1] < SHARP:
        yield from narrowed(model, data, moduli)


def _from_grid(
    model: TwinModel,
    data: SweepData,
    moduli: Real,
    ratios: Real,
    step: Callable[[], None],
    *,
    signed: bool,
) -> Iterator[Real]:
    """Yield the minima of a grid of moduli (M,), Pa, and Poisson's ratios (N,), with their best loss factor.

    `step` is called after every point of the grid.
    """

    def misfit(e: float, nu: float, eta: float) -> float:
        transfer = data.answer(model, (e, nu, eta))
        return best_gain(transfer, data if signed else _with_signs(transfer, data))[1]

    eta_low, eta_high = max(model.box.loss_factor[0], LEAST_LOSS), 0.8 * model.box.loss_factor[1]
    etas = np.geomspace(min(eta_low, eta_high), eta_high, 5)
    misfits = np.empty((moduli.size, ratios.size))
    places = product(moduli.tolist(), ratios.tolist())
    with ForkedExecutor() as pool:
        for place, found in enumerate(pool.map(misfit, *zip(*places, strict=True), repeat(eta_high))):
            misfits.flat[place] = found
            step()
        for i, j in _minima(misfits)[:STARTS]:
            e, nu = float(moduli[i]), float(ratios[j])
            damped = list(pool.map(misfit, repeat(e), repeat(nu), etas.tolist()))
            yield np.array([e, nu, etas[int(np.argmin(damped))]])


def _moduli(model: TwinModel, loss_factor: float) -> Real:
    """Moduli over the box, Pa, spaced for resonances of a loss factor."""
    low, high = model.box.youngs_modulus
    step = np.log(min(MODULUS_STEP, 1.0 + RESONANCE_STEP * loss_factor))
    return np.asarray(np.geomspace(low, high, int(np.ceil(np.log(high / low) / step)) + 1))


def _minima(misfits: Real) -> list[tuple[int, int]]:
    """Local minima along the first axis, as indices (i, j), lowest first."""
    walled = np.pad(misfits, ((1, 1), (0, 0)), constant_values=np.inf)
    lowest = (misfits <= walled[:-2]) & (misfits <= walled[2:])
    places = [(int(i), int(j)) for i, j in np.argwhere(lowest)]
    return sorted(places, key=lambda place: float(misfits[place]))


def _noise(data: SweepData) -> float:
    """Ratio of the noise's rms to that of the data."""
    return float(np.sqrt((1.0 / data.weight).sum()) / np.linalg.norm(data.h))


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
    for nu in np.linspace(*model.box.poisson_ratio, RATIOS_OF_BROADENED + 2)[1:-1]:
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


WINDOW = 0.05
"""Width of the smoothing, as a share of the frequency."""
POINTS_PER_WINDOW = 4
STEP = 0.08
"""Step of log E in the scan: shifts frequencies by less than the window."""
REACH = 9.0
"""Smallest factor by which the scan exceeds the declared moduli: half or twice the thickness at equal mass."""
SOFTEST, STIFFEST, FARTHEST = 0.6e9, 300e9, 100.0
"""Moduli of common plates, Pa, which the scan also covers, within this factor of the declared ones."""
AGREES = 0.7
"""Smallest correlation of a credible modulus: the right one reaches 0.93 on polymers, 0.74 on metals."""
DIFFERS, FAR = 0.1, 0.3
"""Excess of its correlation over the best within the declared range, for a warning and for an error."""
FLOOR = 1e-5
"""Smallest power relative to the largest: deeper antiresonances are cut off."""


class CoarseModel(Protocol):
    """Model of a plate, as the scan needs it."""

    def frf(self, youngs_modulus: float, poisson_ratio: float, frequency: Real) -> NDArray[np.complex128]:
        """Transfer of a moderately damped plate.

        Parameters
        ----------
        youngs_modulus : float
            Pa.
        frequency : (F,) ndarray
            Hz.

        Returns
        -------
        (K, F) complex ndarray
            Sensor volts per actuator volt.
        """
        ...


@dataclass(frozen=True)
class ModulusScan:
    """Result of the scan of one sweep.

    Attributes
    ----------
    modulus, inside : float
        Modulus of best agreement, Pa: over the whole scan, and within the declared range.
    agreement, agreement_inside : float
        Correlation of the levels there, -1 to 1.
    """

    modulus: float
    agreement: float
    inside: float
    agreement_inside: float

    @property
    def outside(self) -> bool:
        """Whether a modulus outside the declared range agrees well, and better than those inside."""
        return self.agreement > AGREES and self.agreement > self.agreement_inside + DIFFERS

    @property
    def far_outside(self) -> bool:
        """Whether, in addition, no modulus within the range agrees nearly as well."""
        return self.outside and self.agreement > self.agreement_inside + FAR


def scanned_box(box: MaterialBox) -> MaterialBox:
    """Box of all materials that the scan evaluates."""
    low, high = box.youngs_modulus
    lowest = min(low / REACH, max(low / FARTHEST, SOFTEST))
    highest = max(high * REACH, min(high * FARTHEST, STIFFEST))
    return MaterialBox((lowest, highest), box.poisson_ratio, box.loss_factor)


def scan_modulus(model: CoarseModel, frequency: Real, h: NDArray[np.complex128], box: MaterialBox) -> ModulusScan:
    """Find the modulus at which the levels of one sweep agree best with the plate's.

    Parameters
    ----------
    model : CoarseModel
        Evaluated within `scanned_box`.
    frequency : (F,) ndarray
        Hz, without lines of mains.
    h : (K, F) complex ndarray
        Measured FRF, V/V.
    box : MaterialBox
        As declared.
    """
    grid = scan_grid(frequency)
    seen = levels(smoothed(np.abs(h) ** 2, frequency, grid))
    low, high = scanned_box(box).youngs_modulus
    moduli = np.geomspace(low, high, int(np.ceil(np.log(high / low) / STEP)) + 1)
    nu_low, nu_high = box.poisson_ratio

    def agreement(e: float, nu: float) -> float:
        power = smoothed(np.abs(model.frf(e, nu, grid)) ** 2, grid, grid)
        return float(np.mean((seen * levels(power)).mean(axis=1)))

    found = np.array([agreement(float(e), 0.5 * (nu_low + nu_high)) for e in moduli])
    declared = (moduli >= box.youngs_modulus[0] / np.exp(STEP)) & (moduli <= box.youngs_modulus[1] * np.exp(STEP))
    for chosen in (declared, ~declared):  # the best of both are also tried with other Poisson's ratios
        for k in np.flatnonzero(chosen)[np.argsort(found[chosen])[-4:]]:
            others = (nu_low + share * (nu_high - nu_low) for share in (0.15, 0.85))
            found[k] = max(found[k], *(agreement(float(moduli[k]), nu) for nu in others))
    best, best_inside = int(found.argmax()), int(np.where(declared, found, -np.inf).argmax())
    return ModulusScan(
        float(moduli[best]), float(found[best]), float(moduli[best_inside]), float(found[best_inside])
    )


def scan_grid(frequency: Real) -> Real:
    """Frequencies (G,), Hz, at which levels of FRFs measured at `frequency` (F,) are compared."""
    count = int(np.ceil(np.log(frequency[-1] / frequency[0]) * POINTS_PER_WINDOW / WINDOW)) + 1
    return np.asarray(np.geomspace(frequency[0], frequency[-1], count))


def smoothed(power: Real, frequency: Real, grid: Real) -> Real:
    """Mean of powers over Hann windows of `WINDOW` about every point of a grid.

    Parameters
    ----------
    power : (K, F) ndarray
    frequency : (F,) ndarray
        Hz.
    grid : (G,) ndarray
        Hz.

    Returns
    -------
    (K, G) ndarray
    """
    distance = np.log(frequency[None, :] / grid[:, None]) / WINDOW
    weight = np.where(np.abs(distance) < 1.0, 1.0 + np.cos(np.pi * np.clip(distance, -1.0, 1.0)), 0.0)
    weight *= np.gradient(frequency)
    return np.asarray((power @ weight.T) / weight.sum(axis=1))


def levels(power: Real) -> Real:
    """Logarithms of powers (K, G) without linear trend, of mean 0 and variance 1."""
    level = np.log(np.maximum(power, FLOOR * power.max(axis=1, keepdims=True)))
    place = np.linspace(-1.0, 1.0, level.shape[1])
    trend = np.polynomial.polynomial.polyfit(place, level.T, 1)
    level = level - np.polynomial.polynomial.polyval(place, trend)
    return np.asarray(level / np.maximum(level.std(axis=1, keepdims=True), 1e-12))
