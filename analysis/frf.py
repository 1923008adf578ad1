"""Frequency response functions: H1 over synchronous repeats, coherence, and variance per line.

A sweep that starts at rest and ends in silence is a periodic excitation: no window, no leakage, and
the repeats differ by noise alone. Drive and response come from the same card, so its filters and
delays cancel in the ratio.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d
from scipy.signal import savgol_filter

from analysis.campaign import Campaign, Sweep

SMOOTHING_HALF_WIDTH = 20
"""Lines on either side over which the noise power is averaged; noise spectra are smooth, FRFs are not."""

COPIES = 1e-12
"""Noise below this share of an FRF is that of rounding in double precision: no converter is so good."""


@dataclass(frozen=True)
class Frf:
    """FRFs of a campaign, one row per sweep in the order recorded.

    Attributes
    ----------
    temperature : (T,) ndarray
        Mean reading during the sweep, on the plate if there was a sensor on it, else the oven's, degrees Celsius.
    direction : tuple of str
        ``up`` or ``down``, per sweep.
    level : (T,) ndarray
        Drive amplitude, V.
    frequency : (F,) ndarray
        Hz, even spacing, inside the protocol's band.
    h : (T, K, F) complex ndarray
        H1 = G_yu / G_uu, V/V.
    variance : (T, K, F) ndarray
        E|h - H|^2 of the estimate (real and imaginary part together), (V/V)^2.
    coherence : (T, K, F) ndarray
        Of a single repeat, 0 to 1.
    excluded : (F,) bool ndarray
        Lines at mains harmonics: shown, never fitted.
    channels : tuple of str
        Sensor names.
    notes : tuple of str
        What was left out or looks wrong, for people.
    """

    temperature: NDArray[np.float64]
    direction: tuple[str, ...]
    level: NDArray[np.float64]
    frequency: NDArray[np.float64]
    h: NDArray[np.complex128]
    variance: NDArray[np.float64]
    coherence: NDArray[np.float64]
    excluded: NDArray[np.bool_]
    channels: tuple[str, ...]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        shape = (len(self.temperature), len(self.channels), len(self.frequency))
        for name in ("h", "variance", "coherence"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; (T, K, F) = {shape} wanted")
        if not (np.isfinite(self.h).all() and np.isfinite(self.variance).all()):
            raise ValueError("an FRF holds values that are not finite")

    @property
    def noise_floor(self) -> NDArray[np.float64]:
        """Noise of each sweep over its lines, as a share of rms|h|: (T,) ndarray."""
        used = ~self.excluded
        noise = self.variance[:, :, used].sum((1, 2))
        floor: NDArray[np.float64] = np.sqrt(noise / (np.abs(self.h[:, :, used]) ** 2).sum((1, 2)))
        return floor

    def require_noise(self) -> None:
        """Raise ValueError where a sweep's repeats tell no noise, so that its lines cannot be weighed."""
        used = ~self.excluded
        noise, size = self.variance[:, :, used].min(-1), (np.abs(self.h[:, :, used]) ** 2).mean(-1)
        for sweep, channel in np.argwhere(~(noise > COPIES**2 * size))[:1]:
            raise ValueError(
                f"channel {self.channels[channel]} at {self.temperature[sweep]:.1f} °C ({self.direction[sweep]}): "
                "lines without variance, the repeats agree to the last digit. They are copies of one recording: "
                "record at least two repeats of each sweep"
            )

    def turned(self, inverted: Sequence[str]) -> "Frf":
        """Return the FRFs with the sign of `inverted` channels turned, and a note that says so."""
        if not inverted:
            return self
        sign = np.where(np.isin(self.channels, list(inverted)), -1.0, 1.0)
        there = ", there or at the actuator" if set(inverted) == set(self.channels) else ""
        note = (
            f"channel {', '.join(inverted)} is inverted: wiring or patch polarity{there}; "
            "what follows is with its sign turned"
        )
        return replace(self, h=sign[:, None] * self.h, notes=(*self.notes, note))


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
        G_yu / G_uu, the cross and auto spectra averaged over the repeats (paper section 3.2).
    residual_power : (M // 2 + 1,) ndarray
        Unbiased variance of a single repeat's ratio about h; NaN for one repeat. From three repeats on, a straight
        drift over them is no noise: the oven ramps on, and h stands for the temperature in the middle.
    coherence : (M // 2 + 1,) ndarray
        |G_yu|^2 / (G_uu G_yy); identically 1 for one repeat, which says nothing.
    """
    u = np.fft.rfft(drive.astype(float), axis=1)
    y = np.fft.rfft(response.astype(float), axis=1)
    g_uu = (np.abs(u) ** 2).sum(0)
    g_yu = (y * u.conj()).sum(0)
    g_yy = (np.abs(y) ** 2).sum(0)
    h = g_yu / g_uu
    repeats = drive.shape[0]
    residual, freedom = y - h * u, repeats - 1
    if repeats > 2:
        place = np.arange(repeats) - 0.5 * (repeats - 1)
        residual = residual - np.outer(place, place @ residual) / (place @ place)
        freedom -= 1
    power = np.full(h.shape, np.nan)
    if freedom:
        power = (np.abs(residual) ** 2).sum(0) / freedom * repeats / g_uu
    return h, power, np.abs(g_yu) ** 2 / (g_uu * g_yy)


def bad_repeats(drive: NDArray[np.float32], response: NDArray[np.float32], lines: slice) -> list[int]:
    """Repeats whose ratio lies far from the others': a knock, a dropout, a loose cable.

    Each repeat's energy about the median repeat is compared with the median of these energies; more
    than sixteen times (four times in amplitude) is no noise of a steady rig. Needs three repeats.
    """
    if drive.shape[0] < 3:
        return []
    ratio = (np.fft.rfft(response.astype(float), axis=1) / np.fft.rfft(drive.astype(float), axis=1))[:, lines]
    middle = np.median(ratio.real, axis=0) + 1j * np.median(ratio.imag, axis=0)
    energy = (np.abs(ratio - middle) ** 2).sum(1)
    return [int(r) for r in np.flatnonzero(energy > 16.0 * np.median(energy))]


def mains_lines(frequency: NDArray[np.float64], mains: float, record: float) -> NDArray[np.bool_]:
    """Lines within one and a half spacings of a harmonic of `mains` [Hz], for a record of `record` seconds."""
    distance = np.abs(frequency - mains * np.round(frequency / mains))
    lines: NDArray[np.bool_] = distance < 1.5 / record
    return lines


def smooth_power(power: NDArray[np.float64], excluded: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Average noise power over neighbouring lines, leaving excluded lines out of every average."""
    width = 2 * SMOOTHING_HALF_WIDTH + 1
    kept = (~excluded).astype(float)
    total = uniform_filter1d(np.where(excluded, 0.0, power), width, axis=-1, mode="nearest")
    share = uniform_filter1d(kept, width, axis=-1, mode="nearest")
    smoothed: NDArray[np.float64] = total / np.maximum(share, 1.0 / width)
    return smoothed


def single_repeat_power(h: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Noise power per line of an FRF without repeats, from its roughness over frequency.

    What a local quartic over eleven lines leaves is noise where modes are many lines wide (local
    polynomial method: Pintelon and Schoukens, System Identification, 2012, ch. 7).
    """
    smooth = savgol_filter(h.real, 11, 4) + 1j * savgol_filter(h.imag, 11, 4)
    kept_share = 1.0 - savgol_filter(np.eye(1, 11, 5)[0], 11, 4)[5]
    power: NDArray[np.float64] = np.abs(h - smooth) ** 2 / kept_share
    return power


def campaign_frf(campaign: Campaign, *, mains: float = 50.0) -> Frf:
    """H1 of every sweep and sensor of a campaign, inside the protocol's band.

    Raises ValueError where the sweeps differ in length, so that they share no frequency lines.
    """
    rate = campaign.experiment.acquisition.sample_rate
    samples = campaign.sweeps[0].drive.shape[1]
    grid = np.fft.rfftfreq(samples, 1.0 / rate).astype(np.float64)
    low, high = campaign.experiment.protocol.band
    inside = np.flatnonzero((grid >= low - 1e-9) & (grid <= high + 1e-9))
    lines = slice(int(inside[0]), int(inside[-1]) + 1)
    excluded = mains_lines(grid[lines], mains, samples / rate)
    notes: list[str] = []
    names = tuple(p.id for p in campaign.experiment.sensors)
    rows = []
    for sweep in campaign.sweeps:
        if sweep.drive.shape[1] != samples:
            raise ValueError(f"sweep {sweep.step} has {sweep.drive.shape[1]} samples, the first one {samples}")
        rows.append(_sweep_frf(sweep, lines, excluded, names, notes))
    h, variance, coherence = (np.array(part) for part in zip(*rows, strict=True))
    return Frf(
        temperature=np.array([s.temperature for s in campaign.sweeps]),
        direction=tuple(s.direction for s in campaign.sweeps),
        level=np.array([s.level for s in campaign.sweeps]),
        frequency=grid[lines],
        h=h,
        variance=variance,
        coherence=coherence,
        excluded=excluded,
        channels=names,
        notes=tuple(notes),
    )


def _sweep_frf(
    sweep: Sweep, lines: slice, excluded: NDArray[np.bool_], names: Sequence[str], notes: list[str]
) -> tuple[list[NDArray[np.complex128]], list[NDArray[np.float64]], list[NDArray[np.float64]]]:
    """H1, its variance and the coherence of one sweep, each (K, F)."""
    h_rows, variance_rows, coherence_rows = [], [], []
    bad = {
        r: name
        for name, response in zip(names, sweep.responses, strict=True)
        for r in bad_repeats(sweep.drive, response, lines)
    }
    good = [r for r in range(sweep.drive.shape[0]) if r not in bad]
    notes.extend(f"step {sweep.step}: repeat {r + 1} left out, {name} strays" for r, name in bad.items())
    if len(good) < 2 <= sweep.drive.shape[0]:
        raise ValueError(f"sweep {sweep.step}: repeats {sorted(r + 1 for r in bad)} stray; too few are left")
    for response in sweep.responses:
        h, power, coherence = h1(sweep.drive[good], response[good])
        h, power = h[lines], power[lines]
        if len(good) == 1:
            power = single_repeat_power(h)
        h_rows.append(h)
        variance_rows.append(smooth_power(power, excluded) / len(good))
        coherence_rows.append(np.clip(coherence[lines], 0.0, 1.0))
    return h_rows, variance_rows, coherence_rows
