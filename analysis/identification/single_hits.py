"""Modes that rest on one hit: FRFs estimated anew without each hit in turn (the jackknife; Tukey, 1958).

What a mode explains of averaged FRFs grows with the power of the hits that show it. Without hit i, of power
|F_i|^2, the share 1 - |F_i|^2 / sum |F|^2 of it is left, for any mode of the structure. A pole that one hit alone
shows, because a cable struck the plate or the hammer touched twice, keeps next to nothing; BIC, which sees the
average only, cannot tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.confirmation import averaged_lines
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes
from analysis.identification.order import pole_penalty, support
from analysis.identification.pole_search import fit
from analysis.identification.variable_projection import project

FEWEST_HITS = 3
"""Hits from which one may be left out: of two hits nobody knows which is right."""
RESTING_SHARE = 0.35
"""Share of the expected below which a mode rests on the hit left out. In 40 simulated tests of five hits, 200
strong modes that all show kept 1.06 and more, 37 weak ones (BIC 50 to 300) 0.97 and more; one that a single hit
shows keeps 0.004 at most."""


@dataclass(frozen=True)
class WithoutHit:
    """FRFs of a test without one hit.

    Attributes
    ----------
    name : str
        Of the hit left out: ``hit 3``.
    h : (L, F) complex ndarray
        Like those of all hits.
    share : float
        Of the drives' power that is left, 0 to 1.
    """

    name: str
    h: NDArray[np.complex128] = field(repr=False)
    share: float


def confirmed_by_hits(measured: Measured, without: Sequence[WithoutHit], modes: Modes) -> Modes:
    """Say which modes rest on one hit alone; they are unconfirmed.

    Parameters
    ----------
    measured : Measured
        FRFs of all hits, from which the modes were identified.
    without : sequence of WithoutHit
    modes : Modes

    Returns
    -------
    Modes
    """
    if len(without) < FEWEST_HITS or not modes.real.any():
        return modes
    left = left_without(measured, without, modes)
    worst = left.argmin(axis=0)
    rests = modes.real & (left.min(axis=0) < RESTING_SHARE)
    if not rests.any():
        return modes
    words = [
        f"; rests on {without[n].name} alone: without it {100 * max(share, 0.0):.0f} % of what is expected is left"
        if alone
        else ""
        for n, share, alone in zip(worst, left.min(axis=0), rests, strict=True)
    ]
    before = modes.confirmation or tuple("confirmed" if real else "" for real in modes.real)
    return replace(
        modes,
        confirmation=tuple("unconfirmed" if alone else one for one, alone in zip(before, rests, strict=True)),
        reason=tuple(why + word for why, word in zip(modes.reason, words, strict=True)),
    )


def left_without(measured: Measured, without: Sequence[WithoutHit], modes: Modes) -> NDArray[np.float64]:
    """Return what is left of each mode without each hit, as a share of what is expected, (H, J).

    Parameters
    ----------
    measured : Measured
        FRFs of all hits.
    without : sequence of WithoutHit
        H of them.
    modes : Modes
        J of them.

    Returns
    -------
    (H, J) ndarray
    """
    every = np.maximum(_explained(measured, modes), np.finfo(float).tiny)
    return np.array([_explained(replace(measured, h=one.h), modes) / every / one.share for one in without])


def _explained(measured: Measured, modes: Modes) -> NDArray[np.float64]:
    """Minus twice the logarithm of the likelihood that each pole saves, (J,), where the poles are.

    Residues are fitted anew: with those of all hits, what a false pole lacks here would be taken for noise.
    """
    lines = measured.without(modes.left_out(measured.frequency)).lines()
    here = project(lines, modes.poles, modes.terms, derivatives=False)
    fitted = replace(modes, residues=here.residues, coefficients=here.coefficients)
    blocks = averaged_lines(measured, fitted)
    return support(fit(blocks, modes.poles, modes.terms, max_iterations=0), blocks) + pole_penalty(blocks)
