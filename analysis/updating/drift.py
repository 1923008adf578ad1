"""Drift of the temperature within sweeps: each frequency is measured at a temperature of its own."""

from concurrent.futures import Executor

import numpy as np
from numpy.typing import NDArray

from analysis.experiment import Protocol
from analysis.frf import Frf
from analysis.gap.data.preparation import sweep_points
from analysis.local_laws import LocalLaws
from analysis.material import MaterialLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import NO_EFFECTS, TwinModel
from analysis.updated import Updated


def sweep_laws(updated: Updated, laws: MaterialLaws | None) -> list[LocalLaws]:
    """Laws through the material of every sweep, with the slopes of `laws` there; without `laws`, with none."""
    low, high = laws.temperature_range if laws else (0.0, 0.0)
    rows = zip(updated.temperature.tolist(), updated.constants, strict=True)
    return [
        LocalLaws.of_material(
            *material,
            reference=t,
            slope=tuple(laws.local(min(max(t, low), high)).slope) if laws else (0.0, 0.0, 0.0),
        )
        for t, material in rows
    ]


def drift_of_frfs(
    frf: Frf, model: TwinModel, updated: Updated, laws: MaterialLaws, protocol: Protocol, executor: Executor
) -> NDArray[np.complex128] | None:
    """Compute by how much FRFs differ from those at the mean temperature of each sweep.

    Parameters
    ----------
    frf : Frf
    model : TwinModel
    updated : Updated
        Model updating of these FRFs, taken as if measured at the mean temperature.
    laws : MaterialLaws
        Through its estimates; they give the slopes over temperature.
    protocol : Protocol
    executor : Executor
        Sweeps are computed on it.

    Returns
    -------
    (T, K, F) complex ndarray or None
        To first order in the drift; None where none is known.
    """
    points = sweep_points(frf, protocol)
    if not any(point.drifts for point in points):
        return None

    def change(law: LocalLaws, point: SweepPoint) -> NDArray[np.complex128]:
        by_temperature = model.linearise(law, frf.frequency, NO_EFFECTS, point).by_temperature
        return np.asarray(updated.gains[point.source] * point.drift(frf.frequency) * by_temperature)

    return np.array(list(executor.map(change, sweep_laws(updated, laws), points)))
