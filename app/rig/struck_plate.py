"""The plate of a simulated hammer test: the twin, hit at one of its points, read by accelerometers."""

from dataclasses import dataclass

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from analysis.arrays import Real
from analysis.sweep_point import SweepPoint
from app.rig.plate_transfer import PlateTransfer

TOP_OF_BAND_FACTOR = 1.25
"""How far above its band the twin is still used, as a share of its end: the response fades between, for one that
was cut off at the end itself would ring before the hit. Below the band it is used down to 0 Hz, where a free plate
moves as a rigid body, which the twin keeps (within 1.4 % of the closed form on a plate of 0.24 m)."""
TEMPERATURE_ROUNDING = 0.01
"""K to which the plate's temperature is rounded: a hundredth of a degree moves a resonance of soft polymer by some
thousandth of its half width."""


@dataclass(frozen=True)
class TwinUnderHammer:
    """Newtons at a point in, volts of the accelerometers out.

    Attributes
    ----------
    transfer : PlateTransfer
        With an input for each point.
    volts : (K,) ndarray
        Sensitivities, V per m/s2.
    """

    transfer: PlateTransfer
    volts: Real

    def __call__(self, point: int, force: Real, sample_rate: float, temperature: float) -> Real:
        """Return the sensors' voltages (K, M).

        Parameters
        ----------
        point : int
            That is hit, from 0.
        force : (M,) ndarray, N
        sample_rate : float
            Hz.
        temperature : float
            Degrees Celsius.
        """
        if not force.any():
            return np.zeros((self.volts.size, force.size))
        # what still rings at the end is cut off there, not wrapped round to the beginning
        length = next_fast_len(2 * force.size, real=True)
        grid = rfftfreq(length, 1.0 / sample_rate)
        high = self.transfer.band[1]
        top = min(TOP_OF_BAND_FACTOR * high, 0.49 * sample_rate)
        inside = np.flatnonzero((grid > 0.0) & (grid < top))
        level = float(np.abs(force).max())
        steady = SweepPoint(TEMPERATURE_ROUNDING * round(temperature / TEMPERATURE_ROUNDING), 0.0, level, point)
        h = np.zeros((self.volts.size, grid.size), dtype=complex)
        falling = 0.5 - 0.5 * np.cos(np.pi * np.clip((top - grid[inside]) / (top - high), 0.0, 1.0))
        h[:, inside] = falling * self.transfer(steady, grid[inside])
        h[:, 0] = h[:, 1].real
        return np.asarray(self.volts[:, None] * irfft(h * rfft(force, length), length)[:, : force.size])
