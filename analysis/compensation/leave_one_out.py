"""Leave-one-out error: every inner training filter is predicted from the others; needs no twin."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.compensation.outcome import Trained
from analysis.compensation.settings import Training
from analysis.focusing.fir import FirBank


def left_out_taps(filters: FirBank, method: Callable[[FirBank, Real], Real]) -> Real:
    """Taps (n-2, N, M) that a `method` (filters, temperatures) gives at each inner temperature withheld."""
    found = []
    for left in range(1, len(filters.temperature) - 1):
        keep = np.arange(len(filters.temperature)) != left
        rest = replace(filters, taps=filters.taps[keep], temperature=filters.temperature[keep])
        found.append(method(rest, filters.temperature[left : left + 1])[0])
    return np.array(found)


def left_out_networks(
    filters: FirBank, trained: Trained, settings: Training, device: str = "cpu", epochs: int = 300
) -> Real:
    """Predict every inner training filter by networks trained without it.

    All of them are trained side by side, each from the hidden layer of the full training.

    Parameters
    ----------
    filters : FirBank
        At the n training temperatures.
    trained : Trained
        The networks trained on all of them.
    device : str
        To train on: ``cpu``, or torch's name of another.
    epochs : int
        Largest number of steps tried.

    Returns
    -------
    (n - 2, N, M) ndarray
        Taps of each filter left out.
    """
    from analysis.compensation.bayesian import train
    from analysis.compensation.training import outputs_at, prepare

    count, actuators = filters.taps.shape[:2]
    inner = np.arange(1, count - 1)
    targets = np.repeat(filters.taps.transpose(1, 0, 2)[None], len(inner), axis=0).reshape(
        -1, *filters.taps.shape[::2]
    )
    used = np.ones((len(inner), actuators, count))
    used[np.arange(len(inner)), :, inner] = 0.0
    inputs = trained.networks.input.at(filters.temperature)
    hidden = tuple(np.tile(layer, (len(inner), 1)) for layer in (trained.networks.slope, trained.networks.bias))
    batch = prepare(
        inputs,
        targets,
        used.reshape(-1, count),
        replace(settings, start="warm"),
        np.random.default_rng(settings.seed),
        device,
        (hidden[0], hidden[1]),
    )
    fit = train(batch.problem, batch.start, epochs)
    taps = outputs_at(batch, fit.weights, inputs).reshape(len(inner), actuators, count, -1)
    return np.asarray(taps[np.arange(len(inner)), :, inner])
