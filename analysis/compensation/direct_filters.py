"""Filters computed directly at every temperature: the reference for compensated filters.

They come from local models: a panel reduced to the coordinates of its responses within a few kelvins.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.focusing.design import tap_design
from analysis.focusing.energy import EnergyForms
from analysis.focusing.fir import FirBank
from analysis.focusing.methods import Method, designer
from analysis.focusing.panel import Panel
from analysis.focusing.panel_model import Constants, PanelModel, constants_at, design_forms
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


MODEL_RANGE, MODEL_STEP = 10.0, 5.0
"""Range of one local model, and spacing of the temperatures it is made from, K."""

LARGEST_ENERGY_LEFT_OUT = 1e-10
"""Largest share of the energy of all normalised responses in the coordinates left out."""

LARGEST_MODEL_ERROR = 5e-4
"""Largest relative error of a local response between these temperatures: half the twin's own tolerance."""

FEWEST_TEMPERATURES = 20
"""Smallest number of temperatures in a window for which a local model saves time."""


def local_models(
    model: PanelModel,
    constants: Callable[[Real], Sequence[Constants]],
    temperature: Real,
    lines: Real,
    margin: float,
    pool: Executor,
) -> list[PanelModel]:
    """Return a model for each temperature: the full one, or the local one of a window with many temperatures.

    Parameters
    ----------
    constants : callable
        From temperatures (n,), °C, to E, nu and eta at each.
    temperature : (T,) ndarray, °C
    lines : (F,) ndarray, Hz
        Where it will be evaluated.
    margin : float
        Largest distance from its temperature at which each will be evaluated, K.
    pool : Executor
        Computes the models in parallel.

    Returns
    -------
    list of PanelModel
        T of them; those of one window are the same.
    """
    low, high = temperature.min(), temperature.max()
    last = max(int(np.ceil((high - low) / MODEL_RANGE)) - 1, 0)
    windows = np.minimum((temperature - low) // MODEL_RANGE, last).astype(int)
    made: dict[int, Callable[[], PanelModel]] = {}
    for window in np.unique(windows):
        here = temperature[windows == window]
        if len(here) >= FEWEST_TEMPERATURES:
            coldest, hottest = here.min() - margin, here.max() + margin
            nodes = np.linspace(coldest, hottest, int(np.ceil((hottest - coldest) / MODEL_STEP)) + 1)
            between = 0.5 * (nodes[1:] + nodes[:-1])
            job = partial(local_model, model, constants(nodes), constants(between), lines)
            made[int(window)] = pool.submit(job).result
    found = {window: result() for window, result in made.items()}
    return [found.get(int(window), model) for window in windows]


def local_model(
    model: PanelModel, made_from: Sequence[Constants], tried_at: Sequence[Constants], lines: Real
) -> PanelModel:
    """Reduce a model to the principal coordinates of its responses at some materials.

    They are the principal coordinates of all responses at the materials it is made from, each of unit length
    (proper orthogonal decomposition). Their number grows until responses at other materials are accurate.

    Parameters
    ----------
    made_from : sequence of (float, float, float)
        E, nu and eta.
    tried_at : sequence of (float, float, float)
        Materials at which the error is checked.
    lines : (F,) ndarray, Hz

    Returns
    -------
    PanelModel
        `model` itself where the error of fewer coordinates exceeds `LARGEST_MODEL_ERROR` or they save nothing.
    """
    some = lines[np.unique(np.linspace(0, len(lines) - 1, 64).astype(int))]
    gram = sum(_gram(model, one, some) for one in made_from)
    values, vectors = np.linalg.eigh(gram)
    rest = np.cumsum(np.maximum(values, 0.0)) / values.sum()
    for kept in (LARGEST_ENERGY_LEFT_OUT, 0.1 * LARGEST_ENERGY_LEFT_OUT):
        basis = vectors[:, rest > kept]
        if basis.shape[1] > 0.8 * len(vectors):
            break
        local = model.restricted(basis)
        if max(_error(model, local, basis, one, some) for one in tried_at) <= LARGEST_MODEL_ERROR:
            return local
    return model


def _gram(model: PanelModel, constants: Constants, lines: Real) -> NDArray[np.float64]:
    """Sum (r, r) of a aᵀ over real and imaginary parts of all responses, each of unit length."""
    answers = model.amplitudes(*constants, lines)
    answers = answers / np.linalg.norm(answers, axis=-1, keepdims=True)
    flat = answers.reshape(-1, answers.shape[-1])
    gram: NDArray[np.float64] = flat.real.T @ flat.real + flat.imag.T @ flat.imag
    return gram


def _error(model: PanelModel, local: PanelModel, basis: Real, constants: Constants, lines: Real) -> float:
    """Largest relative error of any response at one material."""
    whole = model.amplitudes(*constants, lines)
    missed = whole - local.amplitudes(*constants, lines) @ basis.T
    return float((np.linalg.norm(missed, axis=-1) / np.linalg.norm(whole, axis=-1)).max())


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
