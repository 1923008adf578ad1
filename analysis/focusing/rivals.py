"""Methods that STIF is compared with in the paper's Fig. 4: time reversal, modal control, no control."""

import numpy as np

from analysis.arrays import Complex, Real


def time_reversal(response: Complex) -> Complex:
    """Return the time-reversal filters (T, F, N) for a source at the target's centre.

    By reciprocity they are the conjugate of `response` (T, F, N), the deflection that each actuator causes there:
    a matched filter for one point of the plate, without regard to the rest.
    """
    return response.conj()


def modal_control(
    shapes: Real, eigenvalues: Complex, coupling: Real, aim: Real, frequency: Real, count: int | None = None
) -> Complex:
    """Return the filters (F, N) that drive the first modes to the modal amplitudes of the target shape.

    Parameters
    ----------
    shapes : (m, m) ndarray
        Φᵀ W Φ of the m modes: their overlap over the grid, m2 (mass-normalised shapes).
    eigenvalues : (m,) ndarray
        Complex ω²(1 + jη), ascending, rad2/s2.
    coupling : (m, N) ndarray
        Modal force of each actuator, N/V.
    aim : (m,) ndarray
        Φᵀ W φ, overlap of every mode with the target shape.
    frequency : (F,) ndarray, Hz
    count : int, optional
        Number of modes controlled; by default as many as actuators.

    Returns
    -------
    (F, N) complex ndarray
        V per unit of audio signal.

    Raises
    ------
    ValueError
        For a `count` under 1 or over the m modes known.

    Notes
    -----
    The target's modal amplitudes are q = (Φᵀ W Φ)⁻¹ Φᵀ W φ of the controlled modes; the modal forces for them are
    (λ - ω²) q, and the filters B⁺ times these. Modes beyond `count` are not controlled.
    """
    count = coupling.shape[1] if count is None else count
    if not 1 <= count <= len(eigenvalues):
        raise ValueError(f"{count} modes to control; {len(eigenvalues)} are known")
    wanted = np.linalg.solve(shapes[:count, :count], aim[:count])
    force = (eigenvalues[None, :count] - (2.0 * np.pi * frequency[:, None]) ** 2) * wanted
    filters: Complex = force @ np.linalg.pinv(coupling[:count]).T
    return filters


def nearest_actuator(centers: Real, target: tuple[float, float], lines: int) -> Complex:
    """Return filters that drive only the actuator nearest to the target.

    Parameters
    ----------
    centers : (N, 2) ndarray, m
        Of the actuators.
    target : (float, float)
        Centre of the target, m.
    lines : int
        Number F.

    Returns
    -------
    (F, N) complex ndarray
        1 for the nearest actuator, 0 for the others.
    """
    nearest = int(np.argmin(np.sum((centers - np.asarray(target)) ** 2, axis=1)))
    filters = np.zeros((lines, len(centers)), dtype=complex)
    filters[:, nearest] = 1.0
    return filters
