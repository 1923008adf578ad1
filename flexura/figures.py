"""Figures of results, as on the report's page."""

from collections.abc import Callable, Mapping
from functools import partial
from inspect import signature
from typing import Any

from matplotlib.figure import Figure

from analysis.recordings.campaign import Campaign
from analysis.recordings.frf import Frf
from analysis.recordings.frf_campaign import AnyCampaign, FrfCampaign
from app.files.results.gap_file import GapFigures
from app.report import focusing, gap, health, measured, radiation, studies, style
from app.report.declared import picture, pieces_of_experiment
from app.stages.compensate import CompensatedPanel
from app.stages.focus import FocusedPanel
from app.stages.gap import GapComparison
from app.stages.health import WatchedPanel
from app.stages.identify import IdentifiedCampaign
from app.stages.radiation import RadiatingPanel
from app.stages.study import FIGURES as STUDIED
from app.stages.study import StudiedPanel
from app.stages.update import Updating
from flexura.keywords import ArgumentKindError


def plot(value: Any, kind: str | None = None, *, channel: int | None = None) -> Figure:
    """Draw a campaign, its FRFs, or the result of a stage.

    Parameters
    ----------
    value : Campaign, FrfCampaign, Frf or result of a stage
        IdentifiedCampaign, Updating, GapComparison, FocusedPanel, CompensatedPanel, WatchedPanel, RadiatingPanel
        or StudiedPanel.
    kind : str, optional
        Which of its figures, see `FIGURES`; the first where it is left out.
    channel : int, optional
        Sensor, from 0, of a figure that shows one; the first where it is left out.

    Returns
    -------
    Figure
        Without a window; ``figure.savefig("laws.png")`` writes it.

    Raises
    ------
    ArgumentKindError
        For a value that has no figures.
    ValueError
        For a kind of figure that the value does not have, and a sensor that the figure does not show.
    """
    if type(value) not in FIGURES:
        known = ", ".join(sorted(one.__name__ for one in FIGURES))
        raise ArgumentKindError(f"value: {type(value).__name__} has no figures; these have: {known}")
    kinds = FIGURES[type(value)]
    if kind is not None and kind not in kinds:
        raise ValueError(f"{type(value).__name__} has no figure {kind!r}; it has {', '.join(kinds)}")
    kind = kind or next(iter(kinds))
    options = {} if channel is None else {"channel": _checked(channel, value, kind)}
    with style.drawing():
        return kinds[kind](value, **options)


def _checked(channel: int, value: Any, kind: str) -> int:
    """Return the channel; ValueError where a figure shows no single one, or the value has fewer."""
    if "channel" not in signature(FIGURES[type(value)][kind]).parameters:
        raise ValueError(f"figure {kind!r} of {type(value).__name__} shows no single sensor: leave out channel")
    count = len(getattr(value, "frf", value).channels)
    if not 0 <= channel < count:
        raise ValueError(f"channel {channel}: 0 to {count - 1} wanted")
    return channel


def _plate(campaign: AnyCampaign) -> Figure:
    return picture(pieces_of_experiment(campaign.experiment))


def _overlay(found: IdentifiedCampaign, channel: int = 0) -> Figure:
    return measured.overlay(found.frf, found.tracked, channel)


def _twin(found: Updating, channel: int = 0) -> Figure:
    return measured.overlays(found.frf, found.twin, found.updated, channel)


def _of_gap(draw: Callable[[GapFigures], Figure]) -> Callable[[GapComparison], Figure]:
    return lambda found: draw(GapFigures.of(found.report, found.corrected.nodes))


def _studied(name: str, found: StudiedPanel) -> Figure:
    """Return a figure of the paper; ValueError for one that was not asked for."""
    made = {one.name: one.figure for one in studies.pictures(found.studies)}
    if name not in made:
        raise ValueError(f"figure {name!r} was not computed; these were: {', '.join(made)}")
    return made[name]


FIGURES: Mapping[type, Mapping[str, Callable[..., Figure]]] = {
    Campaign: {"plate": _plate},
    FrfCampaign: {"plate": _plate},
    Frf: {"waterfall": measured.waterfall, "noise": measured.noise},
    IdentifiedCampaign: {
        "modes": lambda found: measured.over_temperature(found.tracked),
        "overlay": _overlay,
    },
    Updating: {
        "laws": lambda found: measured.laws(found.updated, found.laws),
        "overlays": _twin,
        "misfit": lambda found: measured.misfit(found.updated, found.frf),
    },
    GapComparison: {
        "residual": _of_gap(gap.residual_maps),
        "shares": _of_gap(gap.shares),
        "candidates": lambda found: gap.candidates(found.record()),
        "laws": _of_gap(gap.laws),
    },
    FocusedPanel: {
        "contrast": lambda found: focusing.before(found.focusing),
        "panel": lambda found: focusing.layout(found.panel),
        "methods": lambda found: focusing.methods(found.comparison),
    },
    CompensatedPanel: {
        "contrast": lambda found: focusing.after(found.compensation),
        "errors": lambda found: focusing.relative_errors(found.compensation),
    },
    WatchedPanel: {"trend": lambda found: health.trend(found.report)},
    RadiatingPanel: {"levels": lambda found: radiation.levels(found.radiation)},
    StudiedPanel: {f"study-{figure}": partial(_studied, f"study-{figure}") for figure in STUDIED},
}
"""Figures of each kind of value, by name; the first is drawn where none is named."""
