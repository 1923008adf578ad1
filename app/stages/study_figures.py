"""The data of the paper's figures on a panel, figure by figure."""

import time
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from analysis.compensation.network import InputMap
from analysis.compensation.rivals import DirectFilters, direct_filters, rigidity
from analysis.compensation.settings import Training
from analysis.compensation.study import compensate
from analysis.compensation.training import study_networks
from analysis.focusing.over_temperature import focus
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import covered, spaced
from analysis.focusing.played import play_methods
from analysis.material import MaterialLaws
from analysis.progress import Progress
from app.files.results.panel_files import Studies, Surfaces
from app.stages.panel.inputs import workers
from app.twins.panel_twin import PanelTwin

NODES = tuple(range(6, 17))
SPACINGS = (2.0, 5.0, 8.0)
MOST_NODES = 14
"""Hidden nodes where spacings are compared, and the spacings of training temperatures, K (Fig. 19)."""
SHOWN = np.array([0.0, 20.0, 40.0, 60.0])
"""Temperatures of Fig. 13, degrees Celsius."""
OF_NETWORKS = {"14", "15", "16", "17"}
CHOICES = {
    "18": ("nodes", [(nodes, 5.0) for nodes in NODES]),
    "19": ("spacings", [(MOST_NODES, spacing) for spacing in SPACINGS]),
}
"""Studies of networks by figure: name, and hidden nodes with the spacing of training temperatures, K."""


def run_studies(
    figures: Sequence[str],
    model: PanelTwin,
    panel: Panel,
    laws: MaterialLaws,
    training: Training,
    report: Progress,
) -> Studies:
    """Compute the data of figures of the paper.

    Parameters
    ----------
    figures : sequence of str
        Their numbers: 4, 13 to 19.
    laws : MaterialLaws
        Of the panel's plate.
    report : callable
        Called with the stage's name and the share done.

    Returns
    -------
    Studies
        With None for figures not requested.

    Raises
    ------
    EvidenceCollapseError
        Where the networks of Figs. 15 to 17 are refused.
    """
    found: dict[str, Any] = {}
    low, high = covered(laws, panel.filters.operating_range)
    if "4" in figures:
        plate = panel.illustration
        found["played"] = play_methods(
            model, panel, (plate.youngs_modulus, plate.poisson_ratio, plate.loss_factor)
        )
        report("Methods", 1.0)
    if "13" in figures:
        inside = SHOWN[(low <= SHOWN) & (high >= SHOWN)]
        shown = inside if inside.size else np.array([low, high])
        found["fixed"] = focus(model, panel, laws, shown, report=report, workers=workers())
    everywhere = spaced(low, high, 0.25)
    if (OF_NETWORKS | set(CHOICES)) & set(figures):
        direct = direct_filters(model, panel, laws, everywhere, report=report, workers=workers())
    if OF_NETWORKS & set(figures):
        compensation = compensate(
            model,
            panel,
            laws,
            5.0,
            training,
            time.thread_time,
            report=report,
            workers=workers(),
            known=direct,
        )
        found["compensation"] = compensation
        here = spaced(low, high, 1.0)
        taps = compensation.trained.networks.taps(here)
        found["surfaces"] = Surfaces(here, taps, compensation.filters.sample_rate)
    if set(CHOICES) & set(figures):
        found |= _study_networks(figures, panel, laws, direct, training, report)
    return Studies(**found)


def _study_networks(
    figures: Sequence[str],
    panel: Panel,
    laws: MaterialLaws,
    direct: DirectFilters,
    training: Training,
    report: Progress,
) -> dict[str, Any]:
    """Train networks of several sizes and training temperatures, and compare each with the direct filters."""
    lines = panel.filters.frequency[panel.filters.in_band(panel.filters.frequency)]
    temperature = direct.bank.temperature
    inputs = InputMap.of(
        temperature, temperature if training.feed == "temperature" else rigidity(laws, temperature)
    )
    found: dict[str, Any] = {}
    for figure, (name, choices) in CHOICES.items():
        if figure in figures:
            progress = partial(report, f"Networks, {name}")
            found[name] = study_networks(direct.bank, direct.forms, lines, choices, training, inputs, progress)
    return found
