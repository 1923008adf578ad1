"""Start values of an orthotropic sheet's moduli and loss factors by direction, from one sweep.

Declared moduli of wood and laminates are known to some 20 %: resonances are a tenth off, ten of their widths, and
in another order. Data and twin are both broadened, by the same kernel over the lines
(`analysis.updating.start`), until resonances overlap; fits from a grid of moduli then follow the data to less
and less broadening. Every output has a real gain of its own, of either sign, which is eliminated.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.effect_card import EffectCard
from analysis.estimates import ACROSS, LOSS, MODULI, RATIOS, TRANSVERSE
from analysis.material import LocalLaws
from analysis.progress import Progress
from analysis.recordings.frf import Frf
from analysis.twin_model import TwinModel
from analysis.updating.normal_equations import SweepData
from analysis.updating.start import cauchy_kernel
from analysis.updating.update import middle_sweep, stride

BROADENINGS = (0.25, 0.12, 0.06, 0.03, 0.015, 0.0)
"""Loss factors added, one after the other: a fit at one ends within the widths of the next."""
SPACING = 0.1
"""Step of the centres of the kernel, in half-power widths, up to the number of the lines."""
MODULUS_STEP = 1.15
APART = (-0.35, 0.0, 0.35)
"""Logarithms of the ratio and of shear in the grid: 40 % either way."""
STARTS = 6
"""Number of points of the grid from which fits follow the data."""
GOOD = 0.15
"""Misfit, over the data's rms, at which no other start is tried."""
STEPS = 12
"""Largest number of iterations at one broadening."""
LONGEST = np.array([0.12, 0.05, 0.5, 0.12, 0.12, 0.4, 0.4, 0.5, 0.5])
"""Largest step of log E, nu, log eta and the logarithms `FOUND` in one iteration."""
FOUND = (*RATIOS, *ACROSS)
POISSON = 0.15
"""Standard deviation of nu about the middle of its range: at much broadening the data hardly see it."""


def sheet_start(frf: Frf, model: TwinModel, report: Progress) -> dict[str, dict[str, float]]:
    """Find the logarithms of an orthotropic sheet's moduli and losses by direction, near which a fit converges.

    Parameters
    ----------
    frf : Frf
        The middle sweep of the first input is used.
    model : TwinModel
        With the tolerances of the sheet.
    report : callable
        Called with a stage's name and the share of it done.

    Returns
    -------
    dict of str to dict
        Values of the sheet's quantities; empty if its moduli are held as declared.
    """
    cards = {name: card for name, card in model.tolerance_cards.items() if name in (MODULI, LOSS, TRANSVERSE)}
    if MODULI not in cards:
        return {}
    data = SweepData.of(frf, middle_sweep(frf), max(1, stride(frf, model.box) // 2))
    problem = _Problem.of(model, data, cards)
    best: Real | None = None
    least = np.inf
    starts = problem.starts()
    for done, start in enumerate(starts):
        report("moduli of the sheet", done / len(starts))
        found = start
        for loss in BROADENINGS:
            found, misfit = problem.broadened(loss).fitted(found)
        if misfit < least:
            best, least = found, misfit
        if least < GOOD:
            break
    report("moduli of the sheet", 1.0)
    return {} if best is None else problem.values(best)


@dataclass(frozen=True)
class _Problem:
    """One sweep's fit at one broadening; unknowns are log E, nu, log eta and the sheet's logarithms (3 + Q).

    Attributes
    ----------
    model : TwinModel
    data : SweepData
    kernel : (C, F) ndarray or None
        From lines to centres; None without broadening.
    wanted : (K, C) complex ndarray
        Data after it, each output over its rms.
    names : tuple of (str, str)
        The sheet's logarithms.
    low, high, centre, width : (3 + Q,) ndarray
        Ranges, and means and standard deviations of the priors.
    """

    model: TwinModel
    data: SweepData
    kernel: Real | None
    wanted: Complex
    names: tuple[tuple[str, str], ...]
    low: Real
    high: Real
    centre: Real
    width: Real

    @classmethod
    def of(cls, model: TwinModel, data: SweepData, cards: Mapping[str, EffectCard]) -> Self:
        parameters = {(name, p.name): p for name, card in cards.items() for p in card.parameters}
        names = tuple(pair for pair in FOUND if pair in parameters)
        box, chosen = model.box, [parameters[pair] for pair in names]
        ends = np.array([np.log(box.youngs_modulus), box.poisson_ratio, np.log(box.loss_factor)])
        inside = 1e-6 * (ends[:, 1] - ends[:, 0])
        spread = [10.0, POISSON, 2.0, *(p.sigma for p in chosen)]
        middle = [*ends.mean(axis=1), *(0.0 for _ in chosen)]
        return cls(
            model,
            data,
            None,
            _unit(data.h),
            names,
            np.array([*(ends[:, 0] + inside), *(p.low for p in chosen)]),
            np.array([*(ends[:, 1] - inside), *(p.high for p in chosen)]),
            np.array(middle),
            np.array(spread),
        )

    def broadened(self, loss_factor: float) -> Self:
        """Return the fit to data of a plate with a loss factor larger by `loss_factor`."""
        if not loss_factor:
            return replace(self, kernel=None, wanted=_unit(self.data.h))
        f = self.data.frequency
        count = int(np.ceil(np.log(f[-1] / f[0]) / (SPACING * loss_factor))) + 1
        centers = np.geomspace(f[0], f[-1], min(count, f.size))
        kernel = cauchy_kernel(f, centers, loss_factor)
        return replace(self, kernel=kernel, wanted=_unit(self.data.h @ kernel.T))

    def starts(self) -> list[Real]:
        """Points of the grid with the smallest misfits at the largest broadening, best first."""
        wide = self.broadened(BROADENINGS[0])
        moduli = np.arange(self.low[0], self.high[0] + np.log(MODULUS_STEP), np.log(MODULUS_STEP))
        ways = [APART if pair[0] == MODULI else (0.0,) for pair in self.names]
        points = []
        for e, *ratios in product(moduli, *ways):
            point = np.clip(np.array([e, *self.centre[1:3], *ratios]), self.low, self.high)
            points.append((wide.misfit(point), tuple(point)))
        return [np.array(point) for _, point in sorted(points)[:STARTS]]

    def values(self, at: Real) -> dict[str, dict[str, float]]:
        """Return the sheet's logarithms at a point, by quantity."""
        found: dict[str, dict[str, float]] = {}
        for (name, parameter), value in zip(self.names, at[3:], strict=True):
            found.setdefault(name, {})[parameter] = float(value)
        return found

    def misfit(self, at: Real) -> float:
        """Rms of what is left over that of the data, with the best gains."""
        laws = self._laws(at)
        return self._left(self._seen(self.model.frf(laws, self.data.frequency, self.values(at), self.data.point)))

    def fitted(self, start: Real) -> tuple[Real, float]:
        """Iterate from a start (3 + Q,) to the nearest minimum: return it and its misfit."""
        at, damping = start, 1e-3
        longest = np.array([*LONGEST[:3], *(LONGEST[3 + FOUND.index(pair)] for pair in self.names)])
        matrix, gradient, misfit = self._equations(at)
        for _ in range(STEPS):
            damped = matrix + damping * np.diag(np.diag(matrix))
            step = np.clip(np.linalg.solve(damped, gradient), -longest, longest)
            trial = np.clip(at + step, self.low, self.high)
            ahead = self._equations(trial)
            if ahead[2] < misfit:
                fallen, at, damping = misfit - ahead[2], trial, damping / 10.0
                matrix, gradient, misfit = ahead
                if fallen < 1e-3 * misfit:
                    break
            else:
                damping *= 10.0
                if damping > 1e4:
                    break
        return at, misfit

    def _laws(self, at: Real) -> LocalLaws:
        return self.data.laws((float(np.exp(at[0])), float(at[1]), float(np.exp(at[2]))))

    def _seen(self, lines: Complex) -> Complex:
        """Responses (..., F) after the kernel."""
        return lines if self.kernel is None else np.asarray(lines @ self.kernel.T)

    def _gains(self, seen: Complex) -> Real:
        """Best real gains (K,) of responses (K, C)."""
        return np.asarray((seen.conj() * self.wanted).real.sum(-1) / (np.abs(seen) ** 2).sum(-1))

    def _left(self, seen: Complex) -> float:
        rest = self.wanted - self._gains(seen)[:, None] * seen
        return float(np.sqrt(np.mean(np.abs(rest) ** 2) / np.mean(np.abs(self.wanted) ** 2)))

    def _equations(self, at: Real) -> tuple[Real, Real, float]:
        """Return normal equations with the gains eliminated and the priors added, and the misfit."""
        values = self.values(at)
        tangents = [(name, parameter, values[name]) for name, parameter in self.names]
        found = self.model.linearise(self._laws(at), self.data.frequency, values, self.data.point, tangents)
        seen = self._seen(found.transfer)
        slopes = self._seen(np.concatenate([found.by_material, found.by_parameter]))
        gains = self._gains(seen)
        rest = self.wanted - gains[:, None] * seen
        columns = gains[:, None] * slopes
        power = (np.abs(seen) ** 2).sum(-1)
        shares = (columns * seen.conj()).real.sum(-1) / power
        columns = columns - shares[:, :, None] * seen  # what a change of the gains does not do as well
        flat = columns.reshape(at.size, -1)
        scale = self.wanted.size / max(float((np.abs(rest) ** 2).sum()), 1e-12)
        weak = 1.0 / self.width**2
        matrix = scale * (flat @ flat.conj().T).real + np.diag(weak)
        gradient = scale * (flat.conj() @ rest.ravel()).real - weak * (at - self.centre)
        return matrix, gradient, self._left(seen)


def _unit(h: Complex) -> Complex:
    """Responses (K, C), each over its rms."""
    return np.asarray(h / np.sqrt(np.mean(np.abs(h) ** 2, axis=-1, keepdims=True)))
