"""Motion of a plate's modes in time, step by step: no transform, no transfer function."""

import numpy as np
from scipy.signal import lfilter

from analysis.arrays import Complex, Real
from analysis.focusing.panel_model import PanelModes

RIGID = (2.0 * np.pi) ** 2 * (1.0 + 1.0j)
"""Least eigenvalue, rad2/s2: a free plate as a whole is taken to swing at 1 Hz, far below what is played."""


def modal_motion(modes: PanelModes, drive: Complex, rate: float, every: int = 1) -> Real:
    """Integrate q'' + ω²(1 + jη) q = f(t) of every mode, the drive straight between its samples.

    Parameters
    ----------
    modes : PanelModes
        m of them, of r coordinates.
    drive : (N, S) complex ndarray
        Of every actuator, V or N: its real part is what is played, its imaginary part the same a quarter of a
        period later (the analytic signal).
    rate : float
        Samples per second, Hz.
    every : int
        Of how many samples one is returned.

    Returns
    -------
    (S / every, r) ndarray
        Generalised coordinates, the real part.

    Notes
    -----
    With s² = -ω²(1 + jη), Re s < 0, 1/(ω²(1 + jη) + p²) = (1/(p - s) - 1/(p + s)) / 2s. The first part follows
    its past, y' = s y + f; the second, whose pole lies in the right half plane, its future: hysteretic damping is
    not causal. It is integrated backward. On a step of length h both are y(t + h) = exp(sh) y(t) + h (a f(t) +
    b f(t + h)), exact for a drive that is straight in between. The loss factor has one sign at positive
    frequencies, which are all that an analytic signal holds.
    """
    poles = 1j * np.sqrt(np.where(np.abs(modes.eigenvalues) < np.abs(RIGID), RIGID, modes.eigenvalues))
    coordinates = np.empty((len(poles), len(range(0, drive.shape[1], every))), dtype=complex)
    for place, (pole, coupling) in enumerate(zip(poles, modes.coupling.astype(complex), strict=True)):
        force = coupling @ drive
        both = _relaxed(force, pole, rate) + _relaxed(force[::-1], pole, rate)[::-1]
        coordinates[place] = both[::every] / (2.0 * pole)
    return np.asarray((modes.shapes @ coordinates).real.T)


def _relaxed(force: Complex, pole: complex, rate: float) -> Complex:
    """Solve y' = pole · y + force from rest, at the samples of `force` (S,)."""
    x = pole / rate
    growth = np.exp(x)
    late = (growth - 1.0 - x) / x**2
    early = (growth - 1.0) / x - late
    return np.asarray(lfilter([late / rate, early / rate], [1.0, -growth], force))
