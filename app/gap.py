"""A campaign compared with its twin: from FRFs to what the twin lacks, and the twin that has it."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from analysis.campaign import Campaign
from analysis.experiment import Experiment
from analysis.frf import Frf, campaign_frf
from analysis.gap.gap import find_gap
from analysis.gap.groups import TemperatureGroups, mean_laws
from analysis.gap.report import Estimate, GapReport
from analysis.local_laws import LocalLaws
from analysis.updating.update import Updated, update
from app.corrected_twin import CorrectedTwin, FittedTwin, corrected_twin, fit_twin
from app.effect_twin import effect_twin
from app.files.bad_file import ResultFileError
from app.files.twin_file import TwinFile, read_twin, require_known_effects, require_same_plate
from app.held_effects import HeldEffects
from app.progress import Report
from app.twin import campaign_twin
from simulation.campaign_basis import for_campaign
from simulation.effect_twin import EffectTwin

MATERIALS = 5
"""Temperatures whose materials the smaller model is made for."""
MARGIN = 0.05
"""Of E, by which the range of these materials is widened: effects move the laws by a few per cent."""
REFERENCE = 25.0
"""Temperature to which strain energies are referred, degrees Celsius."""
WORKERS = 2


@dataclass(frozen=True)
class Comparison:
    """A campaign's gap and all that led to it.

    Attributes
    ----------
    frf : Frf
    plain : Updated
        Model updating without effects.
    twin : EffectTwin
        Made for this campaign.
    given : mapping of str to tuple of Estimate
        These.
    report : GapReport
    corrected : CorrectedTwin
        With the effects claimed; those of an unknown gap are hints and left out.
    """

    frf: Frf
    plain: Updated
    twin: EffectTwin
    given: Mapping[str, tuple[Estimate, ...]]
    report: GapReport
    corrected: CorrectedTwin


def campaign_gap(
    campaign: Campaign,
    mains: float,
    report: Report,
    *,
    start: tuple[Path, TwinFile] | None = None,
    folder: Path | None = None,
) -> Comparison:
    """Compare a campaign with its twin.

    Parameters
    ----------
    campaign : Campaign
    mains : float
        Hz.
    report : callable
    start : (Path, TwinFile), optional
        Where the twin stands whose effects are on from the beginning, and what it says.
    folder : Path, optional
        A user's own effects.

    Raises
    ------
    ResultFileError
        For a campaign that cannot be judged, with the reason, or effects that cannot be loaded.
    CampaignFileError
        For a twin of another plate, or with effects that the library does not know.
    """
    try:
        frf = campaign_frf(campaign, mains=mains)
        plain = update(frf, campaign_twin(campaign.experiment, report), progress=report)
    except np.linalg.LinAlgError:
        raise
    except ValueError as error:
        raise unjudged(campaign, error) from error
    twin, given = campaign_model(campaign.experiment, plain, report, start, folder)
    model = HeldEffects(twin, {name: {p.name: p.value for p in values} for name, values in given.items()})
    protocol = campaign.experiment.protocol
    with ThreadPoolExecutor(WORKERS) as executor:
        try:
            found = find_gap(frf, plain, model, protocol, executor, progress=report)
            claimed = {e.name: e.parameters for e in found.effects}
            if found.verdict == "unknown":
                fitted = fit_twin(frf, plain, model, protocol, executor, given)
            else:
                fitted = FittedTwin(found.state, found.laws_after, found.sigma_gain, {**given, **claimed})
        except np.linalg.LinAlgError:
            raise
        except ValueError as error:
            raise unjudged(campaign, error) from error
    return Comparison(frf, plain, twin, given, found, corrected_twin(frf, plain, model, protocol, fitted))


def campaign_model(
    experiment: Experiment,
    plain: Updated,
    report: Report,
    start: tuple[Path, TwinFile] | None,
    folder: Path | None,
) -> tuple[EffectTwin, dict[str, tuple[Estimate, ...]]]:
    """Return the campaign's twin with its library, and the effects of a twin file."""
    if start is not None:
        require_same_plate(start[0], start[1], experiment)
    twin = loaded_twin(experiment, report, folder)
    given: dict[str, tuple[Estimate, ...]] = {}
    if start is not None:
        require_known_effects(start[0], start[1], twin.cards)
        given = {
            effect.name: tuple(Estimate(name, p.value, p.sigma, p.unit) for name, p in effect.parameter.items())
            for effect in start[1].effect
        }
    return made_for(twin, plain), given


def loaded_twin(experiment: Experiment, report: Report, folder: Path | None) -> EffectTwin:
    """Twin with the library and a user's own effects; ResultFileError where these cannot be loaded."""
    if folder is None:
        return effect_twin(experiment, report)
    try:
        return effect_twin(experiment, report, folder)
    except ValueError as error:
        raise ResultFileError(f"--effects: {error}") from error


def made_for(twin: EffectTwin, plain: Updated) -> EffectTwin:
    """Return a twin on the few directions that the materials of a campaign need, strain energies referred."""
    groups = TemperatureGroups.of(plain.temperature)
    values = mean_laws(plain.material, groups)
    laws = groups.laws(values, np.zeros_like(values))
    chosen = [laws[int(i)] for i in np.unique(np.linspace(0, len(laws) - 1, MATERIALS).round())]
    materials = [_stiffer(laws[0], 1.0 + MARGIN), *chosen, _stiffer(laws[-1], 1.0 - MARGIN)]
    smaller = replace(twin, operators=for_campaign(twin.operators, materials))
    return smaller.referred(min(laws, key=lambda law: abs(law.reference - REFERENCE)))


def _stiffer(laws: LocalLaws, by: float) -> LocalLaws:
    return replace(laws, value=laws.value + np.array([np.log(by), 0.0, 0.0]))


def start_of(path: Path | None) -> tuple[Path, TwinFile] | None:
    """Read the twin to start from, if one is named."""
    return None if path is None else (path, read_twin(path))


def unjudged(campaign: Campaign, error: ValueError) -> ResultFileError:
    """Say that a campaign cannot be judged, and why."""
    return ResultFileError(f"{campaign.name}: cannot be judged: {error}")


def names(report: GapReport) -> Sequence[str]:
    """Effects that the verdict claims."""
    return [] if report.verdict == "unknown" else [e.name for e in report.effects]
