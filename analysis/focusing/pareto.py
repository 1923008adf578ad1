"""Contrast against evenness of the sound: what filters between the two reach, at one temperature."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Mask, Real
from analysis.checked_fields import check_shapes
from analysis.focusing.design import TapDesign, peak_drive
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel
from analysis.focusing.performance import contrast
from analysis.focusing.sound_aim import SoundAim
from analysis.progress import Progress
from analysis.radiation.measures import ripple

EVENNESS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""From the field alone to an even sound: exponents of the movement of the target that the sound asks for."""
WEIGHTS = (1.0, 3.0, 10.0, 30.0)
"""Of the energy outside the target."""
FAIR_RIPPLE = 1.0
"""dB either way, third octaves, that are heard as even."""


@dataclass(frozen=True)
class ParetoCurve:
    """Designs of p pairs of evenness and weight outside, their taps judged in the band of one temperature.

    Attributes
    ----------
    temperature : float
        °C.
    evenness, outside_weight : (p,) ndarray
    contrast, worst : (p,) ndarray
        Mean over the lines, and the worst line.
    ripple : (p,) ndarray
        Third-octave ripple, ± dB, at the listener that has most.
    level : (p,) ndarray
        Mean level at the listeners, dB of the sound wanted.
    drive : (p,) ndarray
        Largest share of an actuator's rating that audio within ±1 can take; 0 for forces, which have none.
    """

    temperature: float
    evenness: Real
    outside_weight: Real
    contrast: Real
    worst: Real
    ripple: Real
    level: Real
    drive: Real

    def __post_init__(self) -> None:
        rows = ("evenness", "outside_weight", "contrast", "worst", "ripple", "level", "drive")
        check_shapes(self, **dict.fromkeys(rows, "p"))

    @property
    def front(self) -> Mask:
        """Designs (p,) that no other one beats in contrast and in ripple."""
        better = (self.contrast[None] >= self.contrast[:, None]) & (self.ripple[None] <= self.ripple[:, None])
        strictly = (self.contrast[None] > self.contrast[:, None]) | (self.ripple[None] < self.ripple[:, None])
        return np.asarray(~(better & strictly).any(axis=1))

    @property
    def unbeaten(self) -> NDArray[np.int_]:
        """Places of these designs, the most even one first."""
        order = np.argsort(self.ripple)
        return np.asarray(order[self.front[order]])

    @property
    def recommended(self) -> int:
        """Of the designs within `FAIR_RIPPLE`, the one of most contrast; where none is, the most even one."""
        fair = self.ripple <= FAIR_RIPPLE
        return int(np.argmax(np.where(fair, self.contrast, -1.0)) if fair.any() else np.argmin(self.ripple))


def pareto(
    model: PanelModel,
    panel: Panel,
    constants: Constants,
    temperature: float,
    report: Progress = lambda _stage, _share: None,
) -> ParetoCurve:
    """Design and judge all pairs of `EVENNESS` and `WEIGHTS`.

    Parameters
    ----------
    panel : Panel
        With an aim at sound.
    constants : (float, float, float)
        E, Pa, nu and eta at this temperature.
    temperature : float
        °C.
    report : callable
        Called with the stage and the share done.

    Raises
    ------
    ValueError
        For a panel that aims at the field, and a material outside the box of the model.
    """
    settings, lines = panel.filters, panel.filters.frequency
    if settings.aim == "field":
        raise ValueError("a panel that aims at the field; allowed: aim 'volume' or 'listeners'")
    band, space = settings.in_band(lines), model.space
    aim, judge = SoundAim.of(panel, space.grid), SoundAim.of(panel, space.grid, "listeners")
    amplitude = model.amplitudes(*constants, lines)
    forms = model.forms(*constants, lines, panel.target.displacement)
    within, design = forms.at(slice(None), band), TapDesign.of(panel, settings.middle)
    pairs, rows = list(product(EVENNESS, WEIGHTS)), []
    for done, (evenness, weight) in enumerate(pairs, start=1):
        asked = aim.forms(space, amplitude, forms, evenness, weight)
        wanted = np.asarray(np.linalg.solve(asked.plate, asked.aim[..., None])[0, ..., 0], dtype=complex)
        taps = design.taps(asked, wanted)
        filters = design.bank(taps[None], np.zeros(1)).response(lines[band])[0]
        sound = judge.relative(space, amplitude[:, band], filters, band)[judge.loud]
        moved, peak = contrast(within, filters)[0], peak_drive(taps)
        level = float(np.mean(20.0 * np.log10(np.maximum(np.abs(sound), 1e-10))))
        uneven = float(ripple(sound, lines[band]).max())
        rows.append((moved.mean(), moved.min(), uneven, level, float((peak / panel.limits).max())))
        report("Contrast and evenness", done / len(pairs))
    evenness, weights = np.array(pairs).T
    return ParetoCurve(temperature, evenness, weights, *np.array(rows, dtype=float).T)
