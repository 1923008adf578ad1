"""Whether the samples of one channel can be a measurement: finite, alive, and inside the converter's range."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from drivers.ni.modules import InputModule

NEAR_FULL_SCALE = 1.0 - 1e-4
LEAST_CODES = 16.0
"""Codes, peak to peak: an open input shows its own noise, which is above this."""
SMOOTH_TOP = 9.0
"""Quanta: how far a smooth peak that rounds to one code for two samples can fall at the next one."""


def faults(
    samples: NDArray[np.floating], module: InputModule | None, unit: str = "V"
) -> Iterator[tuple[str, str]]:
    """Yield what is wrong with a channel, as (seen, allowed).

    Parameters
    ----------
    samples : (M,) ndarray
    module : InputModule or None
        Gives range and resolution; None where the module is unknown, or the samples are no volts.
    unit : str
        Of the samples.

    Yields
    ------
    seen, allowed : str
        One pair at most: further checks mean nothing after a fault.
    """
    finite = np.isfinite(samples)
    if not finite.all():
        where = int(np.argmin(finite))
        yield (
            f"{samples[where]} at sample {where} ({np.count_nonzero(~finite)} of {samples.size})",
            "finite volts" if unit == "V" else "finite numbers",
        )
        return
    low, high = float(samples.min()) + 0.0, float(samples.max()) + 0.0  # no "-0 V"
    alive = LEAST_CODES * module.quantum if module else 0.0
    if high - low <= alive:
        yield f"{low:g} to {high:g} {unit} throughout", "a signal (is the channel connected and switched on?)"
        return
    if module and max(-low, high) >= NEAR_FULL_SCALE * module.full_scale:
        count = int(np.count_nonzero(np.abs(samples) >= NEAR_FULL_SCALE * module.full_scale))
        yield (
            f"{count} clipped samples, up to {max(-low, high):g} V",
            f"below the {module.full_scale:g} V that the {module.name} converts (lower the drive or the gain)",
        )
        return
    held = flat_topped(samples)
    if held:
        yield (
            f"{held} clipped samples, flat at {low:g} or {high:g} {unit}",
            "peaks that are not cut off (lower the drive or the gain, or widen the range)",
        )


def flat_topped(samples: NDArray[np.floating]) -> int:
    """Count the samples of cut-off peaks: held at the channel's extreme, with steps into and out of it.

    A smooth peak that a converter of step q rounds to one code for r samples falls by less than
    q (r+1)^2/(r-1)^2, so at most 9 q, at the sample after: a longer step out of a flat top means that
    something cut it. One flat top of two samples may be chance, and is let through.

    Parameters
    ----------
    samples : (M,) ndarray

    Returns
    -------
    int
        Samples on cut-off peaks; 0 if there is none.
    """
    total = 0
    for upright in (samples, -samples):
        top = upright == upright.max()
        edges = np.flatnonzero(np.diff(top.astype(np.int8), prepend=0, append=0))
        starts, ends = edges[::2], edges[1::2]  # samples starts[i] .. ends[i]-1 are held at the top
        inner = (starts > 0) & (ends < samples.size) & (ends - starts >= 2)
        starts, ends = starts[inner], ends[inner]
        if not starts.size:
            continue
        steps = np.abs(np.diff(upright))
        quantum = steps[steps > 0.0].min()
        drop = np.minimum(upright[starts] - upright[starts - 1], upright[starts] - upright[ends])
        cut = drop > SMOOTH_TOP * quantum
        held = int(np.sum((ends - starts)[cut]))
        if held > 2:
            total += held
    return total
