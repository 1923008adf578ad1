"""Sweeps of a campaign that was not made yet, with the noise of one that was."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from analysis.arrays import Real
from analysis.experiment import Protocol
from analysis.gap.data.groups import TemperatureGroups
from analysis.gap.data.law_smoothness import LawSmoothness
from analysis.gap.data.preparation import compressed, grouped
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.state import GapState, clipped_laws, plain_state
from analysis.gap.thresholds import SHARPEST
from analysis.material import MaterialBox
from analysis.recordings.frf import Frf

MOST_TEMPERATURES = 8
"""Temperatures of a planned campaign, at most: more take oven time in proportion, and tell effects apart no better
than their number's square root."""
CHANNEL = "further"
"""Beginning of the names of outputs that the recorded campaign lacks."""


def planned_sweeps(
    frf: Frf,
    recorded: GapSweeps,
    state: GapState,
    protocol: Protocol,
    box: MaterialBox,
    further: int = 0,
) -> tuple[GapSweeps, GapState]:
    """Return the sweeps of a planned campaign, with noise and no signal, and the state of the twin in it.

    Parameters
    ----------
    frf : Frf
        Recorded: its noise, over level, is that of the planned sweeps; beyond its band that at the band's ends.
    recorded : GapSweeps
        Of `frf`.
    state : GapState
        Fitted to them. Beyond their temperatures laws go on in straight lines.
    protocol : Protocol
        Of the planned campaign.
    box : MaterialBox
        Within which the twin can be asked.
    further : int
        Number of outputs that `frf` lacks, the last ones; their noise is set by `with_noise_of`.

    Returns
    -------
    sweeps : GapSweeps
    state : GapState
    """
    places = [
        (float(t), way, float(level), source)
        for way in protocol.directions
        for t in protocol.temperatures
        for level in protocol.levels
        for source in frf.driving
    ]
    frequency, excluded = _lines(frf, protocol)
    temperature = np.array([t for t, *_ in places])
    noise = {source: _noise(frf, source, frequency, protocol) for source in frf.driving}
    variance = np.array([noise[source] / level**2 for *_, level, source in places])
    variance = np.concatenate([variance, np.repeat(variance[:, :1], further, axis=1)], axis=1)
    count, channels = len(places), len(frf.channels) + further
    planned = replace(
        frf,
        temperature=temperature,
        direction=tuple(way for _, way, *_ in places),
        level=np.array([level for *_, level, _ in places]),
        frequency=frequency,
        h=np.zeros((count, channels, frequency.size), dtype=complex),
        variance=variance,
        coherence=np.ones((count, channels, frequency.size)),
        excluded=excluded,
        channels=(*frf.channels, *(f"{CHANNEL} {k + 1}" for k in range(further))),
        labels=(),
        units=(),
        source=None if frf.source is None else np.array([source for *_, source in places]),
        repeats_dof=None,
        shift=None,
    )
    groups = TemperatureGroups.of(temperature)
    laws = clipped_laws(box, laws_at(recorded, state, groups.reference))
    sharp = SHARPEST * float(np.exp(laws[:, 2].min()))
    sweeps = grouped(
        planned,
        compressed(planned, sharp),
        groups,
        laws,
        protocol=protocol,
        reading_sigma=recorded.reading_sigma,
        twin_error=recorded.twin_error,
    )
    begun = plain_state(groups, laws, state.log_gain, state.effects)
    return sweeps, replace(begun, declared=state.declared)


def laws_at(recorded: GapSweeps, state: GapState, temperature: Real) -> Real:
    """Laws (G, 3) at temperatures, degrees Celsius: between those of a fit interpolated, beyond in straight lines.

    Parameters
    ----------
    recorded : GapSweeps
    state : GapState
        Fitted to them.
    temperature : (G,) ndarray

    Returns
    -------
    (G, 3) ndarray
        log E, nu and log eta.
    """
    from scipy.interpolate import PchipInterpolator

    at, laws = recorded.groups.reference, state.laws
    if at.size == 1:
        return np.repeat(laws, len(temperature), axis=0)
    slope, _ = LawSmoothness.of(at, laws).derivatives(laws)
    found = np.asarray(PchipInterpolator(at, laws, extrapolate=True)(np.clip(temperature, at[0], at[-1])))
    for end, beyond in ((0, np.minimum(temperature - at[0], 0.0)), (-1, np.maximum(temperature - at[-1], 0.0))):
        found = found + beyond[:, None] * slope[end]
    return np.asarray(found)


def with_noise_of(sweeps: GapSweeps, size: Sequence[float], further: int) -> GapSweeps:
    """Give further outputs the noise, relative to the signal, of the first recorded one.

    Parameters
    ----------
    sweeps : GapSweeps
        As from `planned_sweeps`.
    size : sequence of float
        rms of every output's predicted signal, (K,).
    further : int
        Number of the last outputs.

    Returns
    -------
    GapSweeps
    """
    ratio = np.ones(len(size))
    ratio[-further:] = (np.asarray(size)[-further:] / size[0]) ** 2
    return replace(sweeps, compressed=tuple(one.rescaled(ratio) for one in sweeps.compressed))


def _lines(frf: Frf, protocol: Protocol) -> tuple[Real, "np.ndarray[tuple[int], np.dtype[np.bool_]]"]:
    """Lines of the planned band, with the spacing of those recorded, and which of them are left out."""
    step = float(np.median(np.diff(frf.frequency)))
    low, high = protocol.band
    below = np.arange(frf.frequency[0] - step, low - 1e-9 * step, -step)[::-1]
    above = np.arange(frf.frequency[-1] + step, high + 1e-9 * step, step)
    inside = (frf.frequency >= low - 1e-9 * step) & (frf.frequency <= high + 1e-9 * step)
    frequency = np.concatenate([below, frf.frequency[inside], above])
    left_out = np.concatenate([np.zeros(below.size, bool), frf.excluded[inside], np.zeros(above.size, bool)])
    return frequency, left_out


def _noise(frf: Frf, source: int, frequency: Real, protocol: Protocol) -> Real:
    """Variance (K, F) of one sweep from an input at a level of 1; of a logarithmic sweep's own fall beyond."""
    chosen = frf.driven_by == source
    at_one = np.median(frf.variance[chosen] * frf.level[chosen, None, None] ** 2, axis=0)
    found = np.array([np.interp(frequency, frf.frequency, row) for row in at_one])
    if protocol.sweep == "logarithmic":  # its power per line falls as 1/f
        inner = np.clip(frequency, frf.frequency[0], frf.frequency[-1])
        found = found * (frequency / inner)
    return np.asarray(found)
