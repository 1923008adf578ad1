"""Synthetic FRFs with known poles, for tests and benchmarks; R10 is as difficult as a polymer plate.

Ten modes, log-uniform in 160 to 1450 Hz, no two closer than 4.5 %, damping ratios 2 to 5 %, slightly
complex residues, modes out of band as E + F/s^2; 100 to 1500 Hz every 0.5 Hz; complex white noise, a share of
rms |H|. The others change one property each: noise correlated between neighbouring lines, a smooth ripple on the
response, pairs of modes 0.3 % apart, forty modes that overlap.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from analysis.identification.pole_residue import REAL_E_F, synthesis


@dataclass(frozen=True)
class SyntheticFrf:
    """An FRF with the poles it was made of.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    clean, h : (F,) complex ndarray
        Without and with noise.
    deviation : float
        sqrt(E|noise|^2) of every line.
    poles, residues : (J,) complex ndarray
        rad/s, sorted by frequency.
    """

    frequency: NDArray[np.float64]
    clean: NDArray[np.complex128]
    h: NDArray[np.complex128]
    deviation: float
    poles: NDArray[np.complex128]
    residues: NDArray[np.complex128]


def _frequencies(
    rng: np.random.Generator, count: int, low: float, high: float, spacing: float
) -> NDArray[np.float64]:
    while True:
        f = np.sort(np.exp(rng.uniform(np.log(low), np.log(high), count)))
        if (f[1:] / f[:-1]).min() >= 1.0 + spacing:
            return f


def r10(rng: np.random.Generator, *, noise: float = 0.01, modes: int = 10) -> SyntheticFrf:
    """Draw the case R10.

    Parameters
    ----------
    rng : numpy Generator
        Source of the draw.
    noise : float
        sqrt(E|noise|^2) over rms |H|.
    modes : int
        Ten in the case this is named after.
    """
    f = _frequencies(rng, modes, 160.0, 1450.0, 0.045)
    return _drawn(rng, f, rng.uniform(0.02, 0.05, modes), noise)


def shared_noise(rng: np.random.Generator, *, noise: float = 0.01, lines: int = 5) -> SyntheticFrf:
    """R10 with noise averaged over neighbouring lines, as by windows and interpolation.

    Parameters
    ----------
    rng : numpy Generator
        Source of the draw.
    noise : float
        sqrt(E|noise|^2) over rms |H|.
    lines : int
        Number of lines averaged.
    """
    case = r10(rng, noise=noise)
    count = len(case.h) + lines - 1
    drawn = rng.normal(size=count) + 1j * rng.normal(size=count)
    mean = np.convolve(drawn, np.full(lines, lines**-0.5), "valid")
    return replace(case, h=case.clean + case.deviation / np.sqrt(2.0) * mean)


def rippled(rng: np.random.Generator, *, ripple: float = 5e-3, noise: float = 1e-3) -> SyntheticFrf:
    """R10 times 1 + a random ripple with a correlation length of 10 Hz.

    Parameters
    ----------
    rng : numpy Generator
        Source of the draw.
    ripple : float
        Its rms.
    noise : float
        sqrt(E|noise|^2) over rms |H|.
    """
    case = r10(rng, noise=noise)
    drawn = rng.normal(size=len(case.h)) + 1j * rng.normal(size=len(case.h))
    smooth = gaussian_filter1d(drawn, 10.0 / (case.frequency[1] - case.frequency[0]))
    smooth *= ripple / np.sqrt(np.mean(np.abs(smooth) ** 2))
    return replace(case, h=case.h + case.clean * smooth)


def pairs(rng: np.random.Generator, *, noise: float = 1e-3) -> SyntheticFrf:
    """Four pairs of modes 0.3 % apart, damping ratios 1 to 2 %."""
    lower = _apart(rng, 4, 160.0, 1400.0, 0.15)
    return _drawn(rng, np.sort(np.concatenate([lower, 1.003 * lower])), rng.uniform(0.01, 0.02, 8), noise)


def crowded(rng: np.random.Generator, *, noise: float = 0.01) -> SyntheticFrf:
    """Forty modes between 130 and 1450 Hz, at least 1.5 % apart, damping ratio 2.5 %."""
    return _drawn(rng, _apart(rng, 40, 130.0, 1450.0, 0.015), np.full(40, 0.025), noise)


def _apart(rng: np.random.Generator, count: int, low: float, high: float, spacing: float) -> NDArray[np.float64]:
    """Frequencies, Hz, log-uniform with a smallest distance."""
    least = np.log1p(spacing) * np.arange(count)
    drawn: NDArray[np.float64] = low * np.exp(
        np.sort(rng.uniform(0.0, np.log(high / low) - least[-1], count)) + least
    )
    return drawn


def _drawn(
    rng: np.random.Generator, f: NDArray[np.float64], zeta: NDArray[np.float64], noise: float
) -> SyntheticFrf:
    """FRF with random residues, residual terms and white noise."""
    frequency, modes = np.arange(100.0, 1500.25, 0.5), len(f)
    w = 2.0 * np.pi * f
    poles = w * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    # half real modal constants phi_i phi_j / 2 j w of either sign, rotated by a few degrees
    size = rng.uniform(0.5, 1.5, modes) * rng.choice([-1.0, 1.0], modes)
    residues = -0.5j * size * w * zeta.mean() * np.exp(1j * rng.normal(0.0, np.deg2rad(5.0), modes))
    constants = np.array(
        [[rng.normal(0.0, 0.3), rng.normal(0.0, 0.3) * (2.0 * np.pi * 100.0) ** 2]], dtype=complex
    )
    clean = synthesis(frequency, poles, residues[None, :], REAL_E_F, constants)[0]
    deviation = float(noise * np.sqrt(np.mean(np.abs(clean) ** 2)))
    disturbance = rng.normal(size=len(frequency)) + 1j * rng.normal(size=len(frequency))
    return SyntheticFrf(
        frequency, clean, clean + deviation / np.sqrt(2.0) * disturbance, deviation, poles, residues
    )
