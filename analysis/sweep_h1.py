"""H1 of one recorded sweep at all outputs, repeats that stray left out."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from analysis.campaign import Sweep
from analysis.h1 import bad_repeats, h1_of_spectra, repeats_dof, spectra
from analysis.local_rational import rough_power
from analysis.noise_power import noise_power
from analysis.repeat_shift import repeat_shift


class SweepH1(NamedTuple):
    """H1 of one sweep at all outputs.

    Attributes
    ----------
    h, variance, coherence : (K, F) ndarray
        As in `analysis.frf.Frf`.
    repeats_dof : int
        Degrees of freedom of the variance at a line, before it is averaged over neighbouring lines.
    shift : float
        See `analysis.repeat_shift`.
    notes : list of str
        One for every repeat left out.
    """

    h: NDArray[np.complex128]
    variance: NDArray[np.float64]
    coherence: NDArray[np.float64]
    repeats_dof: int
    shift: float
    notes: list[str]


def sweep_h1(sweep: Sweep, lines: slice, excluded: NDArray[np.bool_], names: Sequence[str]) -> SweepH1:
    """H1, its variance and the coherence of one sweep.

    Parameters
    ----------
    lines : slice
        Of the spectrum, that are wanted.
    excluded : (F,) bool ndarray
        Lines that say nothing of the noise.
    names : sequence of str
        Of the outputs.

    Raises
    ------
    ValueError
        Where too few repeats are left.
    """
    h_rows, variance_rows, coherence_rows = [], [], []
    u, answers = spectra(sweep.drive)[:, lines], spectra(sweep.responses)[..., lines]
    bad = {r: name for name, y in zip(names, answers, strict=True) for r in bad_repeats(u, y)}
    good = [r for r in range(len(u)) if r not in bad]
    notes = [f"step {sweep.step}: repeat {r + 1} left out, {name} strays" for r, name in bad.items()]
    if len(good) < 2 <= len(u):
        raise ValueError(f"sweep {sweep.step}: repeats {sorted(r + 1 for r in bad)} stray; too few are left")
    drive = (np.abs(u[good]) ** 2).sum(0)
    for y in answers:
        h, power, coherence = h1_of_spectra(u[good], y[good])
        if len(good) == 1:
            power = rough_power(h)
        h_rows.append(h)
        # the noise of the signals is smooth over frequency; divided by a drive that dips at resonances it is not
        variance_rows.append(noise_power(power * drive, h, excluded) / (len(good) * drive))
        coherence_rows.append(np.clip(coherence, 0.0, 1.0))
    shift = repeat_shift(answers[:, good] / u[good], lines.start)
    return SweepH1(
        np.array(h_rows), np.array(variance_rows), np.array(coherence_rows), repeats_dof(len(good)), shift, notes
    )
