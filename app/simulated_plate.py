"""The simulated rig's plate: the twin, driven by an amplifier, at a temperature that drifts."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from analysis.material import MaterialLaws
from simulation.twin import Twin

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

SPACING = 0.1
"""Temperatures at which the twin is asked, K: a resonance moves by a hundredth of its width in between."""
BEYOND = (0.4, 1.25)
"""How far below and above its band the twin is still used, as shares of the band's edges.

There it is not certified, but the drive fades there, and a response cut off at the edge itself would
ring in the record.
"""
KEPT = 4


@dataclass
class TwinPlate:
    """Volts on the output in, volts on the sensors out; hand it to the simulated cards.

    While the temperature T(t) drifts, the response is the sum of those at fixed temperatures, each
    weighted by how near T(t) is to it (linear interpolation in temperature): the plate forgets within
    a second, in which the drift is milli-kelvins.

    Parameters
    ----------
    twin : Twin
    laws : MaterialLaws
    gain : float
        Of the amplifier, V/V.
    memory : float
        How long the plate is followed after the drive ends, s.
    """

    twin: Twin
    laws: MaterialLaws
    gain: float
    memory: float = 1.0
    _transfers: dict[tuple[float, float, int], Complex] = field(default_factory=dict, repr=False)

    def __call__(self, drive: Real, sample_rate: float, temperature: Real) -> Real:
        """Return the sensors' voltages (K, M) for a drive (M,), V, at temperatures (M,), degrees Celsius."""
        length = next_fast_len(drive.size + round(self.memory * sample_rate), real=True)
        spectrum = self.gain * rfft(drive, length)
        answer = np.zeros((len(self.twin.sensors), drive.size))
        first = int(np.floor(temperature.min() / SPACING))
        last = int(np.floor(temperature.max() / SPACING)) + 1
        for node in range(first, last + 1):
            weight = np.clip(1.0 - np.abs(temperature / SPACING - node), 0.0, None)
            if weight.any():
                transfer = self._transfer(round(node * SPACING, 6), sample_rate, length)
                answer += weight * irfft(transfer * spectrum, length)[:, : drive.size]
        return answer

    def _transfer(self, temperature: float, sample_rate: float, length: int) -> Complex:
        """Sensor volts per volt on the patch, (K, L), zero well outside the twin's band."""
        key = (temperature, sample_rate, length)
        if key not in self._transfers:
            while len(self._transfers) >= KEPT:
                del self._transfers[next(iter(self._transfers))]
            self._transfers[key] = self._computed(temperature, sample_rate, length)
        return self._transfers[key]

    def _computed(self, temperature: float, sample_rate: float, length: int) -> Complex:
        grid = rfftfreq(length, 1.0 / sample_rate)
        low, high = self.twin.band
        bottom, top = BEYOND[0] * low, min(BEYOND[1] * high, 0.49 * sample_rate)
        inside = np.flatnonzero((grid > bottom) & (grid < top))
        lines = grid[inside]
        material = self.laws.at(temperature)
        constants = (
            float(material.youngs_modulus[0]),
            float(material.poisson_ratio[0]),
            float(material.loss_factor[0]),
        )
        transfer = np.zeros((len(self.twin.sensors), grid.size), dtype=complex)
        transfer[:, inside] = _fade(lines, bottom, low, high, top) * _frf_beyond_band(self.twin, constants, lines)
        return transfer


def _frf_beyond_band(twin: Twin, constants: tuple[float, float, float], lines: Real) -> Complex:
    """`Twin.frf`, at frequencies too for which it certifies nothing and therefore refuses."""
    reduced, sensors = twin.reduced, list(twin.sensors)
    joined = reduced.coupling[:, [*sensors, twin.actuator]]
    answer = reduced.modal_form(*constants).compliance(reduced.coupling[:, sensors], joined, lines)
    return twin.load.voltages(answer[:, -1], answer[:, :-1], reduced.capacitance[sensors], lines)


def _fade(lines: Real, bottom: float, low: float, high: float, top: float) -> Real:
    """1 inside the band, raised cosines down to 0 at `bottom` and `top`."""
    rising = np.clip((lines - bottom) / (low - bottom), 0.0, 1.0)
    falling = np.clip((top - lines) / (top - high), 0.0, 1.0) if top > high else np.ones_like(lines)
    return np.asarray((0.5 - 0.5 * np.cos(np.pi * rising)) * (0.5 - 0.5 * np.cos(np.pi * falling)))
