"""Result of a fit of laws, readings, gain and effects; its misfit, and the constants of a sheet in it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.effect_card import EffectCard
from analysis.estimates import RATIOS, DeclaredQuantity, FittedLaws, SheetMaterial
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.fitting.schur_complement import SchurComplement
from analysis.gap.fitting.state import FreeParameters, GapState
from analysis.material import Orthotropy


@dataclass(frozen=True)
class Uncertainty:
    """Standard deviations of a fit, everything else eliminated.

    Attributes
    ----------
    parameters : (P,) ndarray
        Of the free parameters of effects, by their priors too.
    laws : (G, 3) ndarray
        Of log E, nu and log eta of the groups.
    log_gain : (I,) ndarray
        Of every input; 0 where it was held.
    common : (G, 3, P) ndarray
        Share of each parameter's prior in the standard deviations of the laws, with sign: what one standard
        deviation of a declared quantity moves.
    alone : (G, 3) ndarray
        Standard deviations of the laws were all that the temperatures share known.
    own, within, across : (P, P), (G, 3, 3), (G, 3, P) ndarray
        Covariance of the parameters, of a group's laws, and of these with the parameters.
    """

    parameters: Real
    laws: Real
    log_gain: Real
    common: Real
    alone: Real
    own: Real = field(repr=False)
    within: Real = field(repr=False)
    across: Real = field(repr=False)

    @classmethod
    def of(cls, head: SchurComplement, free: FreeParameters, values: Real, gain_free: bool) -> Self:
        """Take them from the normal equations at the end of a fit.

        Parameters
        ----------
        head : SchurComplement
        free : FreeParameters
        values : (P,) ndarray
            Of the parameters: a prior holds a value far from its centre less than one near it.
        gain_free : bool
            Whether the gains were fitted.

        Returns
        -------
        Uncertainty
        """
        left = head.without_gains(gain_free)
        joint = left.joint(np.asarray(np.linalg.inv(left.matrix + np.diag(free.priors(values)))))
        deviation = np.sqrt(np.diag(joint))
        own, across = joint[head.gains :, head.gains :], -head.law_lever @ joint[:, head.gains :]
        return cls(
            deviation[head.gains :],
            head.law_sigma(joint),
            deviation[: head.gains],
            (across / free.sigma).reshape(head.groups, 3, -1),
            head.law_sigma(np.zeros_like(joint)),
            own,
            head.law_covariance(joint),
            across.reshape(head.groups, 3, -1),
        )

    def beside(self, chosen: Sequence[int | None]) -> Real:
        """Covariance of a group's laws and some parameters, (G, 3 + C, 3 + C); 0 of those that are None."""
        size = 3 + len(chosen)
        found = np.zeros((len(self.within), size, size))
        found[:, :3, :3] = self.within
        for i, k in enumerate(chosen, start=3):
            if k is None:
                continue
            found[:, :3, i] = found[:, i, :3] = self.across[:, :, k]
            for j, other in enumerate(chosen, start=3):
                found[:, i, j] = 0.0 if other is None else self.own[k, other]
        return found


@dataclass(frozen=True)
class Held:
    """Where a fit stood before declared quantities were freed, and its objective there."""

    state: GapState
    objective: float


@dataclass(frozen=True)
class GapFit:
    """Result of a fit.

    Attributes
    ----------
    state : GapState
    free : FreeParameters
        The effects' parameters that were fitted.
    information : (P, P) ndarray
        Of the data on the free parameters, everything else eliminated.
    noise, stated : Uncertainty
        By the noise; and by what is left beyond it and the twin's own error too. These are common to all lines,
        and change laws and gains as well as the effects' parameters.
    chi2 : (T, K) ndarray
        Of the nodes.
    readings : (T,) ndarray
        chi2 of the temperature readings, which are data too: a thermal lag shows only there.
    smoothness : float
        chi2 of the laws' derivatives against the likeliest ones for their values.
    dof : float
        Number of real data less fitted unknowns.
    prior : float
        Minus twice the log prior of the effects' parameters, up to a constant.
    declared : float
        chi2 of the declared quantities, which are data too.
    residual, predicted : (T, K, n) complex ndarray
        Whitened residual, and the model's spline coefficients [V/V].
    alone : (T, 4, 4) ndarray
        Information matrix of each sweep alone, for its log E, nu, log eta and log gain.
    settled : bool
    on_wall : tuple of (effect, parameter)
        Parameters at a bound of their range.
    passes : int
        Number of linearisations of all sweeps.
    held : Held or None
        Where the fit stood before declared quantities were freed; None where they were free from the beginning.
    """

    state: GapState
    free: FreeParameters
    information: Real
    noise: Uncertainty
    stated: Uncertainty
    chi2: Real
    readings: Real
    smoothness: float
    dof: float
    prior: float
    declared: float
    residual: NDArray[np.complex128] = field(repr=False)
    predicted: NDArray[np.complex128] = field(repr=False)
    alone: Real
    settled: bool
    on_wall: tuple[tuple[str, str], ...]
    passes: int
    held: Held | None = None

    def declared_quantities(self, cards: Mapping[str, EffectCard]) -> tuple[DeclaredQuantity, ...]:
        """Return what was found about the declared quantities with a tolerance, of `cards`."""
        rows = list(zip(self.free.names, self.free.cards, self.stated.parameters, strict=True))
        return tuple(
            DeclaredQuantity(
                name, p.name, p.unit, cards[name].summary, p.sigma, self.state.declared[name][p.name], float(sigma)
            )
            for (name, _), p, sigma in rows[self.free.effects :]
        )

    def fitted_laws(self, temperature: Real) -> FittedLaws:
        """Return the laws at the groups' temperatures (G,), degrees Celsius, with their standard deviations."""
        stated, declared = self.stated, self.stated.common[:, :, self.free.effects :]
        if not declared.size:
            return FittedLaws(temperature, self.state.laws, stated.laws)
        rest = stated.laws**2 - stated.alone**2 - (declared**2).sum(axis=2)
        shared = np.concatenate([declared, np.sqrt(np.maximum(rest, 0.0))[:, :, None]], axis=2)
        return FittedLaws(temperature, self.state.laws, stated.laws, shared)

    @property
    def total(self) -> float:
        """chi2 over all sweeps, channels, readings, derivatives of the laws and declared quantities."""
        return float(self.chi2.sum() + self.readings.sum()) + self.smoothness + self.declared

    @property
    def objective(self) -> float:
        """What the fit made least: `total`, and what the priors of the effects' parameters add."""
        return self.total + self.prior

    @property
    def determined(self) -> float:
        """Number of the campaign's unknowns that data determine, rather than priors; 4 of them laws and gain."""
        shares = np.linalg.solve(self.information + np.diag(self._precision), self.information)
        return 4.0 + float(np.trace(shares))

    @property
    def plausible(self) -> bool:
        """Whether no effect has become another, and no amplitude is at a bound of its physical range but zero.

        An amplitude may be zero: a suspension may have a spring without a dashpot.
        """
        free, values = self.free, self.free.read(self.state.on)
        return not self.become_another and not any(
            name in self.on_wall and not card.shape and value != 0.0
            for name, card, value in zip(free.names[: free.effects], free.cards, values, strict=False)
        )

    @property
    def become_another(self) -> tuple[str, ...]:
        """Effects with a shape that is told inside its range only, and that is not told from a bound of it."""
        free = self.free
        values = free.read(self.state.on)
        near = np.minimum(values - free.low, free.high - values) <= self.stated.parameters
        named = zip(free.names[: free.effects], free.cards, near, strict=False)
        return tuple(name for (name, _), card, bound in named if card.only_inside and bound)

    @property
    def _precision(self) -> Real:
        """Of the priors, at the values found."""
        return self.free.precision(self.free.read(self.state.on))

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation, up to a constant common to all sets of effects on the same sweeps."""
        prior = self.free.precision(self.free.centre)
        scaled = (self.information + np.diag(self._precision)) / prior[:, None]
        occam = float(np.linalg.slogdet(scaled)[1]) if len(self.information) else 0.0
        return -0.5 * (self.objective + occam)


def relative_misfit(sweeps: GapSweeps, fit: GapFit) -> float:
    """rms|H_data - H_twin| / rms|H_data| over all lines, channels and sweeps used."""
    missed, power = sweep_powers(sweeps, fit)
    return float(np.sqrt(missed.sum() / power.sum()))


def sweep_powers(sweeps: GapSweeps, fit: GapFit) -> tuple[Real, Real]:
    """Sum |H_data - H_twin|^2 and |H_data|^2 over the lines and channels of each sweep, (T,) each, (V/V)^2.

    The data are the lines themselves, including their noise about the splines.
    """
    missed, power = np.zeros(sweeps.count), np.zeros(sweeps.count)
    for s, sweep in enumerate(sweeps.compressed):
        rows = sweeps.rows[s]
        smooth = sweep.nodes.at_lines(sweep.coefficients)
        away = sweep.nodes.at_lines(sweep.coefficients - fit.predicted[s])
        share = rows.mean(-1)
        here = np.interp(sweep.nodes.lines, sweep.nodes.frequency, np.arange(rows.shape[-1])).round().astype(int)
        mask = rows[:, here]
        missed[s] = (np.abs(away) ** 2 * mask).sum() + sweep.power_within @ share
        power[s] = (np.abs(smooth) ** 2 * mask).sum() + sweep.power_within @ share
    return missed, power


def fitted_sheet(
    declared: Orthotropy | None, fit: GapFit, sigma: Real | None = None, own: Real | None = None
) -> SheetMaterial | None:
    """Return the constants at a fit's groups.

    Parameters
    ----------
    declared : Orthotropy or None
        None for an isotropic sheet, which has none.
    fit : GapFit
    sigma : (G, 3) ndarray, optional
        Total standard deviations of log E, nu and log eta; those of the fit by default.
    own : (G, 3) ndarray, optional
        Part of their variances by each sweep's noise; that of the fit by default.

    Returns
    -------
    SheetMaterial or None
    """
    if declared is None:
        return None
    free, stated, laws = fit.free, fit.stated, fit.state.laws
    chosen = [free.names.index(pair) if pair in free.names else None for pair in RATIOS]
    covariance = stated.beside(chosen)
    if sigma is not None:
        place = np.arange(3)
        covariance[:, place, place] = np.maximum(covariance[:, place, place], sigma**2)
    if own is None:
        own = np.maximum(fit.noise.laws**2 - (fit.noise.common**2).sum(axis=2), 0.0)
    moved = np.zeros((len(laws), 3 + len(RATIOS), len(free.names)))
    moved[:, :3] = stated.common
    for row, k in enumerate(chosen, start=3):
        if k is not None:
            moved[:, row] = stated.own[k] / free.sigma
    values = fit.state.on
    ratios = np.array([values.get(name, {}).get(parameter, 0.0) for name, parameter in RATIOS])
    return SheetMaterial.of(declared, laws, ratios, covariance, moved[:, :, free.effects :], own)
