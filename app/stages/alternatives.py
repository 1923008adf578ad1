"""Alternatives to a declaration: channels exchanged, a transducer at another place, other lengths."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from analysis.arrays import Real
from analysis.channel import Channel
from analysis.experiment import Experiment
from analysis.geometry.fault import GeometryError
from analysis.layout import check_patches
from analysis.material import MaterialBox
from analysis.pairing.coarse_trial import SweepModes, scanned_materials
from analysis.pairing.mode_list import ModeList
from analysis.sheet_orthotropy import DeclaredOrthotropy
from analysis.updating.modulus_scan import levels, scan_grid, smoothed
from simulation.reduction.coarse_places import CoarsePlaces
from simulation.reduction.coarse_plate import CoarsePlate
from simulation.twin.instruments import ports

LEAST_CORRELATION_GAIN = 0.1
"""Least gain in the levels' correlation for a place to be tried; pairing then decides."""
PLACES_TRIED = 3
"""Places of each transducer that are tried."""
LEAST_PLACE_DISTANCE = 0.05
"""Least distance of these, as a share of the plate's longer side."""
ORTHOTROPY = (-0.3, -0.16, -0.08, 0.08, 0.16, 0.3)
"""Values of delta_e."""
LENGTHS = (0.8, 0.85, 0.9, 0.95, 1.05, 1.1, 1.15, 1.2)
"""Factors on each length of a rectangle."""


@dataclass(frozen=True)
class Alternative:
    """Another declaration or another reading of the same recordings, and what it says."""

    experiment: Experiment
    sweep: SweepModes
    words: str
    effect: str = ""
    """Effect of the library that it is an amount of."""


def orthotropic(experiment: Experiment, sweep: SweepModes) -> Iterator[Alternative]:
    """Yield the plate with different moduli along x and y, unless it is declared so."""
    material = experiment.plate.material
    if material is None or material.orthotropy is not None:
        return
    for delta in ORTHOTROPY:
        other = material.model_copy(update={"orthotropy": DeclaredOrthotropy(delta_e=delta, delta_g=0.0)})
        plate = experiment.plate.model_copy(update={"material": other})
        words = (
            f"the plate is orthotropic, E along y {1 + delta:.2f} and along x {1 - delta:.2f} times the mean: "
            "flexura gap estimates it; beyond 12 % declare [plate.material.orthotropy]"
        )
        yield Alternative(experiment.model_copy(update={"plate": plate}), sweep, words, "orthotropy")


def exchanged_channels(experiment: Experiment, box: MaterialBox, sweep: SweepModes) -> Iterator[Alternative]:
    """Yield the order of the channels in which their levels agree best with the plate's, if it is another one.

    Parameters
    ----------
    box : MaterialBox
        Of its plate.
    """
    count = len(sweep.h)
    if count < 2:
        return
    grid = scan_grid(sweep.frequency)
    seen = levels(smoothed(np.abs(sweep.h) ** 2, sweep.frequency, grid))
    model = CoarsePlate.of(experiment, box)
    best, order = -np.inf, np.arange(count)
    for material in scanned_materials(box):
        own = levels(smoothed(np.abs(model.frf(*material, grid, sweep.loss_factor)) ** 2, grid, grid))
        alike = own @ seen.T / len(grid)  # row: channel of the plate; column: as recorded
        _, recorded = linear_sum_assignment(alike, maximize=True)
        value = float(alike[np.arange(count), recorded].sum())
        if value > best:
            best, order = value, recorded
    if (order == np.arange(count)).all():
        return
    names = [output.id for output in experiment.outputs]
    words = ", ".join(f"{names[k]} is recorded as {names[j]}" for k, j in enumerate(order.tolist()) if k != j)
    modes = sweep.modes
    turned = ModeList(
        modes.frequency,
        modes.sigma_frequency,
        modes.damping_ratio,
        modes.sigma_damping_ratio,
        modes.residues[order],
        modes.certain,
    )
    other = replace(sweep, h=sweep.h[order], deviation=sweep.deviation[order], modes=turned)
    yield Alternative(experiment, other, f"the channels are exchanged: {words}")


def other_places(experiment: Experiment, box: MaterialBox, sweep: SweepModes) -> Iterator[Alternative]:
    """Yield every transducer at the places where the levels of its transfers agree better than where it stands.

    Parameters
    ----------
    box : MaterialBox
        Of its plate.
    """
    try:
        plate = CoarsePlaces.of(experiment, box)
    except (RuntimeError, GeometryError, np.linalg.LinAlgError):
        return
    source, outputs = experiment.inputs[0], list(experiment.outputs)
    for channel in (*outputs, source):
        own = [k for k, one in enumerate(outputs) if channel in (one, source)]
        others = [source] if channel is not source else outputs
        agreement = _agreement(plate, experiment, box, sweep, channel, own, others)
        length = float(np.ptp(experiment.plate.bounds, axis=0).max())
        declared = _place(experiment, channel)
        here = agreement[np.linalg.norm(plate.places - declared, axis=1).argmin()]
        for place in _best_places(
            plate.places, agreement, here + LEAST_CORRELATION_GAIN, LEAST_PLACE_DISTANCE * length
        ):
            moved = _moved(experiment, channel, place)
            if moved is not None:
                words = "{} stands at {:.3f}, {:.3f} m, not at {:.3f}, {:.3f} m as declared".format(
                    channel.id, *place, *declared
                )
                yield Alternative(moved, sweep, words)


def _agreement(
    plate: CoarsePlaces,
    experiment: Experiment,
    box: MaterialBox,
    sweep: SweepModes,
    channel: Channel,
    rows: list[int],
    others: list[Channel],
) -> Real:
    """Best correlation of levels over all materials with the transducer at every place, (G,)."""
    grid, port = scan_grid(sweep.frequency), ports(experiment)
    seen = levels(smoothed(np.abs(sweep.h[rows]) ** 2, sweep.frequency, grid))
    at_others = [port[one.id] for one in others]
    best = np.full(len(plate.places), -1.0)
    for material in scanned_materials(box):
        powers = plate.powers(material, grid, sweep.loss_factor, at_others, patch=channel.patch is not None)
        alike = [
            (one * levels(smoothed(power, grid, grid))).mean(axis=1)
            for one, power in zip(seen, powers, strict=True)
        ]
        best = np.maximum(best, np.mean(alike, axis=0))
    return best


def _best_places(places: Real, agreement: Real, least: float, apart: float) -> list[tuple[float, float]]:
    chosen: list[tuple[float, float]] = []
    for g in np.argsort(-agreement).tolist():
        if agreement[g] < least or len(chosen) == PLACES_TRIED:
            break
        if all(np.hypot(*(places[g] - np.array(one))) > apart for one in chosen):
            chosen.append((float(places[g, 0]), float(places[g, 1])))
    return chosen


def _place(experiment: Experiment, channel: Channel) -> tuple[float, float]:
    if channel.patch is not None:
        return experiment.patch[channel.patch].center
    assert channel.footprint is not None  # noqa: S101 (a channel is a patch or has a footprint)
    return channel.footprint.point


def _moved(experiment: Experiment, channel: Channel, place: tuple[float, float]) -> Experiment | None:
    """Return the experiment with a transducer elsewhere; None where it cannot be, or has several points."""
    if channel.patch is not None:
        patches = list(experiment.patch)
        patches[channel.patch] = patches[channel.patch].model_copy(update={"center": place})
        try:
            check_patches(experiment.plate, patches)
        except ValueError:
            return None
        return experiment.model_copy(update={"patch": tuple(patches)})
    for name in ("drive", "sensor"):
        ones = list(getattr(experiment, name))
        for k, one in enumerate(ones):
            if one.id == channel.id and one.point is not None:
                ones[k] = one.model_copy(update={"point": place})
                return experiment.model_copy(update={name: tuple(ones)})
    return None


def other_lengths(experiment: Experiment, box: MaterialBox, sweep: SweepModes) -> Iterator[Alternative]:
    """Yield a rectangle with another length of one side; mass, patches and points as declared.

    Parameters
    ----------
    box : MaterialBox
        Of its plate.
    """
    plate = experiment.plate
    if plate.outline is not None:
        return
    for axis, name in enumerate(("length_x", "length_y")):
        length = (plate.length_x, plate.length_y)[axis]
        for factor in LENGTHS:
            other = plate.model_copy(update={name: factor * length})
            try:
                check_patches(other, experiment.patch)
            except ValueError:
                continue
            words = f"{name} is {factor * length:.3f} m, not {length:g} m as declared"
            yield Alternative(experiment.model_copy(update={"plate": other}), sweep, words)
