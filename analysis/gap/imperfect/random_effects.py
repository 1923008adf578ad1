"""Evidence of effects beside modes that scatter, on a campaign linearised once.

Joints, coupled air, strings and humidity change the frequency, the damping and the residue of every mode a little:
random effects of a linear mixed model. With relative shifts a of its frequency, changes b of its half loss factor
and c of its residue in each channel, the part H_k of a mode with pole p_k is off by

    -2 (a + i b) p_k / (p_k - w^2) H_k + c H_k,

alike in all sweeps, but for a part that is proportional to temperature. Their variances are those of maximum
evidence, for each set of effects by itself (type-II maximum likelihood); with everything that is fitted they are
integrated out (Woodbury), so that a set of effects is compared by what its modes still scatter by, and pays for
every unknown that the data determine better than before.

What a, b and c leave is an error of the nodes, as a share of the mean response around them. Nodes within half the
width of a resonance share it, and all sweeps do: so many numbers tell as much as one.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.ndimage import uniform_filter1d
from scipy.optimize import minimize

from analysis.arrays import Complex, Real
from analysis.effect_card import Parameter, Values
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.linearised_sweeps import LinearisedSweeps
from analysis.gap.fitting.normal_equations import GLOBAL
from analysis.gap.fitting.schur_complement import LocalStep, law_columns, local_priors
from analysis.gap.fitting.state import GapState, clipped_laws
from analysis.gap.imperfect.discrepancy import LARGEST, Discrepancy
from analysis.gap.thresholds import NODES_PER_HALF_WIDTH
from analysis.twin_model import ModalParts

WITH_TEMPERATURE, SPAN = 0.3, 30.0
"""Standard deviation of the part of a mode's error that is proportional to temperature, over that of the whole, at
a distance of `SPAN`, K, from the mean: a foundation that does not soften with the plate does as much."""

FINENESS = 1.5
"""Ratio of neighbouring errors of the nodes that are tried; a parabola through the evidence of three gives its
maximum."""

CLOSE = 0.05
"""Nats, and changes of logarithms, at which the search for the variances of modes ends."""

ABOVE_LEAST = 3.0
"""Times the least standard deviation above which modes count as scattered: where they are not, it is found as that
least one, and they are told from it by a factor of two with ten modes."""

REWEIGHTED = 3
"""Largest number of times that priors are taken with the width that they have where the last solution ended."""

RIDGE, STEEPER = 1e-12, 1e3
"""Ridge relative to a unit diagonal, for material constants that no line depends on, and how many times larger it
is where rounding has left a matrix without a factor."""

MOST_KEPT = 5e7
"""Numbers of normal equations that are kept for further sets, 0.8 GB: a laser scan has many channels."""


@dataclass(frozen=True)
class JudgedSet:
    """What a set of effects comes to.

    Attributes
    ----------
    evidence : float
        Log evidence, up to a constant common to all sets on the same sweeps and modes, nats.
    values : tuple of float
        Of the amplitudes of the effect that was added.
    modes : (3,) ndarray
        Logarithms of the scatter of frequencies, half loss factors and residues.
    place : int
        Index of the error of the nodes.
    """

    evidence: float
    values: tuple[float, ...]
    modes: Real
    place: int

    @property
    def scatter(self) -> Discrepancy:
        """Standard deviations of a, b and c."""
        return Discrepancy(*np.exp(self.modes).tolist())


@dataclass(frozen=True)
class _Unknown:
    """One parameter: its column, its card, its value where the campaign was linearised."""

    column: int
    card: Parameter
    value: float


@dataclass(frozen=True)
class _Set:
    """Parameters that are fitted, and those of effects that are left out, or held at a value."""

    fitted: tuple[_Unknown, ...]
    names: tuple[str, ...]
    added: int
    absent: tuple[tuple[int, float], ...] = ()

    def held(self, place: int, value: float) -> "_Set":
        """Return the set with a parameter held at a value."""
        one = self.fitted[place]
        rest = (*self.fitted[:place], *self.fitted[place + 1 :])
        return replace(self, fitted=rest, absent=(*self.absent, (one.column, one.value - value)))


@dataclass(frozen=True)
class _Level:
    """Normal equations at one error of the nodes, over the Q local and common unknowns, and the residual last.

    Attributes
    ----------
    matrix : (Q, Q) ndarray
    by_residue : (K, 2M, Q + 4M) complex ndarray
        Of every mode's residue in every channel, steady and with temperature, by these and by all a and b.
    residues : (K, 2M, 2M) complex ndarray
        Of the residues themselves.
    by_pole : (4M, Q) ndarray
        Of every mode's a and b, steady, and with temperature, by the Q unknowns.
    poles : (4M, 4M) ndarray
    penalty : float
        Minus twice the log evidence of the error itself, beside that of the weighted fit.
    """

    matrix: Real
    by_residue: Complex
    residues: Real
    by_pole: Real
    poles: Real
    penalty: float


@dataclass(frozen=True)
class RandomEffects:
    """Evidence of sets of effects that differ by one or two from those that are on in a linearised campaign.

    Attributes
    ----------
    linear : LinearisedSweeps
    sweeps : GapSweeps
        Unweighted.
    parts : tuple of ModalParts
        Of every sweep, where it was linearised, at the nodes.
    """

    linear: LinearisedSweeps
    sweeps: GapSweeps
    parts: tuple[ModalParts, ...] = field(repr=False)
    _levels: dict[int, _Level] = field(repr=False, default_factory=dict)
    _marginals: dict[tuple[float, ...], tuple[Real, float]] = field(repr=False, default_factory=dict)
    """Equations of all columns without the random effects, at the error and scatter that were screened last."""

    @classmethod
    def of(cls, linear: LinearisedSweeps, sweeps: GapSweeps) -> Self:
        """Ask the twin for its modes where the campaign was linearised."""
        state, laws = linear.state, sweeps.smoothness.laws(linear.state.laws)
        model = linear.model.counted(laws, state.on)
        points = [state.circumstances(s, one) for s, one in enumerate(sweeps.points)]
        found = tuple(
            model.modal_parts(laws[group], sweeps.nodes.frequency, state.on, point)
            for group, point in zip(sweeps.groups.of_sweep, points, strict=True)
        )
        heard = sweeps.heard
        return cls(linear, sweeps, tuple(one.only_channels(heard) for one in found) if heard else found)

    def here(self) -> JudgedSet:
        """Judge the effects that are on."""
        return self._best(self._set(), None)

    def scatters(self, found: JudgedSet) -> bool:
        """Whether modes are off by more than what the twin's own error makes of them."""
        return bool((found.modes > self._least + np.log(ABOVE_LEAST)).any())

    def without(self, names: Collection[str], near: JudgedSet) -> JudgedSet:
        """Judge the effects that are on but some."""
        return self._best(self._set(names), near)

    def screened(self, name: str, site: Values, near: JudgedSet, left_out: Collection[str] = ()) -> JudgedSet:
        """Judge one effect more, at a site, at the scatter that another set leaves."""
        at = near.place, *near.modes.tolist()
        if at not in self._marginals:  # common to all effects and sites
            level = self._level(near.place)
            self._marginals.clear()
            self._marginals[at] = self._marginal(level, np.arange(len(level.matrix)), near.modes)
        return self._inside(self._set(left_out, (name, site)), near.modes, near.place)

    def with_effect(self, name: str, site: Values, near: JudgedSet, left_out: Collection[str] = ()) -> JudgedSet:
        """Judge one effect more, at a site; `left_out`: instead of others."""
        return self._best(self._set(left_out, (name, site)), near)

    def moved(self, near: JudgedSet) -> GapState:
        """Return the likeliest state with the effects that are on, to first order, at the scatter of `near`."""
        state, sweeps, left = self.linear.state, self.sweeps, len(self._local[0])
        wanted = self._set()
        _, found, step = self._bounded(wanted, near.modes, near.place)
        local, gains = LocalStep.of(step[:left], self._own, len(sweeps.groups.size)), step[left:]
        tilt, bend = sweeps.smoothness.deviations(local.errors)
        log_gain = state.log_gain.copy()
        log_gain[self._driven] += gains
        values = {name: dict(one) for name, one in state.on.items()}
        for k, (unknown, name) in enumerate(zip(wanted.fitted, wanted.names, strict=True)):
            card = unknown.card
            values[name][card.name] = float(np.clip(found[k], card.low, card.high))
        moved = replace(
            state,
            laws=clipped_laws(self.linear.box, state.laws + local.laws),
            tilt=state.tilt + tilt,
            bend=state.bend + bend,
            away=state.away + local.away,
            log_gain=log_gain,
        )
        return moved.with_values(values)

    def _set(self, left_out: Collection[str] = (), added: tuple[str, Values] | None = None) -> _Set:
        state, cards = self.linear.state, {**self.linear.tolerance_cards, **self.linear.model.cards}
        fitted, names, absent = [], [], []
        for name, values in state.on.items():
            for card in cards[name].parameters:
                column = self.linear.column((name, card.name, values)) - GLOBAL
                if name not in left_out:
                    fitted.append(_Unknown(column, card, values[card.name]))
                    names.append(name)
                elif not card.shape:
                    absent.append((column, values[card.name]))
        count = len(fitted)
        if added:
            name, site = added
            for card in cards[name].amplitudes:
                column = self.linear.column((name, card.name, cards[name].zero(site))) - GLOBAL
                fitted.append(_Unknown(column, card, 0.0))
                names.append(name)
        return _Set(tuple(fitted), tuple(names), len(fitted) - count, tuple(absent))

    def _best(self, wanted: _Set, near: JudgedSet | None) -> JudgedSet:
        """Find the variances of maximum evidence, from those of another set."""
        tried: dict[int, JudgedSet] = {}

        def at(place: int, start: Real) -> JudgedSet:
            if place not in tried:
                begun: Real = np.maximum(start, self._least)
                bounds = [(float(least), float(np.log(LARGEST))) for least in self._least]

                def unlikely(logs: Real) -> float:
                    return -self._bounded(wanted, logs, place)[0]

                best = minimize(unlikely, begun, method="Nelder-Mead", bounds=bounds, tol=CLOSE)
                tried[place] = self._inside(wanted, best.x, place)
            return tried[place]

        if near is None:
            near = JudgedSet(0.0, (), np.maximum(np.log([1e-3, 1e-3, 1e-2]), self._least), 5)
        best = at(near.place, near.modes)
        while True:
            sides = [at(place, best.modes) for place in (best.place - 1, best.place + 1) if self._allowed(place)]
            better = max(sides, key=lambda one: one.evidence)
            if better.evidence <= best.evidence:
                break
            best = better
        if len(sides) < 2:
            return best
        low, high = (one.evidence - best.evidence for one in sides)
        return replace(best, evidence=best.evidence - (low - high) ** 2 / (8.0 * min(low + high, -1e-9)))

    def _allowed(self, place: int) -> bool:
        return place >= 0 and self.sweeps.twin_error * FINENESS**place <= LARGEST

    def _inside(self, wanted: _Set, logs: Real, place: int) -> JudgedSet:
        evidence, values, _ = self._bounded(wanted, logs, place)
        first = len(wanted.fitted) - wanted.added
        return JudgedSet(evidence, tuple(values[first:].tolist()), logs, place)

    def _bounded(self, wanted: _Set, logs: Real, place: int) -> tuple[float, Real, Real]:
        """Log evidence with amplitudes inside their ranges, their values, and the step of other unknowns."""
        held: dict[int, float] = {}
        while True:
            part = wanted
            for k in sorted(held, reverse=True):
                part = part.held(k, held[k])
            evidence, step = self._evidence(part, logs, place)
            free = [k for k in range(len(wanted.fitted)) if k not in held]
            first, values = len(step) - len(free), np.empty(len(wanted.fitted))
            values[free] = [one.value for one in part.fitted] + step[first:]
            values[list(held)] = list(held.values())
            outside = {
                k: float(np.clip(values[k], card.low, card.high))
                for k in free
                for card in [wanted.fitted[k].card]
                if not (card.shape or card.declared or card.low <= values[k] <= card.high)
            }
            if not outside:
                break
            held |= outside
        evidence -= 0.5 * sum(wanted.fitted[k].card.penalty(value) for k, value in held.items())
        return evidence, values, step[:first]

    def _evidence(self, wanted: _Set, logs: Real, place: int) -> tuple[float, Real]:
        """Log evidence at some variances, and the step of all unknowns."""
        level, left = self._level(place), len(self._local[0])
        gone = [left + column for column, _ in wanted.absent]
        used = [*range(left), *(left + self._driven), *(left + one.column for one in wanted.fitted)]
        columns, count = np.array([*used, *gone, len(level.matrix) - 1]), len(used)
        shared = self._marginals.get((place, *logs.tolist()))
        if shared is None:
            reduced, spread = self._marginal(level, columns, logs)
        else:
            reduced, spread = shared[0][np.ix_(columns, columns)], shared[1]
        back = np.array([*np.zeros(count), *(value for _, value in wanted.absent), 1.0])
        matrix, pull, chi2 = reduced[:count, :count], reduced[:count] @ back, float(back @ reduced @ back)
        whole = np.maximum(np.diag(level.matrix)[used], 1e-300)
        now, known = self._local
        free = np.zeros(len(self._driven))
        values = np.array([one.value for one in wanted.fitted])
        cards = [one.card for one in wanted.fitted]
        centre = np.array([card.centre for card in cards])
        found = values
        for _ in range(REWEIGHTED):
            precision = np.array([c.precision(v) for c, v in zip(cards, found.tolist(), strict=True)])
            priors = np.concatenate([known, free, precision])
            away = np.concatenate([now, free, values - centre])
            scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), RIDGE * whole) + priors)
            unit = (matrix + np.diag(priors)) * scale[:, None] * scale
            lower = _factor(unit)
            right = scale * (pull - priors * away)
            step = scale * cho_solve(lower, right)
            found = values + step[len(step) - len(values) :]
            if all(c.precision(v) == p for c, v, p in zip(cards, found.tolist(), precision, strict=True)):
                break
        total = chi2 + float(priors @ away**2) - float((right / scale) @ step)
        normal = precision * (found - centre) ** 2
        total += float(sum(c.penalty(v) for c, v in zip(cards, found.tolist(), strict=True)) - normal.sum())
        diagonal = np.log(np.diag(lower[0]) / scale)
        # the laws of all temperatures are known alike well relative to each other, whatever their common error
        laws = 2.0 * float((np.log(np.diag(_factor(unit[:left, :left])[0])) - np.log(scale[:left])).sum())
        groups = len(self.sweeps.groups.size)
        volume = 2.0 * float(diagonal.sum()) - (1.0 - 1.0 / groups) * laws
        prior = 2.0 * float(sum(np.log(card.sigma) for card in cards))
        return -0.5 * (total + volume + prior + spread + level.penalty), step

    def _marginal(self, level: _Level, columns: NDArray[np.int_], logs: Real) -> tuple[Real, float]:
        """Integrate over the random effects: equations of some columns without them, and their log determinant."""
        a, b, c = np.exp(logs)
        with_temperature, modes, size = np.array([1.0, WITH_TEMPERATURE]), self._modes, len(level.matrix)
        root = np.repeat(np.sqrt(0.5) * c * with_temperature, modes)
        factor = np.linalg.cholesky(np.eye(2 * modes) + root[:, None] * level.residues * root)
        by_residue = level.by_residue[..., [*columns, *range(size, size + 4 * modes)]]
        residue = np.linalg.solve(factor, root[:, None] * by_residue)
        spread = 4.0 * float(np.log(np.diagonal(factor, axis1=-2, axis2=-1).real).sum())  # of both parts
        flat = _real(np.asarray(np.moveaxis(residue, -1, 0), complex))
        products, first = flat @ flat.T, len(columns)
        taken, turned, own = products[:first, :first], products[first:, :first], products[first:, first:]
        root = np.repeat(np.outer(with_temperature, [a, b]).ravel(), modes)
        lower = cho_factor(np.eye(4 * modes) + root[:, None] * (level.poles - own) * root, lower=True)
        solved = solve_triangular(lower[0], root[:, None] * (level.by_pole[:, columns] - turned), lower=True)
        spread += 2.0 * float(np.log(np.diag(lower[0])).sum())
        return level.matrix[np.ix_(columns, columns)] - taken - solved.T @ solved, spread

    @cached_property
    def _local(self) -> tuple[Real, Real]:
        return local_priors(self.sweeps, self.linear.state, self._own)

    @cached_property
    def _own(self) -> Real:
        return law_columns(self.sweeps, self.linear.state)

    @cached_property
    def _driven(self) -> NDArray[np.int_]:
        """Inputs that drove a sweep: their gains are fitted."""
        return np.unique([point.source for point in self.sweeps.points])

    @cached_property
    def _least(self) -> Real:
        """Logarithms of the least variances: what the twin's own error makes of a resonance."""
        half = 0.5 * float(np.exp(self.linear.state.laws[:, 2].mean()))
        return np.asarray(np.log(self.sweeps.twin_error * np.array([half, half, 1.0])))

    @cached_property
    def _modes(self) -> int:
        return max(len(one.poles) for one in self.parts)

    @cached_property
    def _patterns(self) -> list[list[Complex]]:
        """Whitened derivatives by a, and parts, of all modes in every sweep, (M, K, n) each."""
        found = []
        for s, (one, parts) in enumerate(zip(self.sweeps.compressed, self.parts, strict=True)):
            gain = float(np.exp(self.linear.state.log_gain[self.sweeps.points[s].source]))
            missing = ((0, self._modes - len(parts.poles)), (0, 0), (0, 0))
            both = (gain * one.whitened(self.sweeps.nodes.coefficients(p)) for p in (parts.by_pole, parts.parts))
            found.append([np.pad(pattern, missing) for pattern in both])
        return found

    @cached_property
    def _strength(self) -> list[Real]:
        """Mean square of a part of the whitened response around each node of every sweep, (K, n) each."""
        width, found = round(4.0 * NODES_PER_HALF_WIDTH), []
        for s, white in enumerate(self.linear.white):
            whole = self.sweeps.compressed[s].whitened(white.predicted)
            found.append(0.5 * uniform_filter1d(np.abs(whole) ** 2, width, axis=-1, mode="nearest"))
        return found

    @cached_property
    def _warm(self) -> Real:
        """Distance of every sweep from the mean temperature, in units of `SPAN`, (T,)."""
        state, points = self.linear.state, self.sweeps.points
        temperature = np.array([state.circumstances(s, one).temperature for s, one in enumerate(points)])
        return np.asarray((temperature - temperature.mean()) / SPAN)

    def _level(self, place: int) -> _Level:
        found = self._levels.get(place)
        if found is None:
            kept = sum(one.by_residue.size for one in self._levels.values())
            if kept > MOST_KEPT:
                self._levels.pop(max(self._levels, key=lambda other: abs(other - place)))
            found = self._levels[place] = self._formed(self.sweeps.twin_error * FINENESS**place)
        return found

    def _formed(self, error: float) -> _Level:
        """Form the normal equations for an `error` of the nodes, a share of the mode's mean response."""
        sweeps, modes = self.sweeps, self._modes
        together = NODES_PER_HALF_WIDTH * sweeps.count
        own, local, rows = self._own, self._own.shape[2], len(self.linear.white[0].white)
        channels, size = len(sweeps.channels), local + rows - GLOBAL
        matrix, penalty = np.zeros((size, size)), 0.0
        by_residue = np.zeros((channels, 2 * modes, size + 4 * modes), complex)
        residues = np.zeros((channels, 2 * modes, 2 * modes), complex)
        by_pole, poles = np.zeros((4 * modes, size)), np.zeros((4 * modes, 4 * modes))
        for s, white in enumerate(self.linear.white):
            shared = together * error**2 * self._strength[s]
            weight = sweeps.rows[s] / np.sqrt(1.0 + shared)
            gone = np.log1p(shared) / together - (1.0 - 1.0 / together) / (1.0 + shared)
            penalty += 2.0 * float(gone[sweeps.rows[s]].sum())
            weighted, warm = white.white * weight, np.array([1.0, self._warm[s]])
            shift, part = (weight * pattern for pattern in self._patterns[s])
            real = _real(weighted)
            matrix += _spread(_spread(real @ real.T, own[s]).T, own[s])
            turns = _real(np.concatenate([shift, 1j * shift]))
            by_pole += np.kron(warm[:, None], _spread(turns @ real.T, own[s]))
            poles += np.kron(np.outer(warm, warm), turns @ turns.T)
            for k in range(channels):
                heard = part[:, k].conj()
                residue = _spread(heard @ weighted[:, k].T, own[s])
                mixed = heard @ shift[:, k].T
                mixed = np.kron(warm, np.concatenate([mixed, 1j * mixed], axis=1))
                by_residue[k] += np.kron(warm[:, None], np.concatenate([residue, mixed], axis=1))
                residues[k] += np.kron(np.outer(warm, warm), heard @ part[:, k].T)
        return _Level(matrix, by_residue, residues, by_pole, poles, penalty)


def _factor(unit: Real) -> tuple[Real, bool]:
    """Cholesky factor of a matrix of unit diagonal, as `cho_factor`, with a ridge as small as rounding allows."""
    ridge = RIDGE
    while True:
        try:
            factor, lower = cho_factor(unit + ridge * np.eye(len(unit)), lower=True)
            return factor, bool(lower)
        except np.linalg.LinAlgError:
            if ridge > 1.0:
                raise
            ridge *= STEEPER


def _spread(products: Real, own: Real) -> Real:
    """Products (..., 10 + R) with a sweep's columns as those with local unknowns and the rest, (..., N + R)."""
    return np.concatenate([products[:, :GLOBAL] @ own, products[:, GLOBAL:]], axis=1)


def _real(numbers: Complex) -> Real:
    """Real and imaginary parts of (q, K, n) complex numbers side by side, (q, 2 K n)."""
    flat = numbers.reshape(len(numbers), -1)
    return np.concatenate([flat.real, flat.imag], axis=1)
