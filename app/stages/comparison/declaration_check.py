"""Declaration check on coarse models: a plate against one sweep, and other declarations where it is no fit."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from analysis.arrays import Real
from analysis.channel import Channel
from analysis.declaration.plate_material import KINDS, DeclaredOrthotropy, material_box
from analysis.experiment import Experiment, check_patches
from analysis.geometry.loop import GeometryError
from analysis.material import MaterialBox
from analysis.pairing.assignment import LEAST_SHARE, ModeList
from analysis.pairing.coarse_trial import CoarseTrial, SweepModes, scanned_materials, tried
from analysis.progress import Progress
from analysis.recordings.frf import Frf
from analysis.updating.start import ModulusScan, levels, scan_grid, scan_modulus, scanned_box, smoothed
from analysis.updating.update import middle_sweep
from app.files.bad_file import ResultFileError
from simulation.reduction.coarse_plate import CoarsePlaces, CoarsePlate
from simulation.twin.instruments import ports

STAGE = "checking the declaration"


def check_declaration(experiment: Experiment, frf: Frf, report: Progress) -> tuple[str, ...]:
    """Compare the resonances of one sweep with those of the declared plate.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    tuple of str
        Notes on doubtful declarations.

    Raises
    ------
    ResultFileError
        Where two sweeps, the middle one and the coldest or warmest, agree with no material in the declared ranges,
        but well with one outside.
    """
    report(STAGE, 0.0)
    box = material_box(experiment.plate.material)
    try:
        model = CoarsePlate.of(experiment, scanned_box(box))
    except (RuntimeError, GeometryError, np.linalg.LinAlgError):
        return ()  # if the check cannot be made, updating continues
    frf = frf.of_source(frf.driving[0])
    used, middle = ~frf.excluded, middle_sweep(frf)
    report(STAGE, 0.4)
    scans: dict[int, ModulusScan] = {}
    for sweep in dict.fromkeys((middle, int(frf.temperature.argmin()), int(frf.temperature.argmax()))):
        scans[sweep] = scan_modulus(model, frf.frequency[used], frf.h[sweep][:, used], box)
        if not scans[sweep].outside or len(scans) == 2:
            break
    report(STAGE, 1.0)
    if all(scan.far_outside for scan in scans.values()):
        raise ResultFileError(sentence(experiment, float(frf.temperature[middle]), scans[middle]))
    if all(scan.outside for scan in scans.values()):
        return (sentence(experiment, float(frf.temperature[middle]), scans[middle]),)
    return ()


def sentence(experiment: Experiment, temperature: float, scan: ModulusScan) -> str:
    """Describe what was declared, what the resonances suggest, and what to change.

    Parameters
    ----------
    temperature : float
        Of the sweep, degrees Celsius.
    """
    plate = experiment.plate
    low, high = material_box(plate.material).youngs_modulus
    ratio = scan.modulus / float(np.sqrt(low * high))
    # at constant mass, frequencies are proportional to the root of E h**3
    thinnest, middle, thickest = (
        1e3 * plate.thickness * (scan.modulus / e) ** (1.0 / 3.0) for e in (high, np.sqrt(low * high), low)
    )
    return (
        f"thickness {1e3 * plate.thickness:.3g} mm declared; the resonances at {temperature:.0f} °C say "
        f"{middle:.3g} mm ({thinnest:.2g} to {thickest:.2g} mm for E of {high / 1e9:.3g} to {low / 1e9:.3g} GPa), "
        f"or {ratio:.3g} times the modulus, {scan.modulus / 1e9:.3g} GPa. Check thickness, mass, lengths and "
        f"units; if they are right, declare in [plate.material] {_material(scan.modulus)}"
    )


def _material(modulus: float) -> str:
    kinds = [
        f'"{name}"' for name, box in KINDS.items() if box.youngs_modulus[0] <= modulus <= box.youngs_modulus[1]
    ]
    numbers = f"youngs_modulus = [{0.7 * modulus:.1e}, {1.4 * modulus:.1e}], with poisson_ratio and loss_factor"
    return f"kind = {' or '.join(kinds)}, or {numbers}" if kinds else numbers


LOOKING = "looking for the reason"
LIKELY_PAIRED_SHARE = 0.8
"""Share of paired modes from which an alternative is named: right ones had 0.95 and more, a wrong length beside a
wrong place, the length alone put right, 0.73."""
CLEAR_PAIRED_SHARE = 0.85
"""Share of paired modes from which no further alternatives are tried."""
LEAST_SHARE_GAIN = 0.2
"""Least gain in the share over the declaration's own; where this was tried, right ones gained 0.4 to 0.6."""
EQUAL_SHARES = 0.1
"""Difference of shares up to which two alternatives are both named: mirrored plates answer alike."""


@dataclass(frozen=True)
class LikelyReason:
    """What makes the modes pair, in a sentence, or that nothing tried does.

    Attributes
    ----------
    sentence : str
    wrong_declaration : bool
        Whether it is another declaration; an amount of an effect of the library is none.
    """

    sentence: str
    wrong_declaration: bool = False


Found = tuple[float, str, str]
"""Share of paired modes, sentence, and effect of the library or an empty string."""


def likely_reason(experiment: Experiment, sweep: SweepModes, report: Progress) -> LikelyReason:
    """Try alternatives to a declaration.

    Parameters
    ----------
    experiment : Experiment
        As declared.
    sweep : SweepModes
        One that the twin does not fit.
    report : callable
        Called with a stage's name and the share of it done.
    """
    report(LOOKING, 0.0)
    box = material_box(experiment.plate.material)
    declared = _tried(experiment, box, sweep)
    if declared is None:
        return LikelyReason("no likely reason was looked for: the declared plate has no coarse model")
    found: list[Found] = []
    families = _families(experiment, box, sweep, declared)
    for done, family in enumerate(families):
        report(LOOKING, (done + 1) / (len(families) + 1))
        found += family()
        if max(found, default=(0.0,))[0] >= CLEAR_PAIRED_SHARE:
            break
    report(LOOKING, 1.0)
    return _concluded(declared, sorted(found, reverse=True))


def _concluded(declared: CoarseTrial, found: list[Found]) -> LikelyReason:
    """Choose the best of what was found, best first."""
    own, least = declared.pairs.counted, max(LIKELY_PAIRED_SHARE, declared.share + LEAST_SHARE_GAIN)
    if found and found[0][0] >= least:
        as_good = [words for share, words, _ in found[:2] if share >= max(least, found[0][0] - EQUAL_SHARES)]
        sentence = f"likely reason, tried on a coarse model that as declared has {own}: {', or: '.join(as_good)}"
        return LikelyReason(sentence, not found[0][2])
    if declared.share >= LEAST_SHARE:
        return LikelyReason(
            f"with a modulus of {declared.youngs_modulus / 1e9:.3g} GPa a coarse model of the declared plate has "
            f"{own}: the fit ended at a wrong material, or the sweeps do not belong together. Narrow the ranges "
            "in [plate.material], and look at the single sweeps"
        )
    return LikelyReason(
        f"no likely reason found: as declared, a coarse model has {own}; another thickness, mass or material, "
        "stiffness that differs along x and y, channels exchanged or inverted, another place of each transducer "
        "and other lengths, each alone, do not bring enough. Several of these may be wrong, or something that was "
        "not tried: outline, supports, holes. Or the plate has a large effect: flexura gap tries those of its "
        "library"
    )


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


def _families(
    experiment: Experiment, box: MaterialBox, sweep: SweepModes, declared: CoarseTrial
) -> list[Callable[[], Iterable[Found]]]:
    """Return what yields, for each kind of alternative, shares and sentences."""

    def material() -> Iterator[Found]:
        found = _tried(experiment, scanned_box(box), sweep)
        low, high = box.youngs_modulus
        if found is not None and not low <= found.youngs_modulus <= high:
            scan = ModulusScan(found.youngs_modulus, 1.0, declared.youngs_modulus, 0.0)
            yield (
                found.share,
                f"{sentence(experiment, sweep.temperature, scan)}. It then has {found.pairs.counted}",
                "",
            )

    def of(alternatives: Iterator[Alternative]) -> Iterator[Found]:
        for other in alternatives:
            found = _tried(other.experiment, box, other.sweep)
            if found is not None:
                yield found.share, f"{other.words}. It then has {found.pairs.counted}", other.effect

    return [
        material,
        lambda: of(orthotropic(experiment, sweep)),
        lambda: of(exchanged_channels(experiment, box, sweep)),
        lambda: of(other_places(experiment, box, sweep)),
        lambda: of(other_lengths(experiment, box, sweep)),
    ]


def _tried(experiment: Experiment, box: MaterialBox, sweep: SweepModes) -> CoarseTrial | None:
    """Try one declaration; None where no coarse model can be made of it: transducers off a shorter plate, say."""
    try:
        plate = CoarsePlate.of(experiment, box)
    except (RuntimeError, ValueError):
        return None
    return tried(plate, box, sweep)
