"""H1 over synchronous repeats of a sweep, strays left out, with its coherence and the power of its noise.

A sweep that starts at rest and ends in silence is a periodic excitation: no window, no leakage, and the repeats
differ by noise alone. Drive and response come from the same card, so its filters and delays cancel in the ratio.

Repeats follow each other while the temperature drifts; how far resonances move over them is estimated here.
Identification takes it from here, before and without tracks. `Protocol.spread`, in kelvins, is for twins, whose
derivative by temperature is known: model updating and the gap correct all lines with it, not only the poles.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Complex
from analysis.recordings.campaign import Sweep
from analysis.recordings.noise_power import noise_power, rough_power


def h1(
    drive: NDArray[np.float32], response: NDArray[np.float32]
) -> tuple[NDArray[np.complex128], NDArray[np.float64], NDArray[np.float64]]:
    """Estimate H1 from synchronous repeats.

    Parameters
    ----------
    drive, response : (R, M) ndarray
        Repeats of one sweep and of what one sensor answered, V.

    Returns
    -------
    h : (M // 2 + 1,) complex ndarray
        G_yu / G_uu, the cross and auto spectra averaged over the repeats (paper section 3.2); NaN, like all
        else, at a line where the drive is exactly zero, as at 0 Hz where it has no mean.
    residual_power : (M // 2 + 1,) ndarray
        Unbiased variance of a single repeat's ratio about h; NaN for one repeat. From three repeats on, a straight
        drift of the ratio is no noise: the oven ramps on, and h stands for the temperature in the middle.
    coherence : (M // 2 + 1,) ndarray
        |G_yu|^2 / (G_uu G_yy); identically 1 for one repeat, which says nothing.
    """
    return h1_of_spectra(spectra(drive), spectra(response))


def spectra(signals: NDArray[np.float32]) -> NDArray[np.complex128]:
    """Spectra (..., M // 2 + 1) of repeats (..., M)."""
    return np.fft.rfft(signals.astype(float), axis=-1)


def h1_of_spectra(
    u: NDArray[np.complex128], y: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], NDArray[np.float64], NDArray[np.float64]]:
    """Estimate H1 as `h1` does, at those lines of the `spectra` (R, F) of drive and response that are given."""
    g_uu = (np.abs(u) ** 2).sum(0)
    g_yu = (y * u.conj()).sum(0)
    g_yy = (np.abs(y) ** 2).sum(0)
    h = _ratio(g_yu, g_uu)
    repeats = len(u)
    residual, freedom = y - h * u, repeats_dof(repeats) // 2
    if repeats > 2:
        # hits come when and as hard as they happen to: what drifts is the ratio, not the response
        drift = (np.arange(repeats) - 0.5 * (repeats - 1))[:, None] * u
        drift = drift - np.nan_to_num(_ratio((drift * u.conj()).sum(0), g_uu)) * u
        residual = residual - _ratio((residual * drift.conj()).sum(0), (np.abs(drift) ** 2).sum(0)) * drift
    power = np.full(h.shape, np.nan)
    if freedom:
        power = _ratio((np.abs(residual) ** 2).sum(0) / freedom * repeats, g_uu)
    return h, power, _ratio(np.abs(g_yu) ** 2, g_uu * g_yy)


def repeats_dof(repeats: int) -> int:
    """Return the degrees of freedom of the variance that `h1` estimates at a line; 0 for one repeat."""
    mean_and_drift = 2 if repeats > 2 else 1
    return 2 * (repeats - mean_and_drift)


def bad_repeats(u: NDArray[np.complex128], y: NDArray[np.complex128]) -> list[int]:
    """Repeats whose ratio lies far from the others': a knock, a dropout, a loose cable.

    Each repeat's energy about the median repeat is compared with the median of these energies; more than sixteen
    times (four times in amplitude) is no noise of a steady rig. Needs three repeats.

    Parameters
    ----------
    u, y : (R, F) complex ndarray
        `spectra` of drive and response in the band: beyond it a drive may be exactly zero.

    Returns
    -------
    list of int
        Numbers of the bad repeats, from 0; empty for fewer than three repeats.
    """
    if len(u) < 3:
        return []
    ratio = _ratio(y, u)
    middle = np.median(ratio.real, axis=0) + 1j * np.median(ratio.imag, axis=0)
    energy = (np.abs(ratio - middle) ** 2).sum(1)
    return [int(r) for r in np.flatnonzero(energy > 16.0 * np.median(energy))]


def _ratio(numerator: NDArray[Any], denominator: NDArray[Any]) -> NDArray[Any]:
    """Quotient, NaN where the denominator is zero."""
    undefined = np.full(denominator.shape, np.nan, np.result_type(numerator, denominator))
    return np.asarray(np.divide(numerator, denominator, out=undefined, where=denominator != 0.0))


class SweepH1(NamedTuple):
    """H1 of one sweep at all outputs.

    Attributes
    ----------
    h, variance, coherence : (K, F) ndarray
        As in `analysis.recordings.frf.Frf`.
    repeats_dof : int
        Degrees of freedom of the variance at a line, before it is averaged over neighbouring lines.
    shift : float
        See `analysis.recordings.h1`.
    notes : list of str
        One for every repeat left out.
    """

    h: NDArray[np.complex128]
    variance: NDArray[np.float64]
    coherence: NDArray[np.float64]
    repeats_dof: int
    shift: float
    notes: list[str]


def repeat_shift(ratio: Complex, first: int) -> float:
    """Return the standard deviation of the relative shift of all frequencies over the repeats of a sweep.

    While the temperature drifts, all frequencies of a plate move by nearly the same factor. The straight drift of
    H over the repeats is then proportional to f dH/df. H averaged over the repeats is smoothed by this standard
    deviation. To the second order this changes the peak of a pole lambda = w (-zeta + j) by
    -R (shift w)^2/(s - lambda)^3, which is (shift/zeta)^2 of it.

    Parameters
    ----------
    ratio : (K, R, F) complex ndarray
        Response over drive on consecutive lines, of every output and repeat.
    first : int
        Number of the first line, from 0 Hz.

    Returns
    -------
    float
        0 for one repeat.
    """
    repeats = ratio.shape[1]
    if repeats == 1:
        return 0.0
    number = np.arange(repeats) - 0.5 * (repeats - 1)
    drift = np.einsum("r,krf->kf", number, ratio) / (number**2).sum()
    moved = (first + np.arange(ratio.shape[2])) * np.gradient(ratio.mean(axis=1), axis=1)
    size = float((np.abs(moved) ** 2).sum())
    step = float((moved.conj() * drift).sum().real) / size if size > 0.0 else 0.0
    return abs(step) * float(np.sqrt((number**2).mean()))


def sweep_h1(sweep: Sweep, lines: slice, excluded: NDArray[np.bool_], names: Sequence[str]) -> SweepH1:
    """H1, its variance and the coherence of one sweep.

    Parameters
    ----------
    lines : slice
        Of the spectrum, that are wanted.
    excluded : (F,) bool ndarray
        Lines that say nothing of the noise.
    names : sequence of str
        Of the outputs.

    Raises
    ------
    ValueError
        Where too few repeats are left.
    """
    h_rows, variance_rows, coherence_rows = [], [], []
    u, answers = spectra(sweep.drive)[:, lines], spectra(sweep.responses)[..., lines]
    bad = {r: name for name, y in zip(names, answers, strict=True) for r in bad_repeats(u, y)}
    good = [r for r in range(len(u)) if r not in bad]
    notes = [f"step {sweep.step}: repeat {r + 1} left out, {name} strays" for r, name in bad.items()]
    if len(good) < 2 <= len(u):
        raise ValueError(f"sweep {sweep.step}: repeats {sorted(r + 1 for r in bad)} stray; too few are left")
    drive = (np.abs(u[good]) ** 2).sum(0)
    for y in answers:
        h, power, coherence = h1_of_spectra(u[good], y[good])
        if len(good) == 1:
            power = rough_power(h)
        h_rows.append(h)
        # the noise of the signals is smooth over frequency; divided by a drive that dips at resonances it is not
        variance_rows.append(noise_power(power * drive, h, excluded) / (len(good) * drive))
        coherence_rows.append(np.clip(coherence, 0.0, 1.0))
    shift = repeat_shift(answers[:, good] / u[good], lines.start)
    return SweepH1(
        np.array(h_rows), np.array(variance_rows), np.array(coherence_rows), repeats_dof(len(good)), shift, notes
    )
