"""Result of the gap workflow, for gap.json and its figures."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from analysis.arrays import Real
from analysis.estimates import DeclaredQuantity, Estimate, FittedLaws
from analysis.gap.data.noise import NoiseCheck
from analysis.gap.fitting.residual_map import ResidualMap, Signature
from analysis.gap.fitting.state import GapState
from analysis.gap.imperfect.discrepancy import Discrepancy
from analysis.gap.search.held_out import HeldOut
from analysis.gap.search.observability import Observability
from analysis.gap.search.refit import Step

Verdict = Literal["none", "explained", "partly_explained", "unknown"]


@dataclass(frozen=True)
class NamedEffect:
    """An effect that the twin lacked.

    Attributes
    ----------
    name : str
    summary : str
        What it is, in one line.
    equivalent : tuple of str
        Other effects that this campaign cannot distinguish from it.
    separated_by : str
        A measurement that would distinguish them.
    probability : float
        Probability that it, or an equivalent, is present.
    against : mapping of str to float
        Log evidence of every other effect, ``nothing`` and ``unknown`` in its place, relative to it, nats.
    log_evidence_gain : float
        Log evidence over the twin without it, nats.
    parameters : tuple of Estimate
    title, phrase : str
        As on its card.
    shown : mapping of str to str
        Units of the parameters for people, where these are others.
    """

    name: str
    summary: str
    equivalent: tuple[str, ...]
    separated_by: str
    probability: float
    against: Mapping[str, float]
    log_evidence_gain: float
    parameters: tuple[Estimate, ...]
    title: str = ""
    phrase: str = ""
    shown: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class PlainTwin:
    """The twin without effects, as fitted.

    Attributes
    ----------
    state : GapState
    laws : FittedLaws
    sigma_gain : (I,) ndarray
        Of every input's gain, V/V.
    declared : tuple of DeclaredQuantity
        What is declared with a tolerance.
    """

    state: GapState
    laws: FittedLaws
    sigma_gain: Real
    declared: tuple[DeclaredQuantity, ...]


@dataclass(frozen=True)
class Agreement:
    """How well a twin agrees with the data.

    Attributes
    ----------
    chi2_per_dof : float
        Over all lines, with the observed noise.
    relative_misfit : float
        rms|H_data - H_twin| / rms|H_data|.
    z : float
        Excess of chi2 over the noise's, in its standard deviations.
    whiteness : (float, float)
        Correlation of neighbouring residuals over frequency and over temperature, in standard deviations.
    """

    chi2_per_dof: float
    relative_misfit: float
    z: float
    whiteness: tuple[float, float]


@dataclass(frozen=True)
class CandidateRow:
    """One line of the table of candidates, at the baseline.

    Attributes
    ----------
    effect : str
    screened : float
        Evidence to first order, nats, reduced for the twin's own error.
    fitted : float or None
        Evidence of the full fit of this effect alone, nats.
    share : float or None
        Share of the excess that this effect alone explains.
    kept : float
        Share of its tangent that is independent of the baseline's unknowns.
    cosine : float
        Between its tangents and those of the first effect named (largest canonical correlation); 0 for none.
    """

    effect: str
    screened: float
    fitted: float | None
    share: float | None
    kept: float
    cosine: float


@dataclass(frozen=True)
class GapReport:
    """Result of comparing a campaign with its twin.

    Attributes
    ----------
    verdict : str
        As in gap.json.
    effects : tuple of NamedEffect
        Strongest first; for ``unknown`` they are hints.
    not_observable : tuple of Observability
        Effects that can be neither claimed nor excluded, with the measurement that would show them.
    seen : tuple of Observability
        Of every effect.
    baseline, final : Agreement
        Without effects, and with them.
    held_out : tuple of HeldOut
        One per way to hold data out; the first decides; empty where no effect was found.
    unexplained : float or None
        Share of the baseline's excess that is left; None where there was none.
    before, after : ResidualMap
    laws_before, laws_after : FittedLaws
        Of the twins that are issued: for ``unknown`` both are those of `plain`, beside the discrepancy.
    plain : PlainTwin
        Without effects; beside a discrepancy, where one is left.
    state : GapState
        Laws, readings, gain and effects at the end.
    sigma_gain : (I,) ndarray
        Of every input's gain, V/V.
    candidates : tuple of CandidateRow
    signatures : tuple of Signature
        Of every candidate, largest predicted gain first; none where there is no gap.
    steps : tuple of Step
    noise : NoiseCheck
    notes : tuple of str
        For people.
    seconds : float
    declared : tuple of DeclaredQuantity
        What is declared with a tolerance, as fitted at the end.
    titles : mapping of str to str
        Names of all candidates for people.
    scatter : (Discrepancy, Discrepancy) or None
        Of the resonances about the twin's, without effects and with them; None where noise is all that is left.
    """

    verdict: Verdict
    effects: tuple[NamedEffect, ...]
    not_observable: tuple[Observability, ...]
    seen: tuple[Observability, ...]
    baseline: Agreement
    final: Agreement
    held_out: tuple[HeldOut, ...]
    unexplained: float | None
    before: ResidualMap
    after: ResidualMap
    laws_before: FittedLaws
    laws_after: FittedLaws
    plain: PlainTwin
    state: GapState
    sigma_gain: Real
    candidates: tuple[CandidateRow, ...]
    signatures: tuple[Signature, ...] = field(repr=False)
    steps: tuple[Step, ...] = field(repr=False)
    noise: NoiseCheck = field(repr=False)
    notes: tuple[str, ...]
    seconds: float
    declared: tuple[DeclaredQuantity, ...] = ()
    titles: Mapping[str, str] = field(default_factory=dict)
    scatter: tuple[Discrepancy, Discrepancy] | None = None
