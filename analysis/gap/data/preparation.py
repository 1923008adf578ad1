"""Preparation of a campaign for a fit: compress sweeps, check noise, group temperatures."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Protocol
from analysis.gap.data.compression import CompressedSweep, Nodes, compress
from analysis.gap.data.groups import LawSmoothness, TemperatureGroups, mean_laws
from analysis.gap.data.noise import NoiseCheck, NumericalFloor, check_noise
from analysis.gap.data.sweeps import GapSweeps, LineWeights
from analysis.gap.thresholds import MODEL_ERROR, READING_SIGMA, SHARPEST
from analysis.material import LocalLaws, Material
from analysis.recordings.frf import Frf
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated

FINER = 0.6
"""Factor on the loss factor for which nodes are placed, if no effects are searched: with it spline errors shift no
estimate by more than 0.004 of its standard deviation (0.1 without, at a misfit of 0.7 %)."""


EVERY_LINE = 1e-12
"""Loss factor so small that every line is a node."""


def sharpest(material: Material) -> float:
    """Return the smallest loss factor for which nodes are placed."""
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
        Gives the ramp rate and when the sweeps pass their frequencies.
    updated : Updated
        Model updating of the same sweeps; its smallest loss factor determines the spacing of nodes.
    floor : NumericalFloor, optional
        Discretisation error of the twin; that of a converged twin by default.
    reading_sigma : float
        Standard deviation of a sweep's temperature reading, K.

    Returns
    -------
    sweeps : GapSweeps
        With the noise rescaled by the check.
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
    stated = compressed(frf, sharpest(updated.sharpest))
    noise = check_noise(stated, frf.channels, frf.repeats_dof)
    groups = TemperatureGroups.of(frf.temperature)
    sweeps = grouped(
        frf,
        [s.rescaled(noise.ratio) for s in stated],
        groups,
        mean_laws(updated.material, groups),
        protocol=protocol,
        reading_sigma=reading_sigma,
        twin_error=floor.carried if floor is not None else MODEL_ERROR,
    )
    return sweeps, noise


def apart(frf: Frf, material: Material, protocol: Protocol | None = None) -> GapSweeps:
    """Compress all sweeps, each in a group of its own, with the noise as stated.

    Parameters
    ----------
    frf : Frf
    material : Material
        Approximate ones of the sweeps, (T,) arrays: the sharpest determines the spacing of nodes.
    protocol : Protocol, optional
        As in `sweep_points`.

    Returns
    -------
    GapSweeps
    """
    groups = TemperatureGroups.labelled(np.arange(len(frf.temperature)), frf.temperature)
    try:
        stated = compressed(frf, FINER * sharpest(material))
    except ValueError:  # too few lines for splines: each line is a node
        stated = compressed(frf, EVERY_LINE)
    rough = mean_laws(material, groups)
    flat = LawSmoothness.flat(groups.reference)
    return grouped(frf, stated, groups, rough, protocol=protocol, smoothness=flat)


def nodes_over(frequency: NDArray[np.float64], laws: Sequence[LocalLaws]) -> Nodes:
    """Nodes from which splines give a model with any of the laws, or its derivatives, at all lines (F,), Hz."""
    sharpest = min(float(law.loss_factor(law.reference)) for law in laws)
    spacing = float(np.median(np.diff(frequency)))
    try:
        return Nodes.over(frequency, FINER * sharpest, spacing=spacing)
    except ValueError:  # too few lines for splines: each line is a node
        return Nodes.over(frequency, EVERY_LINE, spacing=spacing)


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
    protocol: Protocol | None = None,
    reading_sigma: float = READING_SIGMA / np.sqrt(2.0),
    twin_error: float = MODEL_ERROR,
    smoothness: LawSmoothness | None = None,
) -> GapSweeps:
    """Combine compressed sweeps and their groups into one value.

    Parameters
    ----------
    frf : Frf
    sweeps : sequence of CompressedSweep
        Of `frf`.
    groups : TemperatureGroups
    rough : (G, 3) ndarray
        Approximate laws of the groups: log E, nu and log eta.
    protocol : Protocol, optional
        As in `sweep_points`.
    reading_sigma, twin_error : float
        See `GapSweeps`.
    smoothness : LawSmoothness, optional
        By default that of laws through `rough`.

    Returns
    -------
    GapSweeps
    """
    nodes = sweeps[0].nodes
    shape = len(sweeps), len(frf.channels), nodes.frequency.size
    return GapSweeps(
        nodes=nodes,
        points=sweep_points(frf, protocol),
        direction=frf.direction,
        drives=tuple(frf.drive(sweep) for sweep in range(len(frf.direction))),
        channels=frf.channels,
        compressed=tuple(sweeps),
        groups=groups,
        reading_sigma=reading_sigma,
        rough=rough,
        smoothness=smoothness or LawSmoothness.of(groups.reference, rough),
        twin_error=twin_error,
        rows=np.ones(shape, dtype=bool),
        original=np.arange(len(sweeps)),
        weights=LineWeights.equal(shape),
    )


def sweep_points(frf: Frf, protocol: Protocol | None = None) -> tuple[SweepPoint, ...]:
    """Return the circumstances of every sweep; without a `protocol`, at a steady temperature."""
    rate = protocol.ramp_rate / 60.0 if protocol else 0.0
    timing = protocol.timing if protocol else None
    return tuple(
        SweepPoint(float(t), rate if way == "up" else -rate, float(level), int(source), timing)
        for t, way, level, source in zip(frf.temperature, frf.direction, frf.level, frf.driven_by, strict=True)
    )
