"""What discretisation does to a twin, and whether a campaign can be judged with it.

An error of the mesh looks like physics: one of 0.5 to 1 % of the response has been taken for an offset of the
sensor, with a log Bayes factor of 11; one of 2 to 4 % for feedthrough, with 5229.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.gap.model import SweepPoint
from analysis.gap.thresholds import MODEL_ERROR, NUMERICAL_REST

Defect = Callable[[SweepPoint, NDArray[np.float64]], NDArray[np.complex128]]
"""Circumstances and (F,) Hz -> (K, F): refined less working transfer at the baseline, per actuator volt."""


@dataclass(frozen=True)
class NumericalFloor:
    """What discretisation does to the twin, as shares of rms|H|.

    Attributes
    ----------
    error : float
        By how much the twin differs from the same plate on another mesh, the correction applied if there is one.
    noise : float
        Of one line of a sweep.
    defect : callable, optional
        Frozen correction, added to the model's transfer wherever it is asked: for a twin that is the coarser one.
    """

    error: float
    noise: float
    defect: Defect | None = None

    def __post_init__(self) -> None:
        rest = self.error / self.noise
        if self.error > MODEL_ERROR and rest > NUMERICAL_REST:
            raise ValueError(
                f"this plate computed on two meshes differs by {100 * self.error:.2g} % of the response, "
                f"{rest:.2f} sigma of the noise; at most {NUMERICAL_REST:g} sigma or {100 * MODEL_ERROR:g} % "
                "allowed, or ghosts would be named. Check the sizes of plate and patches, or lower protocol.band"
            )

    @property
    def carried(self) -> float:
        """Share of rms|H| that is an error of the twin common to all lines, and nobody's missing physics."""
        return max(self.error, MODEL_ERROR)

    @property
    def notes(self) -> tuple[str, ...]:
        """What a user should know of it."""
        if self.error <= MODEL_ERROR:
            return ()
        return (
            f"this plate computed on two meshes differs by {100 * self.error:.2g} % of the response: "
            "gaps of that size are not judged, and evidence is reduced by what it could feign",
        )
