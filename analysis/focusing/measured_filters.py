"""Filters from measured transfers at the measured temperatures, without laws or twin."""

from functools import partial

import numpy as np

from analysis.focusing.design import TapDesign
from analysis.focusing.fir import suited_delay
from analysis.focusing.measured import MeasuredPanel
from analysis.focusing.methods import Method, MethodComparison, designer
from analysis.focusing.over_temperature import Answer, Focusing, design_and_assess
from analysis.focusing.panel_model import NoModes
from analysis.focusing.performance import aim
from analysis.focusing.sound_aim import SoundAim
from analysis.progress import Progress


def focus_measured(
    measured: MeasuredPanel,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
) -> Focusing:
    """Design filters from measured transfers, at the measured temperatures.

    Parameters
    ----------
    method : str
        One of `METHODS`.
    report : callable
        Called with the stage and the share done.
    workers : int
        Threads that design filters.

    Raises
    ------
    ValueError
        For modal control, which needs a model's modes.
    """
    panel, temperature = measured.panel, measured.transfers.temperature
    settings, displacement = panel.filters, panel.target.displacement
    if method == "modal-control":
        raise ValueError("modal-control needs the modes of a model; measured transfers allow the other methods")
    rule = designer(method, NoModes(measured.space), panel, settings.frequency)
    sound = SoundAim.designing(panel, measured.grid, method)

    def answer(t: int) -> Answer:
        amplitude = measured.amplitudes(t)
        forms, judged = measured.forms(t, displacement)
        if sound is not None:
            forms = sound.forms(measured.space, amplitude, forms)
        return Answer(amplitude, forms, judged, rule((0.0, 0.0, 0.0), lambda: amplitude, forms))

    near = measured.reference
    late = method != "stif" and settings.delay is None
    delay = suited_delay(answer(near).wanted[None], settings) if late else settings.middle
    places = [partial(answer, t) for t in range(len(temperature))]
    kept = (float(temperature[near]), places[near])
    design = TapDesign.of(panel, delay)
    heard = sound if panel.filters.aim == "listeners" else SoundAim.judging(panel, measured.grid)
    return design_and_assess(
        panel, measured.space, method, design, temperature, places, kept, report, workers, heard
    )


def compare_measured(measured: MeasuredPanel) -> MethodComparison:
    """Contrast and spot error of every method that needs no model, at the temperature nearest to the reference."""
    panel, space = measured.panel, measured.space
    settings = panel.filters
    lines, band = settings.frequency, settings.in_band(settings.frequency)
    t = measured.reference
    amplitude = measured.amplitudes(t)
    forms, judged = measured.forms(t, panel.target.displacement)
    within, fields = judged.at(slice(None), band), amplitude[:, band]
    methods: tuple[Method, ...] = ("stif", "time-reversal", "none")
    found = []
    for method in methods:
        filters = designer(method, NoModes(space), panel, lines)((0.0, 0.0, 0.0), lambda: amplitude, forms)
        found.append(aim(space, within, fields, filters[band], 1.0))
    contrasts, spots = np.array([one[0] for one in found]), np.array([one[1] for one in found])
    return MethodComparison(methods, (0.0, 0.0, 0.0), lines[band], contrasts, spots)
