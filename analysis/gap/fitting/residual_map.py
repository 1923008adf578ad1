"""Residual over channel, frequency, temperature, ramp and level, and whether it is noise."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects, label

from analysis.arrays import Real
from analysis.gap.data.noise import NoiseCheck
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.gap_fit import GapFit

LAGS = 3
"""Largest lag in nodes: about a resonance's half width."""
BINS = 24
"""Width of a frequency bin, in half widths of a resonance."""
CELL_SIGNIFICANT = 5.0
"""Standard deviations from which a cell counts: none of two thousand cells of noise reaches it."""
CELL_SHARE = 0.1
"""Smallest excess of a region's cells, as a share of the strongest: weaker ones would join all regions."""


@dataclass(frozen=True)
class Region:
    """A connected part of one channel's map that holds more than noise.

    Attributes
    ----------
    channel : str
    frequency : (float, float)
        Hz.
    temperature : (float, float)
        Degrees Celsius.
    share : float
        Share of the total excess chi2.
    sigma : float
        Largest rms residual of a cell, in sigma.
    """

    channel: str
    frequency: tuple[float, float]
    temperature: tuple[float, float]
    share: float
    sigma: float


@dataclass(frozen=True)
class ResidualMap:
    """Residual of a fit over frequency, sweep and channel.

    Attributes
    ----------
    edges : (B + 1,) ndarray
        Of the frequency bins, Hz.
    temperature : (T,) ndarray
        Of the sweeps, degrees Celsius.
    direction : tuple of str
    level : (T,) ndarray
        Of the drive, in the unit of its input.
    drives : tuple of str
        The same as text, see `GapSweeps`.
    channels : tuple of str
    sigma : (T, K, B) ndarray
        rms residual in units of noise: 1 where only noise is left.
    excess : (T, K, B) ndarray
        chi2 minus that of noise.
    readings : (T,) ndarray
        The same for each sweep's temperature reading.
    regions : tuple of Region
        Connected cells with more than noise, strongest first.
    """

    edges: Real
    temperature: Real
    direction: tuple[str, ...]
    level: Real
    drives: tuple[str, ...]
    channels: tuple[str, ...]
    sigma: Real
    excess: Real
    readings: Real
    regions: tuple[Region, ...]

    def shares(self) -> dict[str, dict[str, float]]:
        """Shares of the excess by channel, frequency, temperature, ramp, level, and of the readings."""
        total = float(self.excess.sum() + self.readings.sum())
        if total <= 0.0:
            return {}
        by_sweep = (self.excess.sum((1, 2)) + self.readings) / total
        table: dict[str, dict[str, float]] = {
            "channel": dict(zip(self.channels, (self.excess.sum((0, 2)) / total).tolist(), strict=True)),
            "frequency": {
                f"{low:.0f}-{high:.0f} Hz": float(share)
                for low, high, share in zip(
                    self.edges[:-1], self.edges[1:], self.excess.sum((0, 1)) / total, strict=True
                )
            },
            "temperature": {},
            "direction": {},
            "level": {},
            "readings": {"temperature readings": float(self.readings.sum() / total)},
        }
        for t, way, level, share in zip(self.temperature, self.direction, self.drives, by_sweep, strict=True):
            for kind, name in (("temperature", f"{t:.0f} °C"), ("direction", way), ("level", level)):
                table[kind][name] = table[kind].get(name, 0.0) + float(share)
        return table


@dataclass(frozen=True)
class Signature:
    """Residual of the twin with one effect only.

    Attributes
    ----------
    effect : str
    sigma : (T, K, B) ndarray
        rms residual in the cells of `ResidualMap.sigma`.
    fitted : bool
        True if fitted in full; False if to first order, as in the score test.
    """

    effect: str
    sigma: NDArray[np.float64]
    fitted: bool


def residual_map(sweeps: GapSweeps, noise: NoiseCheck, fit: GapFit) -> ResidualMap:
    """Map the residual of a fit; features too sharp for the nodes are added at their frequency.

    Parameters
    ----------
    sweeps : GapSweeps
    noise : NoiseCheck
    fit : GapFit

    Returns
    -------
    ResidualMap
    """
    excess, sigma, count, edges = _cells(sweeps, noise, fit.residual)
    regions = _regions(sweeps, excess, sigma, count, edges)
    return ResidualMap(
        edges=edges,
        temperature=np.array([p.temperature for p in sweeps.points]),
        direction=sweeps.direction,
        level=np.array([p.level for p in sweeps.points]),
        drives=sweeps.drives,
        channels=sweeps.channels,
        sigma=sigma,
        excess=excess,
        readings=fit.readings,
        regions=regions,
    )


def cell_sigma(sweeps: GapSweeps, noise: NoiseCheck, residual: NDArray[np.complex128]) -> Real:
    """Return the rms residual of every cell of the map.

    Parameters
    ----------
    sweeps : GapSweeps
    noise : NoiseCheck
    residual : (T, K, n) complex ndarray
        Whitened.

    Returns
    -------
    (T, K, B) ndarray
        As `ResidualMap.sigma`, in units of noise.
    """
    return _cells(sweeps, noise, residual)[1]


def _cells(sweeps: GapSweeps, noise: NoiseCheck, residual: NDArray[np.complex128]) -> tuple[Real, ...]:
    """Return excess and sigma of `ResidualMap` (T, K, B), the noise's chi2 in a cell (B,), and edges (B + 1,)."""
    n = sweeps.nodes.frequency.size
    bins = min(BINS, n)
    starts = np.linspace(0, n, bins + 1).astype(int)
    power = np.add.reduceat(np.abs(residual) ** 2, starts[:-1], axis=-1)
    count = 2.0 * np.diff(starts)
    edges = np.append(sweeps.nodes.frequency[starts[:-1]], sweeps.nodes.frequency[-1])
    excess = power - count
    lines = sweeps.nodes.lines
    blocks = noise.sharp.shape[-1]
    middle = lines[((np.arange(blocks) + 0.5) * lines.size / blocks).astype(int)]
    place = np.clip(np.searchsorted(edges, middle) - 1, 0, bins - 1)
    for block, bin_ in enumerate(place):
        excess[:, :, bin_] += noise.sharp[sweeps.original, :, block]
    return excess, np.sqrt(np.maximum(excess + count, 0.0) / count), count, edges


def _regions(sweeps: GapSweeps, excess: Real, sigma: Real, count: Real, edges: Real) -> tuple[Region, ...]:
    """Find connected cells over groups of temperature and bins of frequency, strongest first."""
    groups = len(sweeps.groups.reference)
    by_group, worst = np.zeros((groups, *excess.shape[1:])), np.zeros((groups, *excess.shape[1:]))
    np.add.at(by_group, sweeps.groups.of_sweep, excess)
    np.maximum.at(worst, sweeps.groups.of_sweep, sigma)
    noise = np.sqrt(2.0 * count * sweeps.groups.size[:, None])
    total = max(float(excess.sum()), 1e-300)
    largest = float(by_group.max())
    found = []
    for k, channel in enumerate(sweeps.channels):
        hot = (by_group[:, k] > CELL_SIGNIFICANT * noise) & (by_group[:, k] > CELL_SHARE * largest)
        labels, _ = label(hot)
        for number, (rows, columns) in enumerate(find_objects(labels), start=1):
            inside = labels == number
            found.append(
                Region(
                    channel=channel,
                    frequency=(float(edges[columns.start]), float(edges[columns.stop])),
                    temperature=(
                        float(sweeps.groups.reference[rows.start]),
                        float(sweeps.groups.reference[rows.stop - 1]),
                    ),
                    share=float(np.clip(by_group[:, k][inside].sum() / total, 0.0, 1.0)),
                    sigma=float(worst[:, k][inside].max()),
                )
            )
    return tuple(sorted(found, key=lambda r: -r.share))


def whiteness(sweeps: GapSweeps, residual: NDArray[np.complex128]) -> tuple[float, float]:
    """Correlation of `residual` (T, K, n) over frequency and over temperature, in standard deviations of noise.

    With real and imaginary parts of unit variance, products have variance 2; sums over many are normal.
    """
    rows = sweeps.rows
    over_frequency = [
        _correlation(residual[..., lag:], residual[..., :-lag], rows[..., lag:] & rows[..., :-lag])
        for lag in range(1, LAGS + 1)
    ]
    pairs = neighbours(sweeps)
    if not pairs:
        return float(np.sum(over_frequency) / np.sqrt(LAGS)), 0.0
    left, right = np.array(pairs).T
    over_temperature = _correlation(residual[left], residual[right], rows[left] & rows[right])
    return float(np.sum(over_frequency) / np.sqrt(LAGS)), over_temperature


def neighbours(sweeps: GapSweeps) -> list[tuple[int, int]]:
    """Sweeps next to each other in temperature, at one level of one input and on one ramp."""
    return [pair for leg in sweeps.legs for pair in pairwise(leg)]


def _correlation(a: NDArray[np.complex128], b: NDArray[np.complex128], rows: NDArray[np.bool_]) -> float:
    count = max(int(rows.sum()), 1)
    return float((a * b.conj()).real.sum() / np.sqrt(2.0 * count))
