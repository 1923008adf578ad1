"""The twin with effects as one campaign wants it: referred to its laws, a twin file's effects known."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from analysis.effect_card import EffectCard
from analysis.estimates import Estimate
from analysis.experiment import Experiment
from analysis.gap.data.groups import LawSmoothness, TemperatureGroups, mean_laws
from analysis.gap.data.numerical_floor import allowed_error
from analysis.progress import Progress
from analysis.recordings.frf_campaign import AnyCampaign
from analysis.twin_model import Effects
from analysis.updated import Updated
from app.files.bad_file import ResultFileError
from app.files.results.twin_file import TwinFile, read_twin, require_known_effects, require_same_plate
from app.twins.campaign_twin import OFFSET, effect_twin, offset_wanted
from simulation.effects.library import library
from simulation.reduction.sufficient_fineness import RequiredError
from simulation.twin.effect_plate import EffectPlate
from simulation.twin.twin import Twin

REFERENCE_TEMPERATURE = 25.0
"""Temperature to which strain energies are referred, degrees Celsius."""
LEAST_LOSS = 1e-4
"""Smallest loss factor for which the twin's error is estimated: a fit may end below that of any real plate."""
WORKERS = 2
"""Sweeps linearised at a time."""


@dataclass(frozen=True)
class Start:
    """A twin file, checked, and where it stands."""

    path: Path
    twin: TwinFile


def campaign_model(
    experiment: Experiment,
    plain: Updated,
    report: Progress,
    start: Start | None,
    folder: Path | None,
    declared: Effects | None = None,
) -> tuple[Twin[EffectPlate], dict[str, tuple[Estimate, ...]]]:
    """Return a campaign's twin with its library, and the effects of the twin file it starts from.

    Parameters
    ----------
    plain : Updated
        Strain energies are referred to its laws.
    report : callable
        Called with a stage's name and the share of it done.
    folder : Path or None
        A user's own effects.
    declared : mapping, optional
        Values of declared quantities about which the twin is made; those of `plain` by default.

    Returns
    -------
    twin : Twin
    given : dict of str to tuple of Estimate
        Parameters of the effects that are on.

    Raises
    ------
    ResultFileError
        For an effect that does not fit onto the plate.
    """
    declared = plain.departures if declared is None else declared
    offset = offset_wanted(experiment, declared) or (start is not None and OFFSET in start.twin.effects)
    twin = effect_twin(experiment, report, folder, required_error(plain), declared, offset=offset)
    given: dict[str, tuple[Estimate, ...]] = {}
    if start is not None:
        given = {
            effect.name: tuple(Estimate(name, p.value, p.sigma, p.unit) for name, p in effect.parameter.items())
            for effect in start.twin.effect
        }
        missing = [name for name in given if name not in twin.library]
        if missing:
            raise ResultFileError(
                f"{start.path}: {', '.join(missing)} cannot act on this plate: sensor_offset needs room in its "
                "mesh, and orthotropy a sheet whose own moduli are not free (tolerances.moduli = 0)"
            )
    return referred(twin, plain), given


def required_error(plain: Updated) -> RequiredError:
    """Error of a twin with which a campaign can be compared, at the least damping found by model updating."""
    loss_factor = max(float(plain.sharpest.loss_factor.min()), LEAST_LOSS)
    return RequiredError(allowed_error(float(np.median(plain.noise_floor))), loss_factor)


def referred(twin: Twin[EffectPlate], plain: Updated) -> Twin[EffectPlate]:
    """Return a twin whose strain energies are referred to a campaign's laws nearest `REFERENCE_TEMPERATURE`."""
    groups = TemperatureGroups.of(plain.temperature)
    values = mean_laws(plain.material, groups)
    laws = LawSmoothness.of(groups.reference, values).laws(values)
    return twin.referred(min(laws, key=lambda law: abs(law.reference - REFERENCE_TEMPERATURE)))


def start_of(path: Path | None, experiment: Experiment, folder: Path | None) -> Start | None:
    """Read the twin file to start from, if one is named, and check it before anything is computed.

    Parameters
    ----------
    folder : Path or None
        A user's own effects.

    Raises
    ------
    CampaignFileError
        For a file that is no twin, a twin of another plate, and effects that the library does not know or allow.
    ResultFileError
        For a user's effects in `folder` that cannot be loaded.
    """
    cards = known_effects(experiment, folder)
    if path is None:
        return None
    twin = read_twin(path)
    require_same_plate(path, twin, experiment)
    require_known_effects(path, twin, cards)
    return Start(path, twin)


def known_effects(experiment: Experiment, folder: Path | None) -> dict[str, EffectCard]:
    """Cards of the library and of a user's own effects; ResultFileError where these cannot be loaded."""
    if folder is None:
        return {name: effect.card(experiment) for name, effect in library(experiment).items()}
    try:
        return {name: effect.card(experiment) for name, effect in library(experiment, folder).items()}
    except ValueError as error:
        raise ResultFileError(f"--effects: {error}") from error


@contextmanager
def judging(campaign: AnyCampaign) -> Iterator[None]:
    """Turn what the analysis refuses into a ResultFileError that names the campaign.

    A matrix that cannot be inverted is no refusal but a defect, and keeps its traceback.
    """
    try:
        yield
    except (np.linalg.LinAlgError, ResultFileError):
        raise
    except ValueError as error:
        raise ResultFileError(f"{campaign.name}: cannot be judged: {error}") from error
