"""What the healthy panel answers at any temperature, what the first recordings showed beside it, and a check.

The twin's own error, recorded less twin at every temperature of the baseline, is the same panel's on all dates.
Over frequency it moves with the resonances; over f / sqrt(E(T)) it hardly depends on the temperature, and a
polynomial in T carries it from the temperatures of the baseline to any other. The order of the polynomial is the
one that predicts best each temperature from the others.

What a recording of the healthy panel says about a candidate's amplitude, beyond its noise, is the error that the
baseline makes: laws and discrepancy between temperatures, and the baseline's own noise. It is alike on all dates
at one temperature, and does not average out over weeks; its variance is added to that of every estimate.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Self

import numpy as np

from analysis.arrays import Complex, Real
from analysis.checked_fields import check_ascending, check_finite, check_range, check_shapes
from analysis.gap.data.compression import Nodes
from analysis.health.candidates import DEPOLARIZATION, ChangeCandidate
from analysis.health.recording import DatedRecording, DateEquations, ExpectedResponse, date_equations
from analysis.material import MaterialLaws
from analysis.recordings.sweep_point import SweepPoint
from analysis.twin_model import Effects, Tangent, TwinModel

if TYPE_CHECKING:
    from scipy.interpolate import BSpline


@dataclass(frozen=True)
class SelfCheck:
    """What a baseline cannot tell about its own panel.

    Attributes
    ----------
    variance : (C,) ndarray
        Of the amplitude of every candidate, in its unit squared.
    misfit, usual : float
        Largest chi2 per degree of freedom of a temperature that was predicted from the others, and their mean.
    """

    variance: Real = field(repr=False)
    misfit: float
    usual: float

    def __post_init__(self) -> None:
        check_shapes(self, variance="C")
        check_finite(self, "variance", "misfit", "usual")
        check_range(self, 0.0, np.inf, "variance", "misfit", "usual")


FEWEST_TEMPERATURES = 4
"""Of a baseline: fewer cannot be tested against each other."""
HIGHEST_ORDER = 8
"""Of the polynomial: errors of laws turn a few times over the range; more only carries the noise of the
baseline."""
TEMPERATURE_SIGMA = 100.0
"""K: nothing is known of the temperature on a date but what the panel says itself."""
GAIN_SIGMA = 0.005
"""Of each input's log gain: amplifiers and charge amplifiers keep half a per cent over a year."""
LAW_SIGMA = (0.005, 0.05)
"""Of nu and log eta from date to date: what moisture and ageing of polymers do in a year, and more than what
updating leaves open. What changes the material of the whole panel is no damage, and is not named. E has none of
its own: it acts as the temperature, of which nothing is known."""
GRADIENT = 1.0
"""K from side to side: a panel that is no oven's has draughts and sun, which act as a gradient of its modulus."""


@dataclass(frozen=True)
class PanelLinearisation:
    """Twin of a panel at one temperature, without what the baseline showed beside it.

    Attributes
    ----------
    temperature : float
        Degrees Celsius.
    transfer : (I, K, n) complex ndarray
        Gains included.
    by_nuisance : (N, I, K, n) complex ndarray
        By temperature, gains (zero here), nu, log eta, and gradients.
    nuisance_sigma : (N,) ndarray
    by_change : (C, I, K, n) complex ndarray
    """

    temperature: float
    transfer: Complex = field(repr=False)
    by_nuisance: Complex = field(repr=False)
    nuisance_sigma: Real
    by_change: Complex = field(repr=False)

    def __post_init__(self) -> None:
        check_shapes(self, transfer="I K n", by_nuisance="N I K n", nuisance_sigma="N", by_change="C I K n")
        check_finite(self, "temperature", "transfer")


@dataclass(frozen=True)
class HealthBaseline:
    """A panel as it was when it was healthy.

    Attributes
    ----------
    model : TwinModel
    laws : MaterialLaws
    effects : mapping
        Declared quantities as fitted, and effects that the panel has.
    gains : (I,) ndarray
    nodes : Nodes
    channels : tuple of str
        Names of the K outputs.
    sources : tuple of str
        Names of the I inputs.
    recordings : (B,) tuple of DatedRecording
        By ascending temperature.
    temperature : (B,) ndarray
        Of the recordings, degrees Celsius.
    discrepancy : (B, I, K, n) complex ndarray
        Recorded less twin, at the nodes.
    candidates : tuple of ChangeCandidate
    order : int
        Of the polynomial that carries the discrepancy to other temperatures.
    """

    model: TwinModel = field(repr=False)
    laws: MaterialLaws = field(repr=False)
    effects: Effects
    gains: Real
    nodes: Nodes = field(repr=False)
    channels: tuple[str, ...]
    sources: tuple[str, ...]
    recordings: tuple[DatedRecording, ...] = field(repr=False)
    temperature: Real
    discrepancy: Complex = field(repr=False)
    candidates: tuple[ChangeCandidate, ...] = field(repr=False)
    order: int = 0

    def __post_init__(self) -> None:
        check_shapes(self, gains="I", channels="K", sources="I", temperature="B", discrepancy="B I K n")
        check_finite(self, "gains", "temperature", "discrepancy")
        check_ascending(self, "temperature")
        if not 0 <= self.order < max(len(self.temperature), 1):
            raise ValueError(
                f"HealthBaseline.order is {self.order}; allowed: 0 to {len(self.temperature) - 1}, fewer than the "
                "temperatures"
            )

    @classmethod
    def of(
        cls,
        model: TwinModel,
        laws: MaterialLaws,
        effects: Effects,
        gains: Real,
        recordings: Sequence[DatedRecording],
        candidates: Sequence[ChangeCandidate],
        channels: tuple[str, ...],
        sources: tuple[str, ...],
    ) -> Self:
        """Compare the recordings of a healthy panel with its twin.

        Parameters
        ----------
        model : TwinModel
        laws : MaterialLaws
            Of the same recordings, by model updating.
        effects : mapping
            That are on.
        gains : (I,) ndarray
        recordings : sequence of DatedRecording
            At four temperatures or more, all with the same nodes.
        candidates : sequence of ChangeCandidate
        channels, sources : tuple of str
            Names of outputs and inputs.

        Raises
        ------
        ValueError
            For too few temperatures.
        """
        rows = sorted(recordings, key=lambda one: -np.inf if one.label is None else one.label)
        if len(rows) < FEWEST_TEMPERATURES:
            raise ValueError(
                f"{len(rows)} temperatures at which every input drove; {FEWEST_TEMPERATURES} or more needed"
            )
        nodes = rows[0].nodes
        temperature = np.array([one.label for one in rows], dtype=float)
        nothing = np.zeros((len(rows), len(sources), len(channels), nodes.frequency.size), dtype=complex)
        bare = cls(
            model,
            laws,
            effects,
            gains,
            nodes,
            channels,
            sources,
            tuple(rows),
            temperature,
            nothing,
            tuple(candidates),
        )
        measured = np.array([[nodes.at_nodes(one.coefficients) for one in row.sweeps] for row in rows])
        twin = np.array([bare.linearised(float(t), changes=False).transfer for t in temperature])
        return replace(bare, discrepancy=measured - twin).best_order()

    def best_order(self) -> Self:
        """Return it with the order that predicts each temperature best from the others."""
        highest = min(HIGHEST_ORDER, len(self.temperature) - 2)
        tried = [replace(self, order=order) for order in range(highest + 1)]
        return min(tried, key=lambda one: one._missed())

    def _missed(self) -> float:
        """Sum of squares, in units of noise, of what each temperature shows beyond the others."""
        total = 0.0
        for index in self.inner:
            apart = self.discrepancy[index] - self.without(index).carried(float(self.temperature[index]))
            total += float((self.recordings[index].white(apart) ** 2).sum())
        return total

    @property
    def inner(self) -> range:
        """Temperatures that can be predicted from the others: not the first and the last."""
        return range(1, len(self.temperature) - 1)

    def without(self, index: int) -> Self:
        """Return the baseline that the other temperatures would have given, with the same twin and order."""
        kept = np.arange(len(self.temperature)) != index
        return replace(
            self,
            recordings=tuple(one for one, keep in zip(self.recordings, kept, strict=True) if keep),
            temperature=self.temperature[kept],
            discrepancy=self.discrepancy[kept],
        )

    @property
    def temperature_range(self) -> tuple[float, float]:
        """Where the baseline holds, degrees Celsius: nothing is extrapolated."""
        return float(self.temperature[0]), float(self.temperature[-1])

    def weights(self, temperature: float) -> Real:
        """Weights (B,) of the recordings' discrepancies at a temperature [degrees Celsius]."""
        low, high = self.temperature_range
        powers = np.arange(self.order + 1)
        scaled = (2.0 * np.append(self.temperature, temperature) - low - high) / (high - low)
        rows = scaled[:, None] ** powers
        found: Real = rows[-1] @ np.linalg.pinv(rows[:-1])
        return found

    def carried(self, temperature: float) -> Complex:
        """Discrepancy (I, K, n) at a temperature [degrees Celsius]."""
        low, high = self.nodes.frequency[[0, -1]]
        here = float(np.log(self.laws.at(temperature).youngs_modulus[0]))
        there = np.log(self.laws.at(self.temperature).youngs_modulus)
        total = np.zeros(self.discrepancy.shape[1:], dtype=complex)
        for index, weight in enumerate(self.weights(temperature)):
            at = np.clip(self.nodes.frequency * np.exp(0.5 * (there[index] - here)), low, high)
            total += weight * np.moveaxis(self._splines[index](at), 0, -1)
        return total

    @cached_property
    def _splines(self) -> "list[BSpline[np.complex128]]":
        return [self.nodes.spline(self.nodes.coefficients(one)) for one in self.discrepancy]

    @property
    def patches(self) -> tuple[str, ...]:
        """Patches of the candidates that lost polarization."""
        return tuple(one.patch for one in self.candidates if one.patch)

    def at(self, temperature: float, *, changes: bool = True) -> ExpectedResponse:
        """Return responses at a temperature, see `ExpectsResponses`.

        Parameters
        ----------
        temperature : float
            Degrees Celsius, within `temperature_range`.
        changes : bool
            Whether columns of the candidates are wanted, which take most of the time.

        Returns
        -------
        ExpectedResponse
        """
        return self.completed(self.linearised(temperature, changes=changes))

    def completed(self, twin: PanelLinearisation) -> ExpectedResponse:
        """Add the discrepancy to a twin's answers; a gain multiplies both."""
        response = twin.transfer + self.carried(twin.temperature)
        nuisances = twin.by_nuisance.copy()
        for index in range(len(self.sources)):
            nuisances[1 + index, index] = response[index]
        return ExpectedResponse(twin.temperature, response, nuisances, twin.nuisance_sigma, twin.by_change)

    def linearised(
        self,
        temperature: float,
        *,
        changes: bool = True,
        effects: Effects | None = None,
        tangents: Sequence[Tangent] | None = None,
    ) -> PanelLinearisation:
        """Linearise the twin at a temperature.

        Parameters
        ----------
        temperature : float
            Degrees Celsius.
        changes : bool
            Whether by all candidates.
        effects : mapping, optional
            Further effects that are on.
        tangents : sequence of Tangent, optional
            Wanted instead of those of the candidates.
        """
        law = self.laws.local(temperature)
        on = {**self.effects, **(effects or {})}
        slanted = "modulus_gradient" in self.model.cards and "modulus_gradient" not in on
        tilt: list[Tangent] = []
        if slanted:
            card = self.model.cards["modulus_gradient"]
            tilt = [(card.name, one.name, card.zero()) for one in card.amplitudes]
        wanted = list(tangents or ())
        if tangents is None and changes:
            wanted = [one.tangent for one in self.candidates if one.tangent is not None]
        rows = []
        for source in range(len(self.sources)):
            point = SweepPoint(temperature, 0.0, 1.0, source)
            rows.append(self.model.linearise(law, self.nodes.frequency, on, point, [*tilt, *wanted]))
        scale = self.gains[:, None, None]
        transfer = scale * np.array([one.transfer for one in rows])
        by_parameter: Complex = np.asarray(
            scale * np.stack([one.by_parameter for one in rows], axis=1), dtype=np.complex128
        )
        own = [scale * np.array([one.by_temperature for one in rows])]
        own += [np.zeros_like(transfer)] * len(self.sources)
        own += list(scale * np.stack([one.by_material[1:] for one in rows], axis=1))
        slope = abs(float(law.rates(temperature)[0]))
        sigma = [TEMPERATURE_SIGMA, *[GAIN_SIGMA] * len(self.sources), *LAW_SIGMA]
        sigma += [max(0.5 * GRADIENT * slope, 1e-6)] * len(tilt)
        columns = by_parameter[len(tilt) :]
        if tangents is None and changes:
            columns = np.concatenate([columns, self.lost(transfer)])
        return PanelLinearisation(
            temperature,
            transfer,
            np.concatenate([np.array(own), by_parameter[: len(tilt)]]),
            np.array(sigma),
            columns,
        )

    def lost(self, transfer: Complex) -> Complex:
        """Return derivatives of a twin's transfer by the polarization lost, in the order of the candidates."""
        names = [one.patch for one in self.candidates if one.effect == DEPOLARIZATION]
        found = np.zeros((len(names), *transfer.shape), dtype=complex)
        for row, patch in enumerate(names):
            for source, name in enumerate(self.sources):
                if name == patch:
                    found[row, source] -= transfer[source]
            for channel, name in enumerate(self.channels):
                if name == patch:
                    found[row, :, channel] -= transfer[:, channel]
        return found


def self_check(baseline: HealthBaseline, twins: Sequence[PanelLinearisation]) -> SelfCheck:
    """Leave out each temperature of a baseline in turn, but for the first and the last: nothing is extrapolated.

    Parameters
    ----------
    twins : (B,) sequence of PanelLinearisation
        At the temperatures of the baseline, with all candidates.
    """
    said = [
        date_equations(baseline.recordings[index], baseline.without(index).completed(twins[index]))
        for index in baseline.inner
    ]
    return checked(said, [one.family for one in baseline.candidates])


def checked(said: Sequence[DateEquations], families: Sequence[str]) -> SelfCheck:
    """Return what equations of a healthy panel leave open.

    The excess of z squared over one is the error in units of the noise. Single candidates have as few samples as
    the baseline has temperatures: the largest of their own mean, that of their family and that of all is taken.

    Parameters
    ----------
    said : (B,) sequence of DateEquations
    families : (C,) sequence of str
        Of the candidates.
    """
    information = np.array([np.diag(one.matrix) for one in said])
    seen = information > 0.0
    safe = np.where(seen, information, 1.0)
    squares = np.where(seen, np.array([one.gradient for one in said]) ** 2 / safe, 0.0)
    own = squares.mean(axis=0) - 1.0
    names = np.array(families)
    pooled = np.zeros_like(own)
    for name in np.unique(names):
        pooled[names == name] = own[names == name].mean()
    excess = np.maximum(np.maximum(own, pooled), max(float(own.mean()), 0.0)) if own.size else own
    variance = np.maximum(excess, 0.0) * np.where(seen, 1.0 / safe, 0.0).mean(axis=0)
    misfits = [one.chi2 / one.dof for one in said]
    return SelfCheck(variance, max(misfits), float(np.mean(misfits)))
