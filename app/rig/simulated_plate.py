"""The simulated rig's plate: a twin, driven by an amplifier or an exciter, or hit; temperatures drift."""

from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq

from analysis.arrays import Complex, Real
from analysis.material import LocalLaws, MaterialLaws
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Effects
from simulation.twin.local_plate import ReducedPlate
from simulation.twin.twin import Twin

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


Followed = frozenset[Literal["rate", "level"]]


class PlateTransfer(Protocol):
    """Outputs per unit of the input: sensor volts per volt on the actuator patch, in most campaigns."""

    @property
    def band(self) -> tuple[float, float]:
        """Where it is certified, Hz; it answers a little outside too."""
        ...

    @property
    def outputs(self) -> int:
        """Number of outputs K."""
        ...

    @property
    def follows(self) -> Followed:
        """What of a `SweepPoint` may matter besides its temperature."""
        ...

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """Transfer (K, F) over `frequency` (F,), Hz; ValueError outside the laws' range."""
        ...


@dataclass(frozen=True)
class TwinTransfer:
    """The twin, some effects on; strain energies are counted already (`Twin.referred`) where any asks.

    A `SweepPoint`'s temperature is what a sensor on the plate would read, the rig's own thermal lag in it; its
    rate is that temperature's. So `thermal_lag` comes on top: the plate behind its own sensor.
    """

    twin: Twin[ReducedPlate]
    laws: MaterialLaws
    effects: Effects = field(default_factory=dict)

    @property
    def band(self) -> tuple[float, float]:
        """The twin's."""
        return self.twin.band

    @property
    def outputs(self) -> int:
        """Number of outputs."""
        return self.twin.outputs

    @property
    def follows(self) -> Followed:
        """Effects, a user's own among them, may follow rate and level; the plate as declared does not."""
        return frozenset({"rate", "level"}) if self.effects else frozenset()

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """`Twin.uncertified_frf` with the laws expanded about the temperature that the plate then has.

        Frequencies just outside the band are asked for, too.
        """
        return self.twin.uncertified_frf(self.local_laws(point), frequency, self.effects, point)

    def local_laws(self, point: SweepPoint) -> LocalLaws:
        """Return the laws near the plate's mean temperature; ValueError where they do not reach."""
        return self.laws.local(self.mean_temperature(point))

    def mean_temperature(self, point: SweepPoint) -> float:
        """Of the plate at one sweep, degrees Celsius."""
        steady = {name: v for name, v in self.effects.items() if not self.twin.library[name].needs_strain_energy}
        if not steady:
            return point.temperature
        near = self.laws.local(point.temperature)
        return float(self.twin.state(near, np.array(self.band), steady, point).mean_temperature)


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
