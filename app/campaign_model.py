"""The twin with effects as one campaign wants it: small, referred to its laws, a twin file's effects known."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from analysis.campaign import Campaign
from analysis.experiment import Experiment
from analysis.gap.groups import TemperatureGroups, mean_laws
from analysis.gap.report import Estimate
from analysis.local_laws import LocalLaws
from analysis.updating.update import Updated
from app.effect_twin import effect_twin
from app.files.bad_file import ResultFileError
from app.files.twin_file import TwinFile, read_twin, require_known_effects, require_same_plate
from app.progress import Report
from simulation.campaign_basis import for_materials
from simulation.effect_twin import EffectTwin

MATERIALS = 5
"""Temperatures whose materials the smaller model is made for."""
MARGIN = 0.05
"""Of E, by which the range of these materials is widened: effects move the laws by a few per cent."""
REFERENCE = 25.0
"""Temperature to which strain energies are referred, degrees Celsius."""
WORKERS = 2
"""Sweeps linearised at a time."""


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
    laws = groups.laws(mean_laws(plain.material, groups))
    chosen = [laws[int(i)] for i in np.unique(np.linspace(0, len(laws) - 1, MATERIALS).round())]
    materials = [_stiffer(laws[0], 1.0 + MARGIN), *chosen, _stiffer(laws[-1], 1.0 - MARGIN)]
    smaller = replace(twin, operators=for_materials(twin.operators, materials))
    return smaller.referred(min(laws, key=lambda law: abs(law.reference - REFERENCE)))


def _stiffer(laws: LocalLaws, by: float) -> LocalLaws:
    return replace(laws, value=laws.value + np.array([np.log(by), 0.0, 0.0]))


def start_of(path: Path | None) -> tuple[Path, TwinFile] | None:
    """Read the twin to start from, if one is named."""
    return None if path is None else (path, read_twin(path))


def unjudged(campaign: Campaign, error: ValueError) -> ResultFileError:
    """Say that a campaign cannot be judged, and why."""
    return ResultFileError(f"{campaign.name}: cannot be judged: {error}")
