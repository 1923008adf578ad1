"""A panel with one side warmer than the other: which temperature to use for its filters, and the contrast lost."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_shapes
from analysis.focusing.energy import FieldSpace
from analysis.focusing.fir import FirBank
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast
from analysis.progress import Progress

TILTS = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Warmer side: right, left, upper, lower (along x and y)."""
MEAN_TEMPERATURES = 3
"""Number of mean temperatures at which a difference is computed."""


class TiltedModel(Protocol):
    """Model of a panel with one side warmer than the other."""

    @property
    def space(self) -> FieldSpace:
        """The deflection shapes, measured over the panel's grid."""

    def amplitudes(self, temperature: float, across: tuple[float, float], frequency: Real) -> Complex:
        """Generalised coordinates of the field of every actuator.

        Parameters
        ----------
        temperature : float
            In the middle of the box around the plate, °C.
        across : (float, float)
            Temperature at largest x and y minus that at smallest x and y, K.
        frequency : (F,) ndarray, Hz

        Returns
        -------
        (N, F, r) complex ndarray
            Per volt or newton.
        """


@dataclass(frozen=True)
class TiltedContrast:
    """Contrast of a panel with a difference of temperature across it; last axis: mean of the lines, worst line.

    Attributes
    ----------
    difference : (G,) ndarray
        Between two opposite sides, K.
    temperature : (G, A) ndarray
        In the middle of the panel, °C.
    at_target : (G, A, D) ndarray
        At the target, °C, for each warmer side of `TILTS`.
    uniform : (G, A, 2) ndarray
        Contrast of a panel that is at the middle's temperature everywhere.
    fed_mean, fed_target : (G, A, D, 2) ndarray
        With the filters of the temperature in the middle, and with those of the temperature at the target.
    """

    difference: Real
    temperature: Real
    at_target: Real
    uniform: Real
    fed_mean: Real
    fed_target: Real

    def __post_init__(self) -> None:
        check_shapes(self, difference="G", temperature="G A", at_target="G A D", uniform="G A 2")
        check_shapes(self, at_target="G A D", fed_mean="G A D 2", fed_target="G A D 2")

    def loss(self, fed: Real) -> Real:
        """Largest loss of contrast against the uniform panel, (G, 2): of the mean and of the worst line."""
        return np.asarray((self.uniform[:, :, None] - fed).max(axis=(1, 2)))


def tilted_contrast(
    model: TiltedModel,
    panel: Panel,
    like: FirBank,
    taps: Callable[[Real], Real],
    differences: Sequence[float],
    limits: tuple[float, float],
    report: Progress = lambda _stage, _share: None,
) -> TiltedContrast:
    """Compute the contrast of filters on a panel with differences of temperature across it.

    Parameters
    ----------
    like : FirBank
        Gives sample rate and delay of the filters.
    taps : callable
        Filters (T, N, M) for temperatures (T,), °C.
    differences : sequence of float
        Between two opposite sides, K.
    limits : (float, float)
        Range of temperatures allowed anywhere on the panel, °C.
    report : callable
        Called with the stage and the share done.

    Raises
    ------
    ValueError
        Where a difference exceeds the distance of the limits.
    """
    low, high = limits
    if not 0.0 < max(differences) <= high - low:
        raise ValueError(
            f"{max(differences):g} K across the panel: the laws hold for {low:g} to {high:g} °C, "
            f"so that up to {high - low:g} K can be judged"
        )
    lines = panel.filters.frequency
    lines = lines[panel.filters.in_band(lines)]
    shares = np.array(TILTS) @ np.ravel(panel.plate.normalised(np.array([panel.target_center])))

    def reached(middle: float, across: tuple[float, float], fed: Sequence[float]) -> Real:
        """Contrast (len(fed), 2) with the filters of the temperatures `fed`: mean and worst line of the band."""
        bank = FirBank(taps(np.array(fed)), np.array(fed), like.sample_rate, like.delay)
        forms = model.space.forms([model.amplitudes(middle, across, lines)])
        found = np.array([contrast(forms, response[None])[0] for response in bank.response(lines)])
        return np.stack([found.mean(axis=1), found.min(axis=1)], axis=-1)

    temperature = np.empty((len(differences), MEAN_TEMPERATURES))
    at_target = np.empty((*temperature.shape, len(TILTS)))
    uniform, tilted = np.empty((*temperature.shape, 2)), np.empty((*at_target.shape, 2, 2))
    for g, difference in enumerate(differences):
        temperature[g] = np.linspace(low + 0.5 * difference, high - 0.5 * difference, MEAN_TEMPERATURES)
        for a, middle in enumerate(temperature[g].tolist()):
            at_target[g, a] = middle + 0.5 * difference * shares
            for d, (x, y) in enumerate(TILTS):
                fed = [middle, float(at_target[g, a, d])]
                tilted[g, a, d] = reached(middle, (difference * x, difference * y), fed)
            uniform[g, a] = reached(middle, (0.0, 0.0), [middle])[0]
            report(
                "Differences across the panel",
                (g * MEAN_TEMPERATURES + a + 1) / (MEAN_TEMPERATURES * len(differences)),
            )
    return TiltedContrast(
        np.array(differences, dtype=float), temperature, at_target, uniform, tilted[..., 0, :], tilted[..., 1, :]
    )
