"""The gap on data that took no part: effects and gain from one part of a campaign, tried on the rest."""

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.gap.fit import fit_gap
from analysis.gap.gap_fit import GapFit
from analysis.gap.misfit import relative_misfit
from analysis.gap.model import GapModel
from analysis.gap.sweeps import GapSweeps
from analysis.gap.thresholds import HELD_OUT_SHARE, Z_FLOOR

LEAST_TEMPERATURES = 4
"""Below, every second temperature leaves too few to learn an effect from."""
FREQUENCY_BLOCKS = 12


@dataclass(frozen=True)
class HeldOut:
    """Before and after on held-out data.

    Attributes
    ----------
    what : str
        Which data.
    baseline_chi2, final_chi2 : float
        Of all lines held out.
    dof : float
    baseline_misfit, final_misfit : float
        rms|H_data - H_twin| / rms|H_data|.
    closure : float or None
        1 - (final - dof) / (baseline - dof), within 0 and 1; None where there was no gap to close.
    """

    what: str
    baseline_chi2: float
    final_chi2: float
    dof: float
    baseline_misfit: float
    final_misfit: float
    closure: float | None

    @property
    def holds(self) -> bool:
        """Whether what was learnt elsewhere helps here: it leaves noise, or closes enough of the gap.

        A gap of a few standard deviations closes by anything from nothing to all, for its own size is noise.
        """
        if self.final_chi2 >= self.baseline_chi2:
            return False
        quiet = self.final_chi2 - self.dof <= Z_FLOOR * float(np.sqrt(2.0 * self.dof))
        return quiet or self.closure is None or self.closure >= HELD_OUT_SHARE


def held_out(
    model: GapModel, sweeps: GapSweeps, baseline: GapFit, final: GapFit, executor: Executor, significant: float
) -> HeldOut:
    """Fit effects and gain to a part of the data, and compare both twins on the rest.

    Temperatures and levels held out have their own laws fitted, nothing else; channels and frequencies held out
    are predicted outright. A gap of less than `significant` chi2 over the noise is none.
    """
    what, learn, test, laws_free = split(sweeps)
    results = []
    for whole in (baseline, final):
        names = tuple(whole.state.effects)
        groups, places = _kept(sweeps, learn)
        taught = fit_gap(model, learn, whole.state.restricted(groups, places), names, executor)
        if laws_free:
            groups, places = _kept(sweeps, test)
            begin = whole.state.restricted(groups, places)
        else:
            begin = taught.state
        begin = replace(begin, log_gain=taught.state.log_gain, effects=taught.state.effects)
        tried = fit_gap(model, test, begin, (), executor, gain_free=False, laws_free=laws_free)
        results.append((tried, relative_misfit(test, tried)))
    (before, before_misfit), (after, after_misfit) = results
    gap = before.total - before.dof
    closure = float(np.clip(1.0 - (after.total - after.dof) / gap, 0.0, 1.0)) if gap > significant else None
    chi2, dof = test.between
    return HeldOut(
        what, before.total + chi2, after.total + chi2, after.dof + dof, before_misfit, after_misfit, closure
    )


def split(sweeps: GapSweeps) -> tuple[str, GapSweeps, GapSweeps, bool]:
    """Which data to learn from and which to hold out, and whether laws are to be fitted to these."""
    count = len(sweeps.groups.reference)
    if count >= LEAST_TEMPERATURES:
        even, odd = list(range(0, count, 2)), list(range(1, count, 2))
        return "every second temperature", sweeps.only_groups(even), sweeps.only_groups(odd), True
    shape = sweeps.rows.shape
    if len(sweeps.channels) > 1:
        last = np.zeros(shape, dtype=bool)
        last[:, -1] = True
        return f"channel {sweeps.channels[-1]}", sweeps.masked(~last), sweeps.masked(last), False
    levels = sorted({p.level for p in sweeps.points})
    if len(levels) > 1:
        high = [s for s in range(sweeps.count) if sweeps.points[s].level == levels[-1]]
        low = [s for s in range(sweeps.count) if s not in high]
        return f"level {levels[-1]:g} V", sweeps.only(low), sweeps.only(high), True
    block = np.arange(shape[-1]) * FREQUENCY_BLOCKS // shape[-1]
    odd_blocks: NDArray[np.bool_] = np.broadcast_to(block % 2 == 1, shape)
    return "every second twelfth of the band", sweeps.masked(~odd_blocks), sweeps.masked(odd_blocks), False


def _kept(whole: GapSweeps, part: GapSweeps) -> tuple[Sequence[int], Sequence[int]]:
    """Return groups and sweeps of `part`, by their places in `whole`."""
    places = part.original_places(whole)
    return np.unique(whole.groups.of_sweep[places]).tolist(), places
