"""Error of networks over the number of nodes and the spacing of training temperatures (paper 5.5)."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.compensation.evidence_collapse import EvidenceCollapseError
from analysis.compensation.network import InputMap, NetworkBank, relative_error
from analysis.compensation.outcome import NetworkStudy
from analysis.compensation.settings import Training
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.performance import contrast

RESTARTS = 6
"""Further trainings with other initial weights if the first one was refused."""


def study_networks(
    truth: FirBank,
    forms: EnergyForms,
    frequency: Real,
    choices: Sequence[tuple[int, float]],
    training: Training,
    inputs: InputMap,
    report: Callable[[float], None] = lambda _share: None,
) -> NetworkStudy:
    """Train with each (nodes, spacing) on filters of `truth` at that spacing; assess on all temperatures.

    Parameters
    ----------
    truth : FirBank
        Filters computed at every temperature.
    forms : EnergyForms
        At the temperatures of `truth` and the lines `frequency`.
    frequency : (F,) ndarray, Hz
        Lines of the band.
    choices : sequence of (int, float)
        Hidden nodes, and spacing of the training temperatures, K.
    training : Training
        Settings other than the nodes.
    report : callable
        Called with the share done.

    Returns
    -------
    NetworkStudy
        NaN where the evidence collapsed for every restart.
    """
    direct = contrast(forms, truth.response(frequency))
    errors, losses = [], []
    for number, (nodes, spacing) in enumerate(choices):
        knots = _every(truth.temperature, spacing)
        bank = replace(truth, taps=truth.taps[knots], temperature=truth.temperature[knots])
        try:
            taps = _trained(bank, replace(training, nodes=nodes), inputs).taps(truth.temperature)
        except EvidenceCollapseError:
            errors.append(np.full(truth.taps.shape[1], np.nan))
            losses.append(np.nan)
        else:
            errors.append(relative_error(taps, truth.taps).mean(axis=0))
            response = replace(truth, taps=taps).response(frequency)
            losses.append(float((direct - contrast(forms, response)).max()))
        report((number + 1) / len(choices))
    nodes_of, spacings = (np.array(part, dtype=float) for part in zip(*choices, strict=True))
    return NetworkStudy(nodes_of, spacings, np.array(errors), np.array(losses))


def _trained(bank: FirBank, training: Training, inputs: InputMap) -> NetworkBank:
    """Train, up to `RESTARTS` times more if the evidence collapsed: likely with more nodes than temperatures."""
    from analysis.compensation.training import train_networks

    try:
        return train_networks(bank, training, inputs=inputs).networks
    except EvidenceCollapseError:
        return train_networks(bank, replace(training, restarts=RESTARTS), inputs=inputs).networks


def _every(temperature: Real, spacing: float) -> NDArray[np.intp]:
    """Rows nearest to every `spacing` °C from the first, and the last."""
    wanted = np.append(np.arange(temperature[0], temperature[-1] - 1e-9, spacing), temperature[-1])
    return np.unique(np.argmin(np.abs(temperature - wanted[:, None]), axis=1))
