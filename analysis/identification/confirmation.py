"""Confirmation of modes: which are found again when band, lines or channels change.

BIC judges a pole on one set of data. It does not notice that a pole compensates a model error near a band edge, or
that channels measured on different states of a structure are in one fit. Such poles move or vanish when the data
are changed a little, modes do not. All refits start from the poles found and run on averaged lines, so that they
cost a fraction of the search.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.averaging import averaged
from analysis.identification.damping_prior import DampingPrior
from analysis.identification.lines import Lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.order import eliminate, pole_penalty, support
from analysis.identification.pole_search import fit
from analysis.identification.principal_frfs import MANY, principal_frfs

SHIFT_OF_BAND = 0.05
"""Share of the band that is cut off at its lower, then at its upper end."""

SAME_FREQUENCY = 1.0
"""Largest distance of the same pole in two fits, in half widths (half the half-power bandwidth)."""

SAME_DAMPING = 0.5
"""The same for the damping ratio, relative."""

LINES_OF_PEAK = 3
"""Lines within the half-power bandwidth needed to show a mode when every other line is left out."""

FEWEST_LINES_IN_PART = 16
"""Smallest number of averaged lines in a part."""


@dataclass(frozen=True)
class PartOfData:
    """Part of the lines and channels, its description, and the lines within a peak needed to show a mode."""

    description: str
    lines: Lines
    least_lines: int = 0


def confirmed(measured: Measured, modes: Modes) -> Modes:
    """Refit parts of the data, starting from the poles found, and report which modes are found again.

    Parameters
    ----------
    measured : Measured
        FRFs that the modes were identified from.

    Returns
    -------
    Modes
        The same, with `confirmation`, and with the reason for it in `reason`.

    Raises
    ------
    ValueError
        If fewer than 8 lines are left.
    """
    lost: list[list[str]] = [[] for _ in modes.poles]
    tried = np.zeros(len(modes.poles), dtype=int)
    for part in _parts(measured, modes):
        expected = modes.real & _expected(part, modes)
        tried += expected
        found = _found_again(part.lines, modes)
        for j in np.flatnonzero(expected & ~found):
            lost[j].append(part.description)
    words = [
        ""
        if not real
        else f"; not found again {' nor '.join(gone)}"
        if gone
        else f"; found again in {count} of {count} refits"
        if count
        else "; no part of the data supports it alone"
        for real, gone, count in zip(modes.real, lost, tried, strict=True)
    ]
    verdicts = tuple(
        ("confirmed" if count and not gone else "unconfirmed") if real else ""
        for real, gone, count in zip(modes.real, lost, tried, strict=True)
    )
    reasons = tuple(why + word for why, word in zip(modes.reason, words, strict=True))
    return replace(modes, confirmation=verdicts, reason=reasons)


def weighed(measured: Measured, modes: Modes) -> Lines:
    """Return all lines used in the fit, weighted by the residual of the modes."""
    kept = measured.without(modes.left_out(measured.frequency))
    return kept.weighed(kept.h - modes.synthesis(kept.frequency), modes.poles)


def averaged_lines(measured: Measured, modes: Modes) -> Lines:
    """Average lines of the FRFs, or of their principal FRFs where they are many, weighted as in the fit.

    Parameters
    ----------
    measured : Measured
    modes : Modes
        Identified from them: their residual tells the weights.

    Returns
    -------
    Lines
    """
    if len(measured.h) > MANY:
        sums = principal_frfs(measured)
        measured, modes = sums.measured, sums.modes(modes)
    lines = weighed(measured, modes)
    prior = DampingPrior.estimated(modes.poles, np.sqrt(modes.covariance[:, 1, 1]), lines.band)
    return averaged(replace(lines, damping=prior))


def _parts(measured: Measured, modes: Modes) -> Iterator[PartOfData]:
    """Yield the band cut at either end, every second line, and every second FRF."""
    blocks = averaged_lines(measured, modes)
    f = blocks.frequency
    cut = SHIFT_OF_BAND * (f[-1] - f[0])
    low, high = f[0] + cut, f[-1] - cut
    yield from _part(blocks, f >= low, None, f"above {low:.4g} Hz")
    yield from _part(blocks, f <= high, None, f"below {high:.4g} Hz")
    place = np.arange(len(f))
    for half, which in enumerate(("first", "second")):
        description = f"on the {which} half of the lines, every other one"
        for part in _part(blocks, place % 2 == half, None, description):
            yield replace(part, least_lines=LINES_OF_PEAK)
    if len(measured.h) > 1:
        row = np.arange(len(measured.h))
        for half, which in enumerate(("first", "second")):
            rows, description = row % 2 == half, f"in the {which} half of the FRFs, every other one"
            if len(measured.h) > MANY:
                yield from _part(averaged_lines(measured.rows(rows), modes.of_rows(rows)), None, None, description)
            else:
                yield from _part(blocks, None, rows, description)


def _part(
    blocks: Lines, columns: NDArray[np.bool_] | None, rows: NDArray[np.bool_] | None, description: str
) -> Iterator[PartOfData]:
    """Yield these lines and rows, unless they are too few to be fitted."""
    columns = np.ones(len(blocks.frequency), bool) if columns is None else columns
    rows = np.ones(len(blocks.h), bool) if rows is None else rows
    if columns.sum() < FEWEST_LINES_IN_PART:
        return
    share = columns.mean() * rows.mean()
    lines = replace(
        blocks,
        frequency=blocks.frequency[columns],
        h=blocks.h[rows][:, columns],
        deviation=blocks.deviation[rows][:, columns],
        hidden=round(blocks.hidden * share),
        as_measured=blocks.grid,
    )
    yield PartOfData(description, lines)


def _expected(part: PartOfData, modes: Modes) -> NDArray[np.bool_]:
    """Modes that a part has to show, (J,): the peak is in it and BIC supports the mode by twice its penalty."""
    lines, place, half = part.lines, modes.poles.imag / (2.0 * np.pi), -modes.poles.real / (2.0 * np.pi)
    inside = (place - half > lines.frequency[0]) & (place + half < lines.frequency[-1])
    seen = (np.abs(lines.frequency - place[:, None]) <= half[:, None]).sum(axis=1) >= part.least_lines
    here = fit(lines, modes.poles, modes.terms, max_iterations=0)
    paid: NDArray[np.bool_] = inside & seen & (support(here, lines) > pole_penalty(lines))
    return paid


def _found_again(lines: Lines, modes: Modes) -> NDArray[np.bool_]:
    """Modes found again at the same place when part of the data is refitted with its own model order, (J,)."""
    start = fit(lines, modes.poles, modes.terms, tolerance=1e-3, max_iterations=10)
    poles = eliminate(lines, start).poles
    found = np.zeros(len(modes.poles), dtype=bool)
    free = list(range(len(poles)))
    for j in np.flatnonzero(modes.real):
        pole = modes.poles[j]
        near = [n for n in free if same_mode(pole, poles[n])]
        if near:
            found[j] = True
            free.remove(min(near, key=lambda n: abs(poles[n] - pole)))
    return found


def same_mode(one: complex, other: complex) -> bool:
    """Whether two poles, rad/s, differ by no more than `SAME_FREQUENCY` and `SAME_DAMPING` of the first."""
    zeta = -one.real / abs(one), -other.real / abs(other)
    close = abs(one.imag - other.imag) <= SAME_FREQUENCY * -one.real
    return close and abs(zeta[1] / zeta[0] - 1.0) <= SAME_DAMPING
