"""Pairing of modes before and after the effects that a comparison found, and what is left of it at no fit."""

from dataclasses import replace

from analysis.gap.report import GapReport
from analysis.pairing.paired_sweeps import PairedSweeps, Pairing
from analysis.progress import Progress
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.updating.corrected_twin import CorrectedTwin
from analysis.updating.drift import sweep_laws
from app.stages.comparison.pairing import paired_sweeps, with_reason
from app.stages.update import Updating
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin


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
