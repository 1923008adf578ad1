"""A campaign ready to be compared with a twin: compressed sweeps, their circumstances and groups."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Protocol
from analysis.frf import Frf
from analysis.gap.data.compression import CompressedSweep, Nodes, compress
from analysis.gap.data.groups import TemperatureGroups, mean_laws
from analysis.gap.data.noise import NoiseCheck, check_noise
from analysis.gap.data.numerical_floor import NumericalFloor
from analysis.gap.thresholds import MODEL_ERROR, MODEL_ERROR_ALONG, READING_SIGMA, SHARPEST
from analysis.material import Material
from analysis.sweep_point import SweepPoint
from analysis.updated import Updated


@dataclass(frozen=True)
class GapSweeps:
    """Sweeps of a campaign in whitened form.

    Attributes
    ----------
    nodes : Nodes
        Common to all sweeps and channels.
    points : tuple of SweepPoint
    direction : tuple of str
    channels : tuple of str
    compressed : tuple of CompressedSweep
        With the noise rescaled to what was seen.
    groups : TemperatureGroups
    reading_sigma : float
        Standard deviation of a sweep's temperature reading, K.
    rough : (G, 3) ndarray
        Laws about as they are, to tell how well their slopes are known.
    slope_sigma : (G, 3) ndarray
        Standard deviations of the laws' slopes, per K.
    twin_error : float
        Error of the twin common to all lines, as a share of rms|H|.
    rows : (T, K, n) bool ndarray
        Which whitened numbers take part; all but in held-out trials.
    original : (T,) int ndarray
        Place of each sweep in the FRFs.
    """

    nodes: Nodes
    points: tuple[SweepPoint, ...]
    direction: tuple[str, ...]
    channels: tuple[str, ...]
    compressed: tuple[CompressedSweep, ...]
    groups: TemperatureGroups
    reading_sigma: float
    rough: NDArray[np.float64]
    slope_sigma: NDArray[np.float64]
    twin_error: float
    rows: NDArray[np.bool_] = field(repr=False)
    original: NDArray[np.int_] = field(repr=False)

    @property
    def count(self) -> int:
        """Number of sweeps."""
        return len(self.points)

    @property
    def numbers(self) -> int:
        """Real numbers that take part."""
        return 2 * int(self.rows.sum())

    @property
    def power(self) -> float:
        """Sum of |h|^2 in units of the noise: a residual of a share e of |h| has a chi2 of e**2 times this."""
        white = np.array([s.whitened(s.coefficients) for s in self.compressed])
        return float((np.abs(white[self.rows]) ** 2).sum())

    @property
    def allowed(self) -> float:
        """Chi2 that the twin's own error may leave."""
        return self.twin_error**2 * self.power

    @property
    def overstated(self) -> float:
        """How many times evidence overstates itself, the twin's own error being common to all lines.

        Along a tangent the residual has the noise's variance 1 and that of the error: a log evidence of g counts
        as g over their sum.
        """
        return 1.0 + MODEL_ERROR_ALONG**2 * self.allowed

    @property
    def between(self) -> tuple[float, float]:
        """Return chi2 of what lines hold between the nodes, no model's doing, and its degrees of freedom.

        Of the channels and sweeps that take part, and where only a part of the band does, of as large a share.
        """
        share = self.rows.mean(-1)
        chi2 = sum(float(s.chi2_within.sum(1) @ part) for s, part in zip(self.compressed, share, strict=True))
        dof = sum(s.dof_within * float(part.sum()) for s, part in zip(self.compressed, share, strict=True))
        return chi2, dof

    def only(self, sweeps: Sequence[int]) -> "GapSweeps":
        """Return some of the sweeps, in the order given, with the groups they still form."""
        kept = np.asarray(sweeps, dtype=int)
        labels = np.unique(self.groups.of_sweep[kept], return_inverse=True)[1]
        temperature = np.array([self.points[s].temperature for s in kept])
        groups = TemperatureGroups.labelled(labels, temperature)
        rough = self.rough[np.unique(self.groups.of_sweep[kept])]
        return replace(
            self,
            points=tuple(self.points[s] for s in kept),
            direction=tuple(self.direction[s] for s in kept),
            compressed=tuple(self.compressed[s] for s in kept),
            groups=groups,
            rough=rough,
            slope_sigma=groups.slope_sigma(rough),
            rows=self.rows[kept],
            original=self.original[kept],
        )

    def original_places(self, whole: "GapSweeps") -> list[int]:
        """Return where the sweeps stand in `whole`, of which they are some."""
        place = {int(sweep): i for i, sweep in enumerate(whole.original)}
        return [place[int(sweep)] for sweep in self.original]

    def only_groups(self, groups: Sequence[int]) -> "GapSweeps":
        """Return all sweeps of some of the groups."""
        return self.only(np.flatnonzero(np.isin(self.groups.of_sweep, np.asarray(groups))).tolist())

    def masked(self, rows: NDArray[np.bool_]) -> "GapSweeps":
        """Return the same sweeps with only `rows` (broadcast to (T, K, n)) taking part."""
        return replace(self, rows=self.rows & rows)


FINER = 0.6
"""Of the loss factor for which nodes are laid, where no effect is looked for: with it the splines' own error moves
no estimate by more than 0.004 of its standard deviation (0.1 without, at a misfit of 0.7 %)."""

EVERY_LINE = 1e-12
"""Loss factor for whose resonances every line is a node."""


def sharpest(material: Material) -> float:
    """Return the least loss factor for which nodes are laid."""
    return SHARPEST * float(np.min(material.loss_factor))


def prepare(
    frf: Frf,
    protocol: Protocol,
    updated: Updated,
    *,
    floor: NumericalFloor | None = None,
    reading_sigma: float = READING_SIGMA / np.sqrt(2.0),
) -> tuple[GapSweeps, NoiseCheck]:
    """Compress all sweeps of a campaign and check their noise.

    Parameters
    ----------
    frf : Frf
        Measured; lines in `frf.excluded` take no part.
    protocol : Protocol
        Gives the ramp rate.
    updated : Updated
        Model updating of the same sweeps: nodes are placed for its smallest loss factor.
    floor : NumericalFloor, optional
        Discretisation error of the twin; that of a converged twin by default.
    reading_sigma : float
        Standard deviation of a sweep's temperature reading, K.

    Returns
    -------
    sweeps : GapSweeps
        With the noise rescaled to what was seen.
    noise : NoiseCheck

    Raises
    ------
    ValueError
        Where lines carry no variance, where the stated noise cannot be trusted, or where the lines are too few.
    """
    used = int((~frf.excluded).sum())
    if used < 20:
        raise ValueError(f"{used} usable frequency lines; at least 20 are needed to see a resonance")
    frf.require_noise()
    stated = compressed(frf, sharpest(updated.material))
    noise = check_noise(stated, frf.channels)
    groups = TemperatureGroups.of(frf.temperature)
    sweeps = grouped(
        frf,
        [s.rescaled(noise.ratio) for s in stated],
        groups,
        mean_laws(updated.material, groups),
        rate=protocol.ramp_rate / 60.0,
        reading_sigma=reading_sigma,
        twin_error=floor.carried if floor is not None else MODEL_ERROR,
    )
    return sweeps, noise


def apart(frf: Frf, material: Material) -> GapSweeps:
    """Compress all sweeps of `frf` for the sharpest of materials (T,) about as theirs, each a group of its own.

    The noise is taken as stated.
    """
    groups = TemperatureGroups.labelled(np.arange(len(frf.temperature)), frf.temperature)
    try:
        stated = compressed(frf, FINER * sharpest(material))
    except ValueError:  # too few lines between which splines could run: each is a node of its own
        stated = compressed(frf, EVERY_LINE)
    return grouped(frf, stated, groups, mean_laws(material, groups))


def compressed(frf: Frf, loss_factor: float) -> list[CompressedSweep]:
    """Compress the lines of all sweeps that are not excluded, for resonances no sharper than `loss_factor`.

    ValueError where the lines are too few.
    """
    used = np.flatnonzero(~frf.excluded)
    nodes = Nodes.over(frf.frequency[used], loss_factor, spacing=float(np.median(np.diff(frf.frequency))))
    return [compress(h[:, used], v[:, used], nodes) for h, v in zip(frf.h, frf.variance, strict=True)]


def grouped(
    frf: Frf,
    sweeps: Sequence[CompressedSweep],
    groups: TemperatureGroups,
    rough: NDArray[np.float64],
    *,
    rate: float = 0.0,
    reading_sigma: float = READING_SIGMA / np.sqrt(2.0),
    twin_error: float = MODEL_ERROR,
) -> GapSweeps:
    """Combine compressed sweeps and their groups into one value.

    Parameters
    ----------
    frf : Frf
    sweeps : sequence of CompressedSweep
        Of it.
    groups : TemperatureGroups
    rough : (G, 3) ndarray
        Laws of the groups, about.
    rate : float
        Of the oven on the way up, K/s.
    reading_sigma, twin_error : float
        See `GapSweeps`.

    Returns
    -------
    GapSweeps
    """
    nodes = sweeps[0].nodes
    return GapSweeps(
        nodes=nodes,
        points=tuple(
            SweepPoint(float(t), rate if way == "up" else -rate, float(level))
            for t, way, level in zip(frf.temperature, frf.direction, frf.level, strict=True)
        ),
        direction=frf.direction,
        channels=frf.channels,
        compressed=tuple(sweeps),
        groups=groups,
        reading_sigma=reading_sigma,
        rough=rough,
        slope_sigma=groups.slope_sigma(rough),
        twin_error=twin_error,
        rows=np.ones((len(sweeps), len(frf.channels), nodes.frequency.size), dtype=bool),
        original=np.arange(len(sweeps)),
    )
