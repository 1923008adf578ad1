"""Gap stage: comparison of a campaign with its twin, modes paired and what is left without a name; saved."""

from collections.abc import Collection, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from analysis.estimates import Estimate
from analysis.forked import ForkedExecutor
from analysis.gap.data.noise import NumericalFloor
from analysis.gap.description.describing import Description, Vocabulary, describe
from analysis.gap.gap import find_gap
from analysis.gap.plan.decision import Decision, Plan
from analysis.gap.plan.measurement import KINDS
from analysis.gap.report import GapReport
from analysis.labelled import Labelled, LabelledArrays
from analysis.pairing.assignment import PairedSweeps, Pairing
from analysis.progress import Progress
from analysis.recordings.frf import Frf
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import Effects, HeldEffects
from analysis.updating.corrected_twin import CorrectedTwin, FittedTwin, corrected_twin, fit_twin
from analysis.updating.drift import sweep_laws, to_first_order
from app.files.atomic import write_json
from app.files.bad_file import ResultFileError, UnsuitedOptionError
from app.files.campaigns.inputs import campaign_settings, has_other_sweeps, origin_of_result
from app.files.declarations.experiment import experiment_model
from app.files.provenance import provenance, sha256
from app.files.results.described_effect import write_described_effect
from app.files.results.gap_file import GapFigures, save_gap
from app.files.results.gap_json import answer_record, description_record, gap_record, plan_record
from app.files.results.laws_file import TwinFrf, save_laws
from app.files.results.modes_file import save_frf
from app.files.results.next_experiment import NAME as NEXT
from app.files.results.next_experiment import reach_of, write_next_experiment
from app.files.results.pairing_json import pairing_record
from app.files.results.twin_file import write_twin
from app.stages.comparison.compared import Compared, issued_twin
from app.stages.comparison.pairing import paired_sweeps, with_reason
from app.stages.comparison.plan import next_experiment, open_before, with_answer
from app.stages.comparison.temperature_notes import untimed
from app.stages.update import UpdateRequest, Updating, updated_twin
from app.summaries.gap import headline, tables
from app.summaries.table import as_html, as_text
from app.twins.campaign_twin import OFFSET, campaign_model, judging, offset_wanted
from simulation.effects import free_curves
from simulation.effects.library import untried
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

GAP, FIGURES, TWIN, LAWS = "gap.json", "gap.h5", "twin.toml", "laws-corrected.h5"
OPEN = ("partly_explained", "unknown")
"""Verdicts that leave something to be described."""
GOOD = ("none", "explained")
"""Verdicts that leave nothing open."""
ROUGH_TWIN_ERROR = 2e-3
"""Certified error of the twin with effects above which a note says so; usual twins stay below."""
LEAST_LOSS = 1e-4
"""Smallest loss factor for the error estimate of the twin: a fit may end below that of any real plate."""


MOST_HOURS = 1e4
"""Of a measurement: more than a year is a slip of the keyboard."""


@dataclass(frozen=True)
class GapRequest(UpdateRequest):
    """Comparison of a campaign with its twin, and what follows from it.

    Attributes
    ----------
    without : collection of str
        Effects of the library that are no candidates.
    describing : bool
        Whether what no effect explains is described, which takes a minute.
    plan : bool
        Whether the next experiment is planned.
    hours : mapping of str to float
        Laboratory hours of kinds of measurement, in place of the usual ones.
    rig : mapping or None
        Table of the experiment's file, which says what the rig can do; that of a planned campaign is made from it.
    after : (AnyCampaign, Path) or None
        An earlier campaign and its run folder, whose plan this campaign follows.
    """

    without: frozenset[str] = frozenset()
    describing: bool = True
    plan: bool = False
    hours: Mapping[str, float] = field(default_factory=dict)
    rig: Mapping[str, Any] | None = None
    after: tuple[AnyCampaign, Path] | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.plan and (self.hours or self.rig):
            raise UnsuitedOptionError("--experiment and --hours belong to --plan")
        for kind, hours in self.hours.items():
            if kind not in KINDS or not 0.0 < hours <= MOST_HOURS:
                allowed = f"KIND=HOURS, above 0 and at most {MOST_HOURS:g}, KIND one of {', '.join(KINDS)}"
                raise UnsuitedOptionError(f"--hours '{kind}={hours:g}'; allowed: {allowed}")
        if self.after is not None:
            open_before(self.after[1])  # raises where nothing was open

    @property
    def further(self) -> bool:
        """Whether further stages take the comparison up."""
        return self.plan or self.after is not None

    def origin(self) -> dict[str, Any]:
        """Return the provenance of results: campaign, twin file, a user's effects."""
        inputs = dict(self.campaign.hashes)
        if self.twin is not None:
            inputs[f"twin {self.twin.name}"] = sha256(self.twin)
        if self.effects is not None:
            inputs |= {f"effect {file.name}": sha256(file) for file in sorted(self.effects.glob("[!_]*.py"))}
        return provenance(inputs, {"mains": self.mains, **campaign_settings(self.campaign)})


@dataclass(frozen=True)
class GapComparison(Labelled):
    """Result of the gap stage.

    Attributes
    ----------
    frf : Frf
    plain : Updating
        Model updating without effects.
    twin : Twin
        With effects, reduced to the materials of this campaign.
    given : mapping of str to tuple of Estimate
        Effects of the twin file from which the comparison started.
    report : GapReport
    corrected : CorrectedTwin
        With the effects claimed; with verdict unknown the effects found are hints and are left out.
    pairing : Pairing or None
        Of measured modes with the twin's, before and after; None where either is not known.
    compared : Compared or None
        What further stages take: sweeps, twin and fit with all that was found. None where this is no fit, and
        where it was not wanted.
    plan : Plan or None
        Of the next experiment; None unless it was asked for.
    description : Description or None
        Of what no effect explains; None where nothing is left.
    answer : Decision or None
        To what an earlier comparison left open; None unless one was named.
    """

    frf: Frf
    plain: Updating
    twin: Twin[EffectPlate]
    given: Mapping[str, tuple[Estimate, ...]]
    report: GapReport
    corrected: CorrectedTwin
    pairing: Pairing | None = None
    compared: Compared | None = None
    plan: Plan | None = None
    description: Description | None = None
    answer: Decision | None = None

    def record(self) -> dict[str, Any]:
        """Return what gap.json holds, without provenance and time."""
        more = {
            "plan": None if self.plan is None else plan_record(self.plan),
            "description": None if self.description is None else description_record(self.description),
            "answer": None if self.answer is None else answer_record(self.answer),
        }
        return gap_record(self.report, self.given, {}, 0.0, self.pairing, more)

    def labelled(self) -> LabelledArrays:
        """Estimates with the effects claimed over sweep, see `Updated.labelled`."""
        return self.corrected.updated.labelled()

    def __repr__(self) -> str:
        """Verdict, effects and chi2 in one line, and the notes."""
        return as_text(f"GapComparison: {headline(self.record())}", (*self.frf.notes, *self.report.notes))

    def _repr_html_(self) -> str:
        record = self.record()
        return as_html(headline(record), tables(record), (*self.frf.notes, *self.report.notes))


def compute(
    request: GapRequest, report: Progress, *, run: Path | None = None, plain: Updating | None = None
) -> GapComparison:
    """Compare a campaign with its twin; then the answer and the plan, where they are asked for.

    Parameters
    ----------
    report : callable
        Called with a stage's name and the share of it done.
    run : Path, optional
        Run folder whose modes.h5 gives the measured modes to pair, if it is of these recordings.
    plain : Updating, optional
        What `updated_twin` gives for the same campaign, mains and run, where that is known.

    Raises
    ------
    ResultFileError
        For a campaign that cannot be compared with its twin, with the reason.
    """
    plain = plain or updated_twin(request.campaign, request.mains, report, run)
    found = _compared(request, plain, report)
    if request.after is not None:
        found = _with_answer(found, *request.after, request.mains, report)
    return _with_plan(found, request, report) if request.plan else found


def _compared(request: GapRequest, plain: Updating, report: Progress) -> GapComparison:
    """Find what the twin lacks, and describe what no effect explains."""
    campaign, start, folder = request.campaign, request.start, request.effects
    frf = plain.frf
    twin, given = campaign_model(campaign.experiment, plain.updated, report, start, folder)
    candidates = allowed = frozenset({*twin.library, OFFSET} - request.without)
    twin = _with_only(twin, allowed)
    model = HeldEffects(twin, {name: {p.name: p.value for p in values} for name, values in given.items()})
    protocol = campaign.experiment.protocol
    report("numerical floor", 0.0)
    with ForkedExecutor() as executor, judging(campaign):
        floor = _floor(plain, twin, patches=bool(campaign.experiment.patch))
        steady = to_first_order(frf, model, plain.local_laws, plain.updated.gains, protocol, executor)
        start_twin = None
        if given:
            begun = fit_twin(steady, plain.updated, model, protocol, executor, given, floor=floor)
            start_twin = corrected_twin(frf, plain.updated, model, protocol, begun, executor)
        pairing = pairing_before(campaign, plain, twin, start_twin, report)
        if pairing is not None and pairing.wrong_declaration:
            candidates = frozenset(given)
            model = replace(model, twin=_with_only(twin, candidates))

        def remade(declared: Effects) -> Twin[EffectPlate] | None:
            nonlocal twin, model
            if OFFSET not in candidates - twin.library.keys() or not offset_wanted(campaign.experiment, declared):
                return None
            again, _ = campaign_model(campaign.experiment, plain.updated, report, start, folder, declared)
            if OFFSET not in again.library:  # no room for it in this mesh
                return None
            twin = _with_only(again, allowed)
            found_with = _with_only(twin, candidates)
            model = replace(model, twin=found_with)
            return found_with

        found = find_gap(
            steady, plain.updated, model, protocol, executor, floor=floor, remade=remade, progress=report
        )
        not_tried = untried(campaign.experiment, folder)
        notes = (
            *untimed(protocol),
            *missing_words(not_tried),
            *roughness(twin.error),
        )
        found = replace(found, notes=(*found.notes, *notes))
        claimed = {e.name: e.parameters for e in found.effects}
        parts = found.state, found.laws_after, found.sigma_gain
        named = FittedTwin(*parts, {**given, **claimed}, found.declared)
        last = corrected_twin(frf, plain.updated, model, protocol, named, executor)
        found, pairing = paired_report(campaign, plain, twin, found, pairing, last)
        if pairing is not None and pairing.fits:
            found = replace(found, notes=(*pairing.wrong_points, *found.notes))
        bare = found.plain
        unnamed = FittedTwin(bare.state, bare.laws, bare.sigma_gain, given, bare.declared)
        fitted = unnamed if found.verdict == "unknown" else named
        compared = told = None
        describing = request.describing and found.verdict in OPEN
        if (describing or request.further) and (pairing is None or pairing.fits):
            around = HeldEffects.around(model)
            compared = Compared.again(
                campaign.experiment, steady, plain.updated, twin, around, found, executor, floor.carried
            )
            if describing:
                told, why = description(compared, found, executor, report)
                found = replace(found, notes=(*found.notes, *why))
        if fitted is not named:
            last = corrected_twin(frf, plain.updated, model, protocol, fitted, executor)
    return GapComparison(frf, plain, twin, given, found, last, pairing, compared, description=told)


def _with_only(twin: Twin[EffectPlate], candidates: Collection[str]) -> Twin[EffectPlate]:
    return replace(twin, library={name: one for name, one in twin.library.items() if name in candidates})


def _with_plan(found: GapComparison, request: GapRequest, report: Progress) -> GapComparison:
    """Add the plan of the next experiment; an empty one where this is no fit, which cannot simulate anything."""
    if found.compared is None:
        return replace(found, plan=Plan((), ()))
    rig = request.rig
    reach = None if rig is None else reach_of(experiment_model(rig).model_validate(rig))
    return replace(found, plan=next_experiment(found.compared, found.report, report, request.hours, reach))


def _with_answer(
    found: GapComparison, earlier: AnyCampaign, run: Path, mains: float, report: Progress
) -> GapComparison:
    """Decide what an earlier comparison left open, by its campaign and this one, unless this is no fit."""
    if found.compared is None:
        return found
    return replace(found, answer=with_answer(earlier, run, found.compared, mains, report))


def save(run: Path, request: GapRequest, found: GapComparison, seconds: float) -> dict[str, Any]:
    """Write gap.json, gap.h5, frf.h5, twin.toml and laws, and return the content of gap.json.

    ``laws.h5`` is the result of `flexura update`: it is written only if it is not there, or of other sweeps of
    this campaign, which has got more since. Laws under effects go to ``laws-corrected.h5``; without effects that
    file is removed, because an earlier run may have left it.

    Parameters
    ----------
    run : Path
        Run folder.
    seconds : float
        Time that the comparison took, s.

    Returns
    -------
    dict
        Content of gap.json.

    Raises
    ------
    OSError
        Where the run folder cannot be written.
    """
    campaign, origin = request.campaign, request.origin()
    planned = () if found.plan is None else _next_experiment(run, found.plan, request.rig)
    more = {
        "plan": None if found.plan is None else plan_record(found.plan, *planned),
        "description": None if found.description is None else _described(run, found.description),
        "answer": None if found.answer is None else answer_record(found.answer),
    }
    record = gap_record(found.report, found.given, origin, seconds, found.pairing, more)
    save_frf(run / "frf.h5", campaign.experiment, found.frf, origin)
    figures = GapFigures.of(found.report, found.corrected.nodes)
    save_gap(run / FIGURES, figures, found.report.signatures, record, origin)
    if _wants_laws(run / "laws.h5", campaign):
        plain = found.plain
        record_of_plain = pairing_record(plain.pairing)
        save_laws(run / "laws.h5", plain.updated, plain.laws, plain.twin, origin, record_of_plain)
    based_on = None if request.twin is None else sha256(request.twin)
    issued = issued_twin(campaign, found.corrected, found.twin.error, found.report.verdict, based_on)
    write_twin(run / TWIN, issued)
    if found.corrected.effects:
        _save_corrected_laws(run / LAWS, campaign, found.corrected, found.twin.error, origin)
    write_json(run / GAP, record)
    if not found.corrected.effects:  # those of an older comparison, which stands where the disk refused this one
        (run / LAWS).unlink(missing_ok=True)
    return record


def _described(run: Path, found: Description) -> dict[str, Any]:
    """Write the effect's file of a description, and return its record."""
    written = write_described_effect(run, found)
    return description_record(found, written.relative_to(run).as_posix())


def _next_experiment(run: Path, plan: Plan, rig: Mapping[str, Any] | None) -> tuple[str, str]:
    """Write the experiment of a planned campaign; return its name, and what is to be filled in there."""
    target, chosen = run / NEXT, plan.winner
    if chosen is None or chosen.measurement.experiment is None or rig is None:
        target.unlink(missing_ok=True)
    if chosen is None or chosen.measurement.experiment is None:
        return "", ""
    if rig is None:
        return "", "A file for flexura acquire is written if that of this campaign is named: --experiment FILE."
    return NEXT, write_next_experiment(target, rig, chosen.measurement)


def _wants_laws(path: Path, campaign: AnyCampaign) -> bool:
    """Whether there are no laws, or those of the plain twin for other sweeps of this campaign."""
    if not path.is_file():
        return True
    try:
        origin = origin_of_result(path, "update")
    except ResultFileError:  # unreadable: `flexura update` says so, and makes it again
        return False
    return not origin.settings.get("effects") and has_other_sweeps(origin.inputs, campaign.hashes)


def _save_corrected_laws(
    target: Path, campaign: AnyCampaign, corrected: CorrectedTwin, error: float, origin: dict[str, Any]
) -> None:
    """Write laws and FRFs of a twin with effects, in the form of laws.h5."""
    on = {name: {p.name: p.value for p in values} for name, values in corrected.effects.items()}
    made_from = {**origin, "settings": {**origin["settings"], "effects": on}}
    answers = TwinFrf(corrected.frequency, corrected.answers, error, campaign.experiment.plate.density)
    save_laws(target, corrected.updated, corrected.laws, answers, made_from)


def _floor(plain: Updating, twin: Twin[EffectPlate], *, patches: bool) -> NumericalFloor:
    """Return the error of the twin at the least damping found in the campaign."""
    least = max(float(plain.updated.sharpest.loss_factor.min()), LEAST_LOSS)
    error = twin.plate.operators.numerical_error(least)
    return NumericalFloor(error, float(np.median(plain.frf.noise_floor)), patches)


def missing_words(not_tried: Mapping[str, str]) -> tuple[str, ...]:
    """Return a note for each effect that could not be tried, with what to declare for it."""
    return tuple(f"{name} was not tried: for it, declare {wanted}" for name, wanted in not_tried.items())


def roughness(error: float) -> tuple[str, ...]:
    """Return a note where the certified `error` of the twin, a share of its peak, is larger than usual."""
    if error <= ROUGH_TWIN_ERROR:
        return ()
    return (
        f"the twin with several effects at half of their ranges has an error of {100 * error:.2g} % of its peak "
        f"(usual: below {100 * ROUGH_TWIN_ERROR:.2g} %): large parameters are no more certain than that. Check "
        "whether patches nearly touch an edge or each other",
    )


def description(
    compared: Compared, found: GapReport, executor: Executor, report: Progress
) -> tuple[Description | None, tuple[str, ...]]:
    """Describe what a comparison left unexplained.

    Parameters
    ----------
    executor : Executor
        Sweeps are linearised on it.
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    description : Description or None
        None where nothing is left, or where it cannot be described.
    notes : tuple of str
        Why not.
    """
    twin = compared.twin
    if found.verdict not in OPEN:  # nothing is left
        return None, ()
    free = free_curves.free_effects(compared.experiment)
    wider = replace(compared.model, twin=replace(twin, library={**twin.library, **free}))
    exact = replace(wider, released=frozenset(twin.tolerance_cards))
    claimed = {} if found.verdict == "unknown" else dict(compared.fit.state.effects)
    start = compared.fit.state.with_effects(claimed)
    band = compared.experiment.protocol.band
    smooth = free_curves.knots(band, free_curves.SMOOTH_KNOTS)
    words = Vocabulary(
        loads={name.removeprefix("load_"): name for name in free_curves.FORMS},
        load=free_curves.LOAD,
        modulus=free_curves.MODULUS,
        gain=free_curves.GAIN,
        knots={
            free_curves.LOAD: free_curves.knots(band, free_curves.KNOTS),
            free_curves.MODULUS: smooth,
            free_curves.GAIN: smooth,
        },
    )
    try:
        return describe(wider, exact, compared.sweeps, start, words, executor, report), ()
    except np.linalg.LinAlgError:  # a ValueError, and a defect
        raise
    except ValueError as error:
        return None, (f"what is missing could not be described: {error}",)


def pairing_before(
    campaign: AnyCampaign,
    plain: Updating,
    twin: Twin[EffectPlate],
    begun: CorrectedTwin | None,
    report: Progress,
) -> Pairing | None:
    """Pair the modes before the search for effects, with the likely reason where the twin is no fit.

    Parameters
    ----------
    plain : Updating
        Without effects.
    begun : CorrectedTwin or None
        With the effects of a twin file; None where there is none.
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    Pairing or None
        None where modes are not known.
    """
    pairing = plain.pairing
    if begun is not None:
        pairing = Pairing.of(_paired(campaign, plain, twin, begun))
    return with_reason(campaign.experiment, plain.frf, plain.measured, pairing, report)


def paired_report(
    campaign: AnyCampaign,
    plain: Updating,
    twin: Twin[EffectPlate],
    found: GapReport,
    pairing: Pairing | None,
    named: CorrectedTwin,
) -> tuple[GapReport, Pairing | None]:
    """Pair modes with the effects found; where the twin is no fit with or without, take them out of the report.

    A large effect that is named rightly makes modes pair that did not before.

    Parameters
    ----------
    plain : Updating
        Without effects.
    pairing : Pairing or None
        Of `pairing_before`.
    named : CorrectedTwin
        With the effects found, hints or not.

    Returns
    -------
    found : GapReport
    pairing : Pairing or None
    """
    if pairing is not None and found.effects:
        pairing = replace(pairing, after=_paired(campaign, plain, twin, named))
    if pairing is None or pairing.fits:
        return found, pairing
    pairing = replace(pairing, after=None)
    return no_fit(found, pairing), pairing


def no_fit(found: GapReport, pairing: Pairing) -> GapReport:
    """Return a report without effects, hints, candidates and observability: all rest on derivatives at no fit."""
    return replace(
        found,
        verdict="unknown",
        effects=(),
        not_observable=(),
        seen=(),
        final=found.baseline,
        held_out=(),
        unexplained=1.0,
        after=found.before,
        laws_after=found.laws_before,
        candidates=(),
        signatures=(),
        steps=(),
        notes=(pairing.said, *filter(None, [pairing.likely]), *found.noise.notes),
    )


def _paired(
    campaign: AnyCampaign, plain: Updating, twin: Twin[EffectPlate], corrected: CorrectedTwin
) -> PairedSweeps | None:
    """Pair the modes with those of a twin with effects; None where either is not known."""
    updated = corrected.updated
    laws = sweep_laws(updated.temperature, updated.material, corrected.laws)
    effects = {name: {p.name: p.value for p in values} for name, values in corrected.effects.items()}
    effects |= updated.departures
    return paired_sweeps(
        campaign.experiment, plain.frf, updated, plain.measured, twin, laws, corrected.answers, effects
    )
