"""Held-out data: effects and gain fitted to one part of a campaign, tested on the rest."""

from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.fit import SETTLED_FAR_ALONE, fit_gap
from analysis.gap.fitting.gap_fit import GapFit, relative_misfit
from analysis.gap.thresholds import FAR, HELD_OUT_SHARE, SETTLED, SETTLED_AT_FEW, Z_FLOOR
from analysis.twin_model import TwinModel

LEAST_TEMPERATURES = 4
"""Fewest temperatures for holding out every second: with fewer, an effect cannot be fitted to the rest."""
FREQUENCY_BLOCKS = 12


@dataclass(frozen=True)
class HeldOut:
    """Agreement with held-out data, without and with the effects.

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
    closure_sigma : float or None
        Its standard deviation by noise.
    gain : float or None
        Log probability of the held-out data with the effects, over that without, each beside its discrepancy,
        nats; None beside noise alone.
    """

    what: str
    baseline_chi2: float
    final_chi2: float
    dof: float
    baseline_misfit: float
    final_misfit: float
    closure: float | None
    closure_sigma: float | None
    gain: float | None = None

    @property
    def holds(self) -> bool:
        """Whether what was learnt elsewhere helps here: it leaves noise, or closes enough of the gap.

        The closure of a gap of a few standard deviations is not defined: the size of that gap is itself noise.
        """
        if self.final_chi2 >= self.baseline_chi2:
            return False
        quiet = self.final_chi2 - self.dof <= Z_FLOOR * float(np.sqrt(2.0 * self.dof))
        return quiet or self.closure is None or self.closure >= HELD_OUT_SHARE


@dataclass(frozen=True)
class Split:
    """A campaign in two parts, one to fit, one to test.

    Attributes
    ----------
    what : str
        Which data are held out.
    learn, test : GapSweeps
    laws_free : bool
        Whether the held-out data have laws of their own to be fitted.
    """

    what: str
    learn: GapSweeps
    test: GapSweeps
    laws_free: bool


def held_out(
    model: TwinModel,
    sweeps: GapSweeps,
    split: Split,
    baseline: GapFit,
    final: GapFit,
    executor: Executor,
    significant: float,
) -> HeldOut:
    """Fit effects and gain to a part of the data, and compare the twins without and with effects on the rest.

    On held-out temperatures and levels only the laws are fitted; held-out channels and frequencies
    are predicted outright. A gap of less than `significant` chi2 over the noise is none. Where the
    learnt effects leave the certified range of the twin, the closure is 0.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
        All data.
    split : Split
        The data to learn from and the data to test on.
    baseline : GapFit
        Without effects.
    final : GapFit
        With the effects found.
    executor : Executor
        Sweeps are linearised on it.
    significant : float
        Smallest excess of chi2 that counts as a gap.

    Returns
    -------
    HeldOut
    """
    before = fit_and_try(model, sweeps, split, baseline, executor)
    try:
        after = fit_and_try(model, sweeps, split, final, executor)
    except ValueError:
        after = before
    gap = before.total - before.dof
    closure, sigma = None, None
    if gap > significant:
        closure = float(np.clip(1.0 - (after.total - after.dof) / gap, 0.0, 1.0))
        sigma = closure_deviation(closure, gap, before.dof)
    chi2, dof = split.test.between
    return HeldOut(
        what=split.what,
        baseline_chi2=before.total + chi2,
        final_chi2=after.total + chi2,
        dof=after.dof + dof,
        baseline_misfit=relative_misfit(split.test, before),
        final_misfit=relative_misfit(split.test, after),
        closure=closure,
        closure_sigma=sigma,
    )


def closure_deviation(closure: float, gap: float, dof: float) -> float:
    """Return the standard deviation of a closure by noise, to first order.

    chi2 is |s + n|^2 before and |r + n|^2 after, with noise n. Effects fitted by least squares take away a part of
    s at right angles to the rest r. n moves the ratio of the excesses by its square, whose variance is 2 dof and
    which is common to both, and by its products with s and r.

    Parameters
    ----------
    closure : float
        0 to 1.
    gap : float
        Excess of chi2 over `dof` before.
    dof : float

    Returns
    -------
    float
    """
    return float(np.sqrt(closure * (2.0 * dof * closure + 4.0 * gap * (1.0 - closure)))) / gap


def fit_and_try(model: TwinModel, sweeps: GapSweeps, split: Split, whole: GapFit, executor: Executor) -> GapFit:
    """Fit a twin to the data to learn from, and return it on the data held out.

    Parameters
    ----------
    model : TwinModel
    sweeps : GapSweeps
        All data.
    split : Split
    whole : GapFit
        To all data, from which the fit starts.
    executor : Executor
        Sweeps are linearised on it.

    Returns
    -------
    GapFit
        Effects, gains and declared quantities are those learnt, and laws too unless `split.laws_free`.

    Raises
    ------
    ValueError
        Where what was learnt leaves the certified range of the twin.
    """
    # of a gap of thousands of sigma, a tenth is enough to say what share of it effects close
    far = not whole.state.effects and whole.total > (1.0 + FAR) * whole.dof
    target = SETTLED_FAR_ALONE * split.test.numbers if far else SETTLED
    start, effects = whole.state.restricted(sweeps, split.learn), tuple(whole.state.effects)
    taught = fit_gap(model, split.learn, start, effects, executor, target=SETTLED_AT_FEW, declared_free=not far)
    begin = taught.state
    if split.laws_free:
        begin = whole.state.restricted(sweeps, split.test)
    learnt = taught.state
    begin = replace(begin, log_gain=learnt.log_gain, effects=learnt.effects, declared=learnt.declared)
    return fit_gap(
        model, split.test, begin, (), executor, gain_free=False, laws_free=split.laws_free, target=target
    )


def splits(sweeps: GapSweeps) -> list[Split]:
    """All splits into data to fit and data held out; the first one decides.

    A level is held out only where two are left: from one level amplitude softening cannot be identified.
    """
    found = []
    count = len(sweeps.groups.reference)
    if count >= LEAST_TEMPERATURES:
        even, odd = list(range(0, count, 2)), list(range(1, count, 2))
        found.append(
            Split("every second temperature", sweeps.only_groups(even), sweeps.only_groups(odd), laws_free=True)
        )
    shape = sweeps.rows.shape
    if len(sweeps.channels) > 1:
        last = np.zeros(shape, dtype=bool)
        last[:, -1] = True
        name = f"channel {sweeps.channels[-1]}"
        found.append(Split(name, sweeps.masked(~last), sweeps.masked(last), laws_free=False))
    levels = sweeps.levels
    top = {source: max(its) for source, its in levels.items() if len(its) > (2 if found else 1)}
    if top:
        high = [s for s, p in enumerate(sweeps.points) if p.level == top.get(p.source)]
        low = [s for s in range(sweeps.count) if s not in high]
        what = f"level {sweeps.drives[high[0]]}" if len(levels) == 1 else "highest level of each actuator"
        found.append(Split(what, sweeps.only(low), sweeps.only(high), laws_free=True))
    if not found:
        block = np.arange(shape[-1]) * FREQUENCY_BLOCKS // shape[-1]
        odd_blocks: NDArray[np.bool_] = np.broadcast_to(block % 2 == 1, shape)
        what = "every second twelfth of the band"
        found.append(Split(what, sweeps.masked(~odd_blocks), sweeps.masked(odd_blocks), laws_free=False))
    return found
