"""Inverted channels, recorded with the wrong sign: leads swapped, or a patch mounted or poled the wrong way."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.recordings.frf import Frf
from analysis.twin_model import TwinModel
from analysis.updating.normal_equations import SweepData
from analysis.updating.start import in_phase, start_material
from analysis.updating.update import middle_sweep, stride

AGREES = 0.5
"""Correlation of twin and data above which a channel's sign is certain; unrelated responses have about 0."""


def polarity_corrected(
    frf: Frf, model: TwinModel, progress: Callable[[str, float], None] = lambda stage, share: None
) -> tuple[Frf, NDArray[np.float64]]:
    """Correct the sign of inverted channels.

    No material changes the sign of a whole FRF, so a twin does not agree with an inverted channel. If a fit does
    not agree with every channel, the start grid is searched again with the better sign for each channel; if the
    result agrees with every channel, these signs are right.

    Parameters
    ----------
    frf : Frf
        As measured.
    model : TwinModel
        The twin, evaluated inside its box only.
    progress : callable, optional
        Called with a stage's name and the share of it done.

    Returns
    -------
    frf : Frf
        With a note for each inverted channel.
    start : (3,) ndarray
        E [Pa], nu and eta of the middle sweep of the first input.

    Raises
    ------
    ValueError
        Where lines have no variance, so that they cannot be weighted.
    """
    frf.require_noise()
    begins = []
    for source in frf.driving:
        names, begin = _inverted(frf.of_source(source), model, progress)
        begins.append(begin)
        frf = frf.turned(names, source)
    return frf, begins[0]


def _inverted(
    frf: Frf, model: TwinModel, progress: Callable[[str, float], None]
) -> tuple[list[str], NDArray[np.float64]]:
    """Names of the channels inverted in one input's sweeps, and the material (3,) of its middle sweep."""
    data = SweepData.of(frf, middle_sweep(frf), stride(frf, model.box))
    begin = start_material(model, data, lambda share: progress("start grid", share))
    if _explained(model, data, begin):
        return [], begin
    other = start_material(model, data, lambda share: progress("start grid, any signs", share), signed=False)
    inverted = in_phase(data.answer(model, other), data) < 0.0
    sign = np.where(inverted, -1.0, 1.0)[:, None]
    if inverted.any() and _explained(model, replace(data, h=sign * data.h), other):
        return [name for name, wrong in zip(frf.channels, inverted, strict=True) if wrong], other
    return [], begin


def _explained(model: TwinModel, data: SweepData, begin: NDArray[np.float64]) -> bool:
    """Whether a fit started at the material `begin` (3,) agrees with every channel."""
    return bool((in_phase(data.answer(model, begin), data) > AGREES).all())
