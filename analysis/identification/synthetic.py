"""R10: a synthetic FRF as hard as a polymer plate's, with its truth, for tests and benchmarks.

Ten modes, log-uniform in 160 to 1450 Hz, no two closer than 4.5 %, damping ratios 2 to 5 %, slightly
complex residues, modes out of band as E + F/s^2; 100 to 1500 Hz every 0.5 Hz; complex white noise, a share of
rms |H|.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.identification.pole_residue import synthesis
from analysis.identification.residual_terms import REAL_E_F


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
    """One draw.

    Parameters
    ----------
    rng : numpy Generator
        Source of the draw.
    noise : float
        sqrt(E|noise|^2) over rms |H|.
    modes : int
        Ten in the case this is named after.
    """
    frequency = np.arange(100.0, 1500.25, 0.5)
    f = _frequencies(rng, modes, 160.0, 1450.0, 0.045)
    zeta = rng.uniform(0.02, 0.05, modes)
    w = 2.0 * np.pi * f
    poles = w * (-zeta + 1j * np.sqrt(1.0 - zeta**2))
    # half real modal constants phi_i phi_j / 2 j w of either sign, turned a few degrees
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
