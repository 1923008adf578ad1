"""Which poles of a model are modes of the plate, and why the others are not.

Lines of an FRF disturbed by mains hum or other tones.
"""

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import roughness
from analysis.identification.judgement.resolution import heights, unresolved
from analysis.identification.lines import Lines, running_median
from analysis.identification.modes import NOT_ONE
from analysis.identification.order import pole_penalty, support
from analysis.identification.pole_search import PoleFit

MOST_DAMPED = 0.2
"""Damping ratio above which a pole is background; the lossiest plate polymers stay near 0.05."""

WEAK_DAMPING = 0.3
"""Relative standard deviation of the damping ratio from which a mode is called weak."""

UNRESOLVED = "too close to a taller peak for the lines to separate them, or its leakage"

POSSIBLY_TWO = "{:.2g} times the damping of the modes around it: possibly two unresolved modes"

NOT_ONE_POLE = f"; {NOT_ONE}: two, {{:.2g}} Hz apart, or one that changed meanwhile (σ covers both)"

OUTSTANDING_DAMPING = 8.0
"""Damping ratio, in multiples of the median of all poles in the band, above which a pole is background too."""

OUTSTANDING_GAIN = 10.0
"""Support by BIC, in penalties of one pole, from which a pole narrower than the lines is not a stray line."""

SMALLEST_SHARE = (1e-3, 1e-2)
"""Limits of the smallest peak that counts as a mode, relative to |h| there: between them it is the relative noise
of the lines; a smaller peak cannot be distinguished from curvature of the background."""


def judge(
    lines: Lines,
    fitted: PoleFit,
    mains: float | None,
    spread: NDArray[np.float64],
    apart: NDArray[np.float64],
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Status and reason of every pole of a fit.

    Parameters
    ----------
    lines : Lines
        All lines the fit was made on.
    fitted : PoleFit
        Converged.
    mains : float or None
        Mains frequency, Hz.
    spread : (J, 2, 2) ndarray
        Covariance of every pole's log |pole| and log damping ratio.
    apart : (J,) ndarray
        As `half_distances` gives it.

    Returns
    -------
    status, reason : tuple of str
        One per pole.
    """
    gain = support(fitted, lines)
    share, least = _shares(lines, fitted)
    lesser = unresolved(lines, fitted.poles, fitted.projection.residues)
    limit = _damping_limit(lines, fitted)
    remark = [NOT_ONE_POLE.format(one / np.pi) if one else "" for one in apart]
    shared = np.zeros(len(gain)) if lines.damping is None else lines.damping.shared(fitted.poles)
    verdicts = [
        _verdict(lines, pole, bool(fitted.stuck[j]), mains, limit, gain[j])
        or (("computational", UNRESOLVED) if lesser[j] else None)
        or _weakness(lines, pole, gain[j], float(np.sqrt(spread[j, 1, 1])), share[j] / least[j])
        or (("weak", POSSIBLY_TWO.format(shared[j])) if shared[j] else None)
        or ("kept", f"BIC would rise by {gain[j]:.0f} without it{remark[j]}")
        for j, pole in enumerate(fitted.poles)
    ]
    return tuple(status for status, _ in verdicts), tuple(reason for _, reason in verdicts)


def _damping_limit(lines: Lines, fitted: PoleFit) -> float:
    """Damping ratio above which a pole of this FRF is background."""
    place = fitted.poles.imag / (2.0 * np.pi)
    inside = (place >= lines.frequency[0]) & (place <= lines.frequency[-1])
    inside &= -fitted.poles.real > 0.4 * np.pi * lines.spacing_at(place)  # a stray line gives no damping
    if inside.sum() < 3:
        return MOST_DAMPED
    zeta = (-fitted.poles.real / np.abs(fitted.poles))[inside]
    return min(MOST_DAMPED, OUTSTANDING_DAMPING * float(np.median(zeta)))


def _shares(lines: Lines, fitted: PoleFit) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Height of every peak over rms |h| near it, infinite without a line there, and the smallest that counts."""
    height = heights(fitted.poles, fitted.projection.residues)
    share, least = np.full(len(fitted.poles), np.inf), np.full(len(fitted.poles), SMALLEST_SHARE[1])
    for j, pole in enumerate(fitted.poles):
        place = pole.imag / (2.0 * np.pi)
        reach = max(-pole.real / (2.0 * np.pi), 2.0 * float(lines.spacing_at(place)))
        near = np.abs(lines.frequency - place) <= reach
        if near.any():
            size = np.sqrt((np.abs(lines.h[:, near]) ** 2).sum(0).mean())
            share[j] = height[j] / size
            noise = np.sqrt((lines.deviation[:, near] ** 2).sum(0).mean()) / size
            least[j] = np.clip(noise, *SMALLEST_SHARE)
    return share, least


def _verdict(
    lines: Lines, pole: complex, stuck: bool, mains: float | None, limit: float, gain: float
) -> tuple[str, str] | None:
    """Status and reason of a pole that cannot be a mode of the plate, else None."""
    f, zeta, width = pole.imag / (2.0 * np.pi), -pole.real / abs(pole), -pole.real / (2.0 * np.pi)
    low, high, spacing = lines.frequency[0], lines.frequency[-1], float(lines.spacing_at(f))
    if not low <= f <= high:
        return "computational", f"outside the band, {low:g} to {high:g} Hz: stands for the modes there"
    if mains and (hum := needle_hum(pole, mains, lines.spacing, spacing)):
        return "harmonic", f"a line at {hum[0]} x {hum[1]:g} Hz mains"
    if zeta > limit:
        return "computational", f"damping ratio {zeta:.2g} is above {limit:.2g}: a slope of the background"
    if width < 0.2 * spacing and gain > OUTSTANDING_GAIN * pole_penalty(lines):
        return "weak", "narrower than a fifth of the lines' spacing: its damping is not known"
    if width < 0.2 * spacing:
        return "computational", "narrower than a fifth of the lines' spacing: one stray line"
    if stuck:
        return "computational", "stuck at a bound of the search"
    return None


def _weakness(lines: Lines, pole: complex, gain: float, spread: float, share: float) -> tuple[str, str] | None:
    """Status and reason of a mode in the band that is not reliable, else None."""
    f, width = pole.imag / (2.0 * np.pi), -pole.real / (2.0 * np.pi)
    if share < 1.0:
        return (
            "computational",
            f"its peak is {share:.2g} of the residual of its lines: curvature of the background",
        )
    if spread > 1.0:
        return "computational", "its damping ratio is not determined by the data"
    if spread > WEAK_DAMPING:
        return "weak", f"its damping ratio is known to {100 * spread:.0f} % only"
    if gain < 0.25 * pole_penalty(lines):
        word = "rise by only" if gain > 0.0 else "fall by"
        return "weak", f"BIC would {word} {abs(gain):.0f} without it"
    if np.isinf(share):
        return "weak", "no line at its peak, where lines are left out: known from its flanks alone"
    edge = min(f - lines.frequency[0], lines.frequency[-1] - f)
    if edge < 0.5 * width:
        return "weak", f"{edge:.3g} Hz from the edge of the band: only half its peak was seen"
    return None


HUM_SIGMA = 5.0
"""How far a line must lie from the model, in local standard deviations, to count as mains hum."""

GRIDS = (50.0, 60.0)
"""Mains frequencies in use, Hz: if the wrong one was stated, harmonics of the other appear."""

HARMONIC_DISTANCE = 5e-3
"""Largest relative distance of a narrow pole from its mains harmonic: the mains frequency drifts."""

TONE_HALF_WIDTH = 0.5
"""Half width in lines up to which a pole may be a tone: such a resonance would ring longer than the record."""

TONE_HEIGHT = 10.0
"""Height of a line above its neighbours, over their own difference, that no resonance reaches."""


def harmonic_of(frequency: float, mains: float, spacing: float) -> tuple[int, float] | None:
    """Return the mains harmonic that a narrow pole may be; harmonics of `mains` are tried first.

    Parameters
    ----------
    frequency : float
        Of the narrow pole, Hz.
    mains : float
        Mains frequency, Hz.
    spacing : float
        Of the lines, Hz.

    Returns
    -------
    (int, float) or None
        Number of the harmonic and its fundamental, Hz; None where there is none within a line.
    """
    for fundamental in dict.fromkeys((mains, *GRIDS)):
        number = max(round(frequency / fundamental), 1)
        if abs(frequency - number * fundamental) <= max(spacing, HARMONIC_DISTANCE * frequency):
            return number, fundamental
    return None


def needle_hum(
    pole: complex, mains: float, spacing: float, around: float | None = None
) -> tuple[int, float] | None:
    """Mains harmonic that a pole represents.

    Parameters
    ----------
    pole : complex
        rad/s.
    mains : float
        Mains frequency, Hz.
    spacing : float
        Of the lines, Hz.
    around : float, optional
        Of uneven lines near the pole, Hz: its width counts in these, but hum is where the mains is, however far
        apart the lines of a stepped sine are.

    Returns
    -------
    (int, float) or None
        As `harmonic_of` gives it; None where the pole is wider than a line.
    """
    frequency, width = pole.imag / (2.0 * np.pi), -pole.real / (2.0 * np.pi)
    return harmonic_of(frequency, mains, spacing) if width <= TONE_HALF_WIDTH * (around or spacing) else None


def harmonic_lines(
    frequency: NDArray[np.float64], left: NDArray[np.complex128], spacing: float, mains: float
) -> NDArray[np.bool_]:
    """Find the lines within one spacing of a mains harmonic that stand out of a fit's residual.

    Parameters
    ----------
    frequency : (F,) ndarray
        Hz.
    left : (K, F) complex ndarray
        Measured minus model.
    spacing : float
        Of the lines, Hz.
    mains : float
        Hz; harmonics of the other mains frequency in `GRIDS` are searched as well.

    Returns
    -------
    (F,) bool ndarray
    """
    size = np.abs(left)
    window = min(101, left.shape[1])
    usual = running_median(size, window, "nearest") / np.sqrt(np.log(2.0))
    near = np.zeros(len(frequency), dtype=bool)
    for fundamental in {mains, *GRIDS}:
        number = np.maximum(np.round(frequency / fundamental), 1.0)
        near |= np.abs(frequency - fundamental * number) <= 1.001 * spacing
    spoilt: NDArray[np.bool_] = near & (size > HUM_SIGMA * np.maximum(usual, np.finfo(float).tiny)).any(axis=0)
    return spoilt


def tones(h: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Find single lines that no resonance could make: (F,) bool ndarray.

    The peak of a resonance as narrow as the search allows (a tenth of a line) is five times the difference of its
    two neighbours; a tone that is not part of the response appears on one line alone.

    Parameters
    ----------
    h : (K, F) complex ndarray
        As measured, evenly spaced.
    """
    alone = np.zeros(h.shape, dtype=bool)
    if h.shape[1] >= 32:
        height = np.abs(h[:, 1:-1] - 0.5 * (h[:, :-2] + h[:, 2:]))
        beside = np.maximum(np.abs(h[:, 2:] - h[:, :-2]), roughness(h)[:, 1:-1])
        alone[:, 1:-1] = height > TONE_HEIGHT * beside
    found: NDArray[np.bool_] = np.asarray(alone.any(axis=0))
    return found
