"""A campaign compared with its twin: from FRFs to what the twin lacks, and the twin that has it."""

from collections.abc import Collection, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from analysis.campaign import Campaign
from analysis.effect_card import EffectCard
from analysis.estimates import Estimate
from analysis.frf import Frf
from analysis.gap.data.numerical_floor import NumericalFloor
from analysis.gap.gap import find_gap
from analysis.gap.report import GapReport
from analysis.held_effects import HeldEffects
from analysis.progress import Progress
from analysis.protocol.advice import smeared
from analysis.updating.corrected_twin import CorrectedTwin, FittedTwin, corrected_twin, fit_twin
from app.stages.update import Updating, updated_twin
from app.twins.campaign_model import WORKERS, Start, campaign_model, judging
from simulation.effects.library import untried
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

LEAST_LOSS = 1e-4
"""Loss factor below which no plate is taken to lie: a fit may end there."""
ROUGH = 2e-3
"""Certified error of the plate with effects from which it is said: plates reduced as they should be stay below."""


@dataclass(frozen=True)
class GapComparison:
    """A campaign's gap and all that led to it.

    Attributes
    ----------
    frf : Frf
    plain : Updating
        Without effects.
    twin : Twin
        Made for this campaign.
    given : mapping of str to tuple of Estimate
        These.
    report : GapReport
    corrected : CorrectedTwin
        With the effects claimed; those of an unknown gap are hints and left out.
    """

    frf: Frf
    plain: Updating
    twin: Twin[EffectPlate]
    given: Mapping[str, tuple[Estimate, ...]]
    report: GapReport
    corrected: CorrectedTwin


def campaign_gap(
    campaign: Campaign,
    mains: float,
    report: Progress,
    *,
    start: Start | None = None,
    folder: Path | None = None,
    without: Collection[str] = (),
) -> GapComparison:
    """Compare a campaign with its twin.

    Parameters
    ----------
    campaign : Campaign
    mains : float
        Hz.
    report : callable
    start : Start, optional
        The twin whose effects are on from the beginning.
    folder : Path, optional
        A user's own effects.
    without : collection of str
        Effects of the library that are no candidates.

    Raises
    ------
    ResultFileError
        For a campaign that cannot be judged, with the reason.
    """
    plain = updated_twin(campaign, mains, report)
    frf = plain.frf
    twin, given = campaign_model(campaign.experiment, plain.updated, report, start, folder)
    twin = replace(twin, library={name: effect for name, effect in twin.library.items() if name not in without})
    model = HeldEffects(twin, {name: {p.name: p.value for p in values} for name, values in given.items()})
    protocol = campaign.experiment.protocol
    report("numerical floor", 0.0)
    with ThreadPoolExecutor(WORKERS) as executor, judging(campaign):
        floor = _floor(plain, twin)
        found = find_gap(frf, plain.updated, model, protocol, executor, floor=floor, progress=report)
        not_tried = untried(campaign.experiment, folder)
        told = (
            *smeared(protocol.sweep_duration, protocol.ramp_rate),
            *missing_words(not_tried),
            *roughness(twin.error),
        )
        found = replace(found, notes=(*found.notes, *told))
        claimed = {e.name: e.parameters for e in found.effects}
        if found.verdict == "unknown":
            fitted = fit_twin(frf, plain.updated, model, protocol, executor, given)
        else:
            fitted = FittedTwin(found.state, found.laws_after, found.sigma_gain, {**given, **claimed})
    return GapComparison(
        frf, plain, twin, given, found, corrected_twin(frf, plain.updated, model, protocol, fitted)
    )


def missing_words(not_tried: Mapping[str, EffectCard]) -> tuple[str, ...]:
    """Say which effects could not be tried, for lack of what they stand on."""
    return tuple(
        f"{name} was not tried: the campaign's declaration does not say enough for it; it needs {card.needs}"
        for name, card in not_tried.items()
    )


def roughness(error: float) -> tuple[str, ...]:
    """Say it where the reduced plate with effects is less exact than usual: `error` is its certified one."""
    if error <= ROUGH:
        return ()
    return (
        f"this plate with several effects at half of their ranges is computed to {100 * error:.2g} % of its peak "
        f"only (usual: below {100 * ROUGH:.2g} %): take large parameters for no surer than that, and look whether "
        "patches nearly touch an edge or each other",
    )


def _floor(plain: Updating, twin: Twin[EffectPlate]) -> NumericalFloor:
    """Return what is known of the twin's own error, at the least damping that the campaign met."""
    least = max(float(plain.updated.material.loss_factor.min()), LEAST_LOSS)
    return NumericalFloor(twin.plate.operators.numerical_error(least), float(np.median(plain.frf.noise_floor)))
