"""The simulated rig's plate: a twin, driven by an amplifier or an exciter, at a temperature that drifts."""

from dataclasses import dataclass, field

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from analysis.arrays import Complex, Real
from analysis.sweep_point import SweepPoint
from app.rig.plate_transfer import PlateTransfer

TEMPERATURE_SPACING = 0.2
"""Temperatures at which the twin is asked, K: a resonance of soft polymer moves by a tenth of its half width in
between, of which cubic interpolation leaves 2e-5 of its peak. Linear interpolation at half the spacing would leave
4e-4, always lower: more damping than there is."""
BAND_FACTORS = (0.4, 1.25)
"""How far below and above its band the twin is still used, as shares of the band's edges.

There it is not certified, but the drive fades there, and a response cut off at the edge itself would
ring in the record.
"""
TRANSFERS_KEPT = 6
"""Responses kept: four nodes of one temperature, and those that a slow ramp adds next."""
RATE_STEP = 1e-5
"""K/s to which a drift is rounded, so that sweeps in one steady ramp share a response: 9 mK of a lag of 900 s."""
LEVEL_DIGITS = 3
"""Digits to which a drive's amplitude is rounded, so that sweeps of one level share a response."""


@dataclass
class TwinPlate:
    """Volts on the output in, volts on the sensors out; hand it to the simulated cards.

    While the temperature T(t) drifts, the response is the sum of those at fixed temperatures, each
    weighted by how near T(t) is to it (cubic interpolation in temperature): the response decays within
    a second, in which the drift is milli-kelvins.

    Parameters
    ----------
    transfer : PlateTransfer
        Outputs per volt on the patch, or per newton.
    gain : float
        Of the amplifier, V/V, or of the exciter, N/V.
    memory : float
        How long the plate is followed after the drive ends, s.
    sensitivity : (K,) ndarray or float
        Volts at the cards per unit of each output.
    source : int
        Which of the plate's inputs is driven.
    louder : float
        Its gain over that of the first input: levels are counted by the first's.
    """

    transfer: PlateTransfer
    gain: float
    memory: float = 1.0
    sensitivity: Real | float = 1.0
    source: int = 0
    louder: float = 1.0
    _transfers: dict[tuple[SweepPoint, float, int], Complex] = field(default_factory=dict, repr=False)

    def __call__(self, drive: Real, sample_rate: float, temperature: Real) -> Real:
        """Return the sensors' voltages (K, M) for a drive (M,), V, at temperatures (M,), degrees Celsius."""
        length = next_fast_len(drive.size + round(self.memory * sample_rate), real=True)
        spectrum = self.gain * rfft(drive, length)
        answer = np.zeros((self.transfer.outputs, drive.size))
        if not drive.any():
            return answer
        rate, level = self._circumstances(drive, sample_rate, temperature)
        first = int(np.floor(temperature.min() / TEMPERATURE_SPACING)) - 1
        last = int(np.floor(temperature.max() / TEMPERATURE_SPACING)) + 2
        for node in range(first, last + 1):
            weight = _cubic(temperature / TEMPERATURE_SPACING - node)
            if weight.any():
                point = SweepPoint(round(node * TEMPERATURE_SPACING, 6), rate, level * self.louder, self.source)
                transfer = self._transfer(point, sample_rate, length)
                answer += weight * irfft(transfer * spectrum, length)[:, : drive.size]
        return np.asarray(np.reshape(self.sensitivity, (-1, 1)) * answer)

    def _circumstances(self, drive: Real, sample_rate: float, temperature: Real) -> tuple[float, float]:
        """Rate of the temperature over the record, K/s, and the drive's amplitude before the amplifier, V."""
        rate, level = 0.0, 1.0
        if "rate" in self.transfer.follows:
            drift = float(temperature[-1] - temperature[0]) * sample_rate / max(temperature.size - 1, 1)
            rate = round(drift / RATE_STEP) * RATE_STEP
        if "level" in self.transfer.follows:
            level = float(f"{np.abs(drive).max():.{LEVEL_DIGITS}g}")
        return rate, level

    def _transfer(self, point: SweepPoint, sample_rate: float, length: int) -> Complex:
        """Return the outputs per unit of the input, (K, L), zero well outside the twin's band."""
        key = (point, sample_rate, length)
        if key not in self._transfers:
            while len(self._transfers) >= TRANSFERS_KEPT:
                del self._transfers[next(iter(self._transfers))]
            self._transfers[key] = self._computed(point, sample_rate, length)
        return self._transfers[key]

    def _computed(self, point: SweepPoint, sample_rate: float, length: int) -> Complex:
        grid = rfftfreq(length, 1.0 / sample_rate)
        low, high = self.transfer.band
        bottom, top = BAND_FACTORS[0] * low, min(BAND_FACTORS[1] * high, 0.49 * sample_rate)
        inside = np.flatnonzero((grid > bottom) & (grid < top))
        lines = grid[inside]
        transfer = np.zeros((self.transfer.outputs, grid.size), dtype=complex)
        transfer[:, inside] = _fade(lines, bottom, low, high, top) * self.transfer(point, lines)
        return transfer


def _cubic(x: Real) -> Real:
    """Weight of a node x spacings away: the cubic through the two nodes on either side."""
    x = np.abs(x)
    near, far = 0.5 * (1.0 - x**2) * (2.0 - x), (1.0 - x) * (2.0 - x) * (3.0 - x) / 6.0
    return np.asarray(np.where(x < 1.0, near, np.where(x < 2.0, far, 0.0)))


def _fade(lines: Real, bottom: float, low: float, high: float, top: float) -> Real:
    """1 inside the band, raised cosines down to 0 at `bottom` and `top`."""
    rising = np.clip((lines - bottom) / (low - bottom), 0.0, 1.0)
    falling = np.clip((top - lines) / (top - high), 0.0, 1.0) if top > high else np.ones_like(lines)
    return np.asarray((0.5 - 0.5 * np.cos(np.pi * rising)) * (0.5 - 0.5 * np.cos(np.pi * falling)))
