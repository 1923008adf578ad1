"""Filters computed directly at every temperature: the reference for compensated filters."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from analysis.arrays import Real
from analysis.focusing.design import tap_design
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.local_models import local_models
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel
from analysis.focusing.responses import constants_at, design_forms
from analysis.focusing.sound_aim import SoundAim
from analysis.material import MaterialLaws
from analysis.progress import Progress


@dataclass(frozen=True)
class DirectFilters:
    """Filters computed at T temperatures, and the energy forms and models to assess others there.

    Attributes
    ----------
    bank : FirBank
        Filters (T, N, M).
    forms : EnergyForms
        Of the F lines of the band, at every temperature.
    models : sequence of PanelModel
        T local models of the panel, each reduced to the coordinates needed near its temperature.
    """

    bank: FirBank
    forms: EnergyForms
    models: Sequence[PanelModel]


def direct_filters(
    model: PanelModel,
    panel: Panel,
    laws: MaterialLaws,
    temperature: Real,
    method: Method = "stif",
    report: Progress = lambda _stage, _share: None,
    workers: int = 1,
    stage: str = "Filters everywhere",
) -> DirectFilters:
    """FIR filters computed at every temperature, and the energy forms of the band there.

    Parameters
    ----------
    temperature : (T,) ndarray, °C
    method : str
        How the filters are designed.
    report : callable
        Called with the stage and the share done.
    workers : int
        Threads that design filters.
    stage : str
        Name under which progress is reported.

    Raises
    ------
    ValueError
        For a material outside the box of the model.
    """
    lines = panel.filters.frequency
    band = panel.filters.in_band(lines)
    design, error = tap_design(method, model, panel, laws), panel.filters.thermometer_error

    sound = SoundAim.designing(panel, model.space.grid, method)
    plates = constants_at(laws, temperature)

    def known(around: Real) -> list[Constants]:
        return constants_at(laws, np.clip(around, *laws.temperature_range))

    def at(t: int) -> tuple[Real, EnergyForms]:
        local = local_to[t]
        constants = plates[t]
        form = local.forms(*constants, lines, panel.target.displacement)
        wanted = design_forms(local, panel, laws, float(temperature[t]), form, sound)
        # Its lowest modes may lie below all lines, where the coordinates of a local model are not checked.
        own = model if method == "modal-control" else local
        filters = designer(method, own, panel, lines)(
            constants, partial(local.amplitudes, *constants, lines), wanted
        )
        return design.taps(wanted, filters), form.at(slice(None), band)

    taps, forms = [], []
    with ThreadPoolExecutor(workers) as pool:
        local_to = local_models(model, known, temperature, lines, error, pool)
        for done, (tap, form) in enumerate(pool.map(at, range(len(temperature))), start=1):
            taps.append(tap)
            forms.append(form)
            report(stage, done / len(temperature))
    return DirectFilters(design.bank(np.array(taps), temperature), EnergyForms.joined(forms), local_to)
