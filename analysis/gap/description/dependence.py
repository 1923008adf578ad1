"""How the strength of a described cause changes with temperature, ramp, level, channel and time.

At the fit, the cause's whole signal in the sweeps of one temperature (ramp, level, ...) is one unknown, and laws,
readings and gain are eliminated: to first order, its strength there over that of the fit to all.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.description.described import Dependence
from analysis.gap.fitting.gap_fit import GapFit
from analysis.gap.fitting.normal_equations import WhitenedSweep, whiten_all
from analysis.gap.fitting.schur_complement import schur_complement
from analysis.twin_model import Tangent, TwinModel

TIMES = 3
"""Parts of the campaign, in the order of its sweeps."""
MOST = 12
"""Temperatures told apart: neighbours are taken together beyond."""


def dependences(
    model: TwinModel, sweeps: GapSweeps, fit: GapFit, effect: str, executor: Executor, errors: float
) -> tuple[Dependence, ...]:
    """Strength of an effect by temperature, ramp, level, channel and time.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
    fit : GapFit
        Of these sweeps, the effect among its own.
    effect : str
    executor : Executor
        Sweeps are linearised on it.
    errors : float
        By which chi2 is divided.

    Returns
    -------
    tuple of Dependence
        Of circumstances that have more than one value in these sweeps; none of an effect without strength.
    """
    state, card = fit.state, model.cards[effect]
    values = state.effects[effect]
    tangents: list[Tangent] = [(effect, p.name, values) for p in card.amplitudes]
    white = whiten_all(model, sweeps, state, tangents, executor)
    amounts = np.array([values[p.name] for p in card.amplitudes])
    first = len(white[0].white) - 1 - len(amounts)
    signal = np.array([np.tensordot(amounts, one.white[first:-1], 1) for one in white])
    found: list[Dependence] = []
    if not signal.any():
        return ()
    for on, labels, part in _circumstances(sweeps):
        split = [_split(one, signal[s], first, part[s]) for s, one in enumerate(white)]
        equations = [one.equations() for one in split]
        head = schur_complement(sweeps, equations, state, weight=1.0 / errors)
        left = head.without_gains()
        matrix = left.matrix + 1e-12 * np.trace(left.matrix) * np.eye(len(labels))
        covariance = np.linalg.inv(matrix)
        factor = 1.0 + covariance @ left.gradient
        found.append(Dependence(on, labels, factor, np.sqrt(np.diag(covariance))))
    return tuple(found)


def _split(one: WhitenedSweep, signal: NDArray[np.complex128], first: int, part: Real) -> WhitenedSweep:
    """Replace a sweep's columns of the effect by its signal in each part (L, K) of the data."""
    own = np.concatenate([one.white[:first], part[:, :, None] * signal, one.white[-1:]])
    return replace(one, white=own)


def _circumstances(sweeps: GapSweeps) -> Iterator[tuple[str, tuple[str, ...], Real]]:
    """Yield circumstances, their values, and which channels of which sweeps have each: (T, L, K)."""
    channels = len(sweeps.channels)
    group = sweeps.groups.of_sweep * MOST // max(len(sweeps.groups.size), MOST)
    mean = [
        sweeps.groups.reference[np.unique(sweeps.groups.of_sweep[group == k])].mean() for k in np.unique(group)
    ]
    order = np.argsort(np.argsort(sweeps.original)) * TIMES // sweeps.count
    for on, labels, of_sweep in (
        ("temperature", [f"{t:.0f} °C" for t in mean], np.unique(group, return_inverse=True)[1]),
        ("ramp", *_named(sweeps.direction)),
        ("level", *_named(sweeps.drives)),
        ("time", [f"part {k + 1} of {TIMES}" for k in range(TIMES)], order),
    ):
        if len(labels) > 1 and len(np.unique(of_sweep)) == len(labels):
            part = of_sweep[:, None] == np.arange(len(labels))
            yield on, tuple(labels), np.repeat(part[:, :, None], channels, axis=2).astype(float)
    if channels > 1:
        yield "channel", sweeps.channels, np.tile(np.eye(channels), (sweeps.count, 1, 1))


def _named(values: Sequence[str]) -> tuple[list[str], NDArray[np.int_]]:
    known = list(dict.fromkeys(values))
    return known, np.array([known.index(one) for one in values])
