"""Pairing: the modes measured in some sweeps beside those of a campaign's twin, for updating and gap."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from analysis.arrays import Complex, Real
from analysis.experiment import Experiment
from analysis.gap.data.preparation import sweep_points
from analysis.geometry.loop import GeometryError
from analysis.identification.automatic import identify
from analysis.identification.lines import Lines
from analysis.identification.modes import Modes
from analysis.identification.over_temperature.tracking import sweep_measured
from analysis.identification.pole_residue import ResidualTerms, choices_for
from analysis.identification.settings import Settings
from analysis.material import LocalLaws
from analysis.pairing.assignment import (
    HALF_POWER,
    POOR,
    ModeList,
    ModePairs,
    PairedSweeps,
    Pairing,
    Source,
    pair_modes,
)
from analysis.pairing.coarse_trial import SweepModes
from analysis.pairing.points import (
    FittingPlace,
    KnownShapes,
    PointComparison,
    compare_points,
    fitting_places,
    represented,
)
from analysis.progress import Progress
from analysis.recordings.frf import Frf, sweeps_of_modes
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import NO_EFFECTS, Effects
from analysis.updated import Updated
from analysis.updating.update import by_temperature
from app.files.bad_file import ResultFileError
from app.files.campaigns.inputs import has_other_sweeps, sweeps_of
from app.files.results.modes_file import load_modes, modes_made_from
from app.twins.computed_modes import computed_poles, poles_as_read, residues_at
from simulation.twin.instrumented_plate import InstrumentedPlate

STAGE = "modes of some sweeps"


@dataclass(frozen=True)
class MeasuredSweeps:
    """Modes identified in some sweeps of an FRF.

    Attributes
    ----------
    modes : mapping of int to Modes
        By the sweep's number, channels turned as in the FRF.
    source : str
        See `analysis.pairing.assignment.PairedSweeps`.
    terms : ResidualTerms
        With which residues of computed modes are found.
    """

    modes: Mapping[int, Modes]
    source: Source
    terms: ResidualTerms


def measured_sweeps(
    campaign: AnyCampaign, frf: Frf, updated: Updated, report: Progress, *, run: Path | None = None, mains: float
) -> MeasuredSweeps | None:
    """Take the modes from a run's modes.h5, or identify those of one sweep.

    Of modes.h5 the coldest, middle and warmest sweep are taken. Else the middle one is identified, and that of the
    largest misfit where a twin may be no fit there.

    Parameters
    ----------
    frf : Frf
        As fitted.
    updated : Updated
        Of the same sweeps.
    report : callable
        Called with a stage's name and the share of it done.
    run : Path, optional
        Run folder whose modes.h5 counts if it was made from the same recordings.
    mains : float
        Hz.

    Returns
    -------
    MeasuredSweeps or None
        None for FRFs in which no modes can be looked for: too few lines.
    """
    choices = choices_for(
        {"displacement" if o.patch is not None else o.quantity for o in campaign.experiment.outputs}
    )
    terms = max(choices, key=lambda one: one.parameters)
    order = by_temperature(frf, frf.driving[0])
    known = {} if run is None else _known(run / "modes.h5", campaign, frf)
    if known:
        rows = [t for t in order if t in known]
        wanted = dict.fromkeys((rows[0], rows[len(rows) // 2], rows[-1]))
        return MeasuredSweeps({t: known[t] for t in wanted}, "modes.h5", terms)
    middle, worst = order[len(order) // 2], max(order, key=lambda t: float(updated.misfit[t]))
    wanted = dict.fromkeys([middle, worst] if updated.misfit[worst] > POOR else [middle])
    found: dict[int, Modes] = {}
    settings = Settings(terms=(terms,), mains=mains or None)
    for done, t in enumerate(wanted):
        report(STAGE, done / len(wanted))
        try:
            found[t] = identify(sweep_measured(frf, t), settings)
        except ValueError:
            return None
    report(STAGE, 1.0)
    return MeasuredSweeps(found, "identified", terms)


def _known(path: Path, campaign: AnyCampaign, frf: Frf) -> dict[int, Modes]:
    """Modes in a file, by sweep of `frf`; none unless identified in the same recordings, without a twin."""
    if not path.is_file():
        return {}
    try:
        tracked, inputs = load_modes(path), modes_made_from(path)
    except ResultFileError:
        return {}
    if inputs != dict(campaign.hashes) or tracked.channels != frf.channels:
        return {}
    places = sweeps_of_modes(frf, tracked)
    return {int(t): _turned(tracked.modes[places[t]], frf, int(t)) for t in np.flatnonzero(places >= 0)}


def said_of_older_modes(path: Path, campaign: AnyCampaign) -> tuple[str, ...]:
    """Return a note where modes in a file are of other sweeps of a campaign, which has got more since."""
    try:
        made_from = modes_made_from(path) if path.is_file() else {}
    except ResultFileError:
        return ()
    if not has_other_sweeps(made_from, campaign.hashes):
        return ()
    return (
        f"{path}: of {len(sweeps_of(made_from))} sweeps; the campaign has {len(campaign.sweeps)} now, so that "
        "these modes are not paired: make it again with flexura identify",
    )


def _turned(modes: Modes, frf: Frf, sweep: int) -> Modes:
    """Give residues the signs of the FRF's channels, in which updating has corrected inverted ones."""
    inside = (frf.frequency >= modes.band[0]) & (frf.frequency <= modes.band[1])
    product = (frf.h[sweep][:, inside].conj() * modes.synthesis(frf.frequency[inside])).real.sum(axis=1)
    sign = np.where(product < 0.0, -1.0, 1.0)[:, None]
    return replace(modes, residues=sign * modes.residues, coefficients=sign * modes.coefficients)


def paired_sweeps(
    experiment: Experiment,
    frf: Frf,
    updated: Updated,
    measured: MeasuredSweeps | None,
    twin: InstrumentedPlate[Any],
    laws: Sequence[LocalLaws],
    answers: Complex,
    effects: Effects = NO_EFFECTS,
) -> PairedSweeps | None:
    """Pair measured modes with those of a twin.

    Parameters
    ----------
    frf : Frf
        T sweeps, as fitted.
    updated : Updated
        Of the same sweeps, for the twin with `effects`.
    laws : sequence of LocalLaws
        Near every sweep.
    answers : (T, K, F) complex ndarray
        FRFs of the twin, gain included.
    effects : mapping
        Values of those that are on.

    Returns
    -------
    PairedSweeps or None
        None without measured modes, and for a twin whose modes are not known, see
        `app.twins.computed_modes.computed_poles`.
    """
    if measured is None:
        return None
    points, used = sweep_points(frf, experiment.protocol), ~frf.excluded
    pairs: list[ModePairs] = []
    sizes: list[Real] = []
    for t, modes in measured.modes.items():
        poles = computed_poles(twin, laws[t], effects, points[t])
        if poles is None:
            return None
        inside = used & (frf.frequency >= modes.band[0] - 1e-6) & (frf.frequency <= modes.band[1] + 1e-6)
        of_twin = Lines(frf.frequency[inside], answers[t][:, inside], np.sqrt(frf.variance[t][:, inside]))
        residues = residues_at(poles, of_twin, measured.terms)
        rms = np.sqrt((np.abs(frf.h[t][:, inside]) ** 2).mean(axis=1))
        computed = ModeList.computed(poles, residues, rms, modes.damping)
        found = pair_modes(float(frf.temperature[t]), modes.band, ModeList.measured(modes, rms), computed)
        pairs.append(found.as_read(modes, poles, partial(poles_as_read, of_twin=of_twin, terms=measured.terms)))
        sizes.append(rms)
    rows = list(measured.modes)
    compared = _points(experiment, pairs, sizes, [laws[t] for t in measured.modes])
    return PairedSweeps(tuple(pairs), updated.misfit[rows], updated.noise_floor[rows], measured.source, compared)


def _points(
    experiment: Experiment, pairs: Sequence[ModePairs], rms: Sequence[Real], laws: Sequence[LocalLaws]
) -> PointComparison | None:
    """Compare strong pairs of near frequencies point by point.

    Parameters
    ----------
    rms : sequence of (K,) ndarray
        Of every sweep's FRFs.
    laws : sequence of LocalLaws
        Near every sweep.
    """
    frequency, measured, computed, material = [], [], [], []
    for one, size, law in zip(pairs, rms, laws, strict=True):
        near = one.measured.strong[one.measured_index] & (one.distance < HALF_POWER)
        i, j = one.measured_index[near], one.computed_index[near]
        frequency.append(one.measured.frequency[i])
        measured.append(one.measured.residues[:, i] * size[:, None])
        computed.append(one.computed.residues[:, j] * size[:, None])
        material.append(np.tile([np.exp(law.value[0]), law.value[1]], (len(i), 1)))
    outputs = experiment.outputs
    every = np.concatenate(frequency)
    compared = compare_points(
        [one.id for one in outputs],
        [one.quantity for one in outputs],
        every,
        np.hstack(measured),
        np.hstack(computed),
    )
    if compared is None or not compared.unexplained.any():
        return compared
    rows = [int(np.flatnonzero(every == f)[0]) for f in compared.frequency]  # modes that all points miss are out
    return _with_places(experiment, compared, np.vstack(material)[rows])


def _with_places(experiment: Experiment, compared: PointComparison, material: Real) -> PointComparison:
    """Look on a coarse model for the places of points that move like no declared one.

    Parameters
    ----------
    material : (N, 2) ndarray
        E [Pa] and nu of the sweep of every mode.
    """
    from simulation.reduction.coarse_plate import CoarseShapes  # slow import: mesher

    outputs = experiment.outputs
    wanted = [int(k) for k in np.flatnonzero(compared.unexplained) if outputs[k].footprint is not None]
    if not wanted:
        return compared
    (e_low, nu_low), (e_high, nu_high) = material.min(axis=0), material.max(axis=0)
    try:
        coarse = CoarseShapes.of(experiment, (float(e_low), float(e_high)), (float(nu_low), float(nu_high)))
    except (RuntimeError, GeometryError, np.linalg.LinAlgError):
        return compared
    kinds = np.array([one.quantity for one in outputs])
    points = np.array([one.footprint.point if one.footprint else (np.nan, np.nan) for one in outputs])
    names = tuple(one.id for one in outputs)
    found: dict[int, tuple[FittingPlace, ...]] = {}
    for kind in {outputs[k].quantity for k in wanted}:
        sound = ~compared.wrong & (kinds == kind) & np.isfinite(coarse.points).all(axis=1)
        shapes = np.full((len(coarse.places), len(compared.frequency)), np.nan)
        for e, nu in np.unique(material, axis=0):
            own = (material == (e, nu)).all(axis=1)
            modes = coarse.modes(float(e), float(nu))
            shapes[:, own] = represented(compared.frequency[own], compared.computed[:, own], sound, modes)
        known = KnownShapes(coarse.places, shapes, names, points)
        of_kind = [k for k in wanted if outputs[k].quantity == kind]
        found |= {k: places for k in of_kind if (places := fitting_places(compared.measured[k], k, known))}
    return replace(compared, fitting=found)


def with_reason(
    experiment: Experiment, frf: Frf, measured: MeasuredSweeps | None, pairing: Pairing | None, report: Progress
) -> Pairing | None:
    """Return a pairing with the likely reason where it is no fit; a pairing that fits as it is.

    Parameters
    ----------
    frf : Frf
        As fitted.
    measured : MeasuredSweeps or None
        From which the pairing was made.
    report : callable
        Called with a stage's name and the share of it done.
    """
    if pairing is None or measured is None or pairing.fits:
        return pairing
    if wrong := pairing.wrong_points:
        return replace(pairing, likely=f"likely reason: {'; '.join(wrong)}", wrong_declaration=False)
    from app.stages.comparison.declaration_check import likely_reason  # slow import: mesher

    worst = pairing.before.worst
    pairs, sweep = pairing.before.sweeps[worst], list(measured.modes)[worst]
    low, high = pairs.band
    inside = ~frf.excluded & (frf.frequency >= low - 1e-6) & (frf.frequency <= high + 1e-6)
    deviation = np.sqrt(frf.variance[sweep][:, inside])
    here = SweepModes(
        pairs.temperature,
        frf.frequency[inside],
        frf.h[sweep][:, inside],
        deviation,
        pairs.measured,
        measured.terms,
    )
    found = likely_reason(experiment, here, report)
    return replace(pairing, likely=found.sentence, wrong_declaration=found.wrong_declaration)
