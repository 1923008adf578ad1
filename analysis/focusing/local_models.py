"""A panel in fewer coordinates over a few kelvins: those its answers there need."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.focusing.panel_model import Constants, PanelModel

WINDOW, STEP = 10.0, 5.0
"""Kelvins that one local model covers, and between the temperatures it is made from."""

KEPT = 1e-10
"""Share of the energy of all normalised answers that the coordinates left out may hold."""

ERROR = 5e-4
"""Largest error of a local answer, of that answer, half-way between; half the twin's own tolerance."""

FEWEST = 20
"""Temperatures in a window from which a local model pays."""


def local_models(
    model: PanelModel,
    constants: Callable[[Real], Sequence[Constants]],
    temperature: Real,
    lines: Real,
    margin: float,
    pool: Executor,
) -> list[PanelModel]:
    """Give the model for each temperature: the whole one, or one of a window that holds many temperatures.

    Parameters
    ----------
    model : PanelModel
    constants : callable
        From temperatures (n,), °C, to E, nu and eta at each.
    temperature : (T,) ndarray, °C
    lines : (F,) ndarray, Hz
        Where it will be asked.
    margin : float
        How far from its temperature each will be asked, °C.
    pool : Executor
        Makes the models side by side.

    Returns
    -------
    list of PanelModel
        T of them; those of one window are the same.
    """
    low, high = temperature.min(), temperature.max()
    last = max(int(np.ceil((high - low) / WINDOW)) - 1, 0)
    windows = np.minimum((temperature - low) // WINDOW, last).astype(int)
    made: dict[int, Callable[[], PanelModel]] = {}
    for window in np.unique(windows):
        here = temperature[windows == window]
        if len(here) >= FEWEST:
            coldest, hottest = here.min() - margin, here.max() + margin
            nodes = np.linspace(coldest, hottest, int(np.ceil((hottest - coldest) / STEP)) + 1)
            between = 0.5 * (nodes[1:] + nodes[:-1])
            job = partial(local_model, model, constants(nodes), constants(between), lines)
            made[int(window)] = pool.submit(job).result
    found = {window: result() for window, result in made.items()}
    return [found.get(int(window), model) for window in windows]


def local_model(
    model: PanelModel, made_from: Sequence[Constants], tried_at: Sequence[Constants], lines: Real
) -> PanelModel:
    """Restrict a model to what its answers at some materials need.

    The coordinates are the principal ones of all answers at the materials it is made from, each answer of unit
    length (proper orthogonal decomposition). They grow until answers at other materials come out right.

    Parameters
    ----------
    model : PanelModel
    made_from : sequence of (float, float, float)
        E, nu and eta.
    tried_at : sequence of (float, float, float)
        Where the result is tried.
    lines : (F,) ndarray, Hz

    Returns
    -------
    PanelModel
        `model` itself where fewer coordinates err by more than `ERROR` or save nothing.
    """
    some = lines[np.unique(np.linspace(0, len(lines) - 1, 64).astype(int))]
    gram = sum(_gram(model, one, some) for one in made_from)
    values, vectors = np.linalg.eigh(gram)
    rest = np.cumsum(np.maximum(values, 0.0)) / values.sum()
    for kept in (KEPT, 0.1 * KEPT):
        basis = vectors[:, rest > kept]
        if basis.shape[1] > 0.8 * len(vectors):
            break
        local = model.restricted(basis)
        if max(_error(model, local, basis, one, some) for one in tried_at) <= ERROR:
            return local
    return model


def _gram(model: PanelModel, constants: Constants, lines: Real) -> NDArray[np.float64]:
    """Sum (r, r) of a aᵀ over real and imaginary parts of all answers, each of unit length."""
    answers = model.amplitudes(*constants, lines)
    answers = answers / np.linalg.norm(answers, axis=-1, keepdims=True)
    flat = answers.reshape(-1, answers.shape[-1])
    gram: NDArray[np.float64] = flat.real.T @ flat.real + flat.imag.T @ flat.imag
    return gram


def _error(model: PanelModel, local: PanelModel, basis: Real, constants: Constants, lines: Real) -> float:
    """Largest error of any answer at one material, of its length."""
    whole = model.amplitudes(*constants, lines)
    missed = whole - local.amplitudes(*constants, lines) @ basis.T
    return float((np.linalg.norm(missed, axis=-1) / np.linalg.norm(whole, axis=-1)).max())
