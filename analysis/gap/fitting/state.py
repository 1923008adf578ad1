"""State of a fit: laws at the groups, errors of the readings, gains and effects."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from analysis.effect_card import EffectCard, Parameter, Values
from analysis.gap.data.groups import TemperatureGroups, mean_laws
from analysis.gap.data.sweeps import GapSweeps
from analysis.gap.thresholds import MOVED_ERROR, MOVES
from analysis.material import MaterialBox
from analysis.recordings.sweep_point import SweepPoint
from analysis.updated import Updated


@dataclass(frozen=True)
class GapState:
    """Values of everything that is fitted or held.

    Attributes
    ----------
    laws : (G, 3) ndarray
        log E [log Pa], nu and log eta at the groups' references.
    tilt, bend : (G, 3) ndarray
        Errors of the slopes and curvatures that follow from `laws`, per K and per K2.
    away : (T,) ndarray
        True temperature less reading, K.
    log_gain : (I,) ndarray
        Of every input.
    effects : mapping
        Values of each effect that is switched on.
    declared : mapping
        True less declared values of what is declared with a tolerance.
    """

    laws: NDArray[np.float64]
    tilt: NDArray[np.float64]
    bend: NDArray[np.float64]
    away: NDArray[np.float64]
    log_gain: NDArray[np.float64]
    effects: Mapping[str, Values]
    declared: Mapping[str, Values] = field(default_factory=dict)

    @property
    def on(self) -> dict[str, Values]:
        """Values of all that changes the twin: of declared quantities and of effects."""
        return {**self.declared, **self.effects}

    def circumstances(self, sweep: int, point: SweepPoint) -> SweepPoint:
        """Return a sweep's circumstances with the fitted temperature and level.

        The temperature is that of the plate. The level is scaled by the input's gain over that of the first input,
        because amplifiers with different gains cause different motions at the same generator voltage.
        """
        louder = float(np.exp(self.log_gain[point.source] - self.log_gain[0]))
        return replace(point, temperature=point.temperature + float(self.away[sweep]), level=point.level * louder)

    def with_values(self, values: Mapping[str, Values]) -> "GapState":
        """Return the same state with other values of declared quantities and effects, all of which are on."""
        parts = [{name: dict(values[name]) for name in part} for part in (self.declared, self.effects)]
        return replace(self, declared=parts[0], effects=parts[1])

    def with_tolerances(self, cards: Mapping[str, EffectCard]) -> "GapState":
        """Return the same state with declared quantities free that have no value yet: they are as declared."""
        return replace(self, declared={name: self.declared.get(name, card.zero()) for name, card in cards.items()})

    def with_declared(self, values: Mapping[str, Values]) -> "GapState":
        """Return the same state with other values of some declared quantities."""
        return replace(self, declared={**self.declared, **{name: dict(one) for name, one in values.items()}})

    def with_effects(self, effects: Mapping[str, Values]) -> "GapState":
        """Return the same state with other effects."""
        return replace(self, effects={name: dict(values) for name, values in effects.items()})

    def without(self, name: str) -> "GapState":
        """Return the same state without one of its effects."""
        return self.with_effects({other: values for other, values in self.effects.items() if other != name})

    def promoted(self, cards: Mapping[str, EffectCard]) -> "GapState":
        """Return the same state without effects whose first is off; the second of two alike is then the first."""
        kept: dict[str, Values] = {}
        for name, values in self.effects.items():
            first = cards[name].after
            if not first or first in self.effects:
                kept[name] = values
            elif cards[first].parameters == cards[name].parameters:
                kept[first] = values
        return self.with_effects(kept)

    def restricted(self, whole: GapSweeps, part: GapSweeps) -> "GapState":
        """Return the state of some sweeps of a campaign.

        The laws are kept with their slopes and curvatures, not with how far these are from what follows from the
        values: in a part, other temperatures are neighbours.

        Parameters
        ----------
        whole : GapSweeps
            Of this state.
        part : GapSweeps
            Some of them.

        Returns
        -------
        GapState
        """
        places = part.original_places(whole)
        kept = np.unique(whole.groups.of_sweep[places])
        slope, curvature = (
            likeliest[kept] + error[kept]
            for likeliest, error in zip(
                whole.smoothness.derivatives(self.laws), (self.tilt, self.bend), strict=True
            )
        )
        # where only some sweeps of a group are kept, their mean temperature is another
        apart = (part.groups.reference - whole.groups.reference[kept])[:, None]
        laws = self.laws[kept] + apart * (slope + 0.5 * apart * curvature)
        tilt, bend = part.smoothness.derivatives(laws)
        return replace(
            self,
            laws=laws,
            tilt=slope + apart * curvature - tilt,
            bend=curvature - bend,
            away=self.away[places],
        )

    def corrected(self, sweeps: GapSweeps, before: "GapState", after: "GapState", few: GapSweeps) -> "GapState":
        """Change laws, readings, gain and effects as a fit to `few` sweeps changed them from `before` to `after`.

        The laws' changes are interpolated over temperature: they are smooth even where the laws themselves are
        not. Errors of readings are interpolated from sweep to sweep, as a plate lags behind on a ramp, and are
        zero in the mean of a group, as a fit leaves them. Errors of the laws' derivatives start at zero.

        Parameters
        ----------
        sweeps : GapSweeps
            Of this state.
        before : GapState
            Of the few sweeps, before their fit.
        after : GapState
            After it.
        few : GapSweeps
            Those that were fitted, all of some groups.

        Returns
        -------
        GapState
        """
        change, groups = after.laws - before.laws, sweeps.groups
        changes = [np.interp(groups.reference, few.groups.reference, column) for column in change.T]
        log_gain = self.log_gain + after.log_gain - before.log_gain
        away = np.interp(np.arange(sweeps.count), few.original_places(sweeps), after.away)
        mean = np.bincount(groups.of_sweep, away) / np.bincount(groups.of_sweep)
        begun = plain_state(groups, self.laws + np.array(changes).T, log_gain, after.effects)
        return replace(begun, declared=after.declared, away=away - mean[groups.of_sweep])


def starting_state(updated: Updated, groups: TemperatureGroups) -> GapState:
    """State without effects from a model updating of the same sweeps; groups take the mean of their sweeps."""
    start = plain_state(groups, mean_laws(updated.material, groups), np.log(updated.gains), {})
    return replace(start, declared=updated.departures)


def plain_state(
    groups: TemperatureGroups,
    laws: NDArray[np.float64],
    log_gain: NDArray[np.float64],
    effects: Mapping[str, Values],
) -> GapState:
    """State without errors of the laws' derivatives and of the readings.

    Parameters
    ----------
    groups : TemperatureGroups
    laws : (G, 3) ndarray
        log E [log Pa], nu and log eta at the groups' references.
    log_gain : (I,) ndarray
    effects : mapping
        Values of each effect that is on.

    Returns
    -------
    GapState
    """
    straight = np.zeros_like(laws)
    return GapState(laws, straight, straight, np.zeros(len(groups.of_sweep)), log_gain, effects)


def clipped_laws(box: MaterialBox, laws: NDArray[np.float64]) -> NDArray[np.float64]:
    """Laws (G, 3) clipped to the model's box."""
    material = np.stack([np.exp(laws[:, 0]), laws[:, 1], np.exp(laws[:, 2])], axis=1)
    inside = box.clip(material)
    # exp and log are not exact inverses in floating point: values inside are not changed
    back = np.stack([np.log(inside[:, 0]), inside[:, 1], np.log(inside[:, 2])], axis=1)
    clipped: NDArray[np.float64] = np.where(inside == material, laws, back)
    return clipped


@dataclass(frozen=True)
class FreeParameters:
    """Parameters of effects and declared quantities that are fitted, with their priors and ranges.

    Attributes
    ----------
    names : tuple of (effect, parameter)
        Of declared quantities last.
    cards : tuple of Parameter
    tolerances : int
        Number of those of declared quantities: their priors are data, as a reading is.
    trusted : float
        Weight of these priors. The twin's own error, and any effect that it lacks, pull at every quantity, however
        well it was measured: data count as much less against the tolerances as they do in evidence, see
        `GapSweeps.overstated`, and as chi2 per number is above 1.
    centre : (P,) ndarray
        Of the priors.
    """

    names: tuple[tuple[str, str], ...]
    cards: tuple[Parameter, ...]
    tolerances: int = 0
    trusted: float = 1.0

    @classmethod
    def of(
        cls,
        cards: Mapping[str, EffectCard],
        effects: Sequence[str],
        tolerances: Mapping[str, EffectCard],
    ) -> "FreeParameters":
        """All parameters of `effects`, shapes included, and of declared quantities.

        Parameters
        ----------
        cards : mapping
            Of effects.
        effects : sequence of str
        tolerances : mapping
            Cards of the declared quantities.

        Returns
        -------
        FreeParameters
        """
        pairs = [(name, p) for name in effects for p in cards[name].parameters]
        declared = [(name, p) for name, card in tolerances.items() for p in card.parameters]
        both = [*pairs, *declared]
        return cls(tuple((name, p.name) for name, p in both), tuple(p for _, p in both), len(declared))

    @property
    def effects(self) -> int:
        """Number of parameters of effects, which come first."""
        return len(self.names) - self.tolerances

    @property
    def centre(self) -> NDArray[np.float64]:
        """Means of the priors, (P,)."""
        return np.array([p.centre for p in self.cards])

    @property
    def sigma(self) -> NDArray[np.float64]:
        """Standard deviations of the priors, (P,)."""
        return np.array([p.sigma for p in self.cards])

    @property
    def trust(self) -> NDArray[np.float64]:
        """Weights of the priors, (P,)."""
        return np.array([1.0] * self.effects + [self.trusted] * self.tolerances)

    def priors(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Inverse variances of the priors at `values` (P,), (P,)."""
        return np.array([p.precision(value) for p, value in zip(self.cards, values.tolist(), strict=True)])

    def precision(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Inverse variances with which the priors act at `values` (P,) on the data's chi2, (P,)."""
        return np.asarray(self.trust * self.priors(values))

    @property
    def low(self) -> NDArray[np.float64]:
        """Lower ends of the ranges, (P,)."""
        return np.array([p.low for p in self.cards])

    @property
    def high(self) -> NDArray[np.float64]:
        """Upper ends of the ranges, (P,)."""
        return np.array([p.high for p in self.cards])

    @property
    def shapes(self) -> NDArray[np.bool_]:
        """Which of the parameters are shapes, (P,)."""
        return np.array([p.shape for p in self.cards], dtype=bool)

    def moved_error(self, values: NDArray[np.float64]) -> float:
        """Error of the twin by patches that are not where it was made: second order, as a share of rms|H|.

        Parameters
        ----------
        values : (P,) ndarray
        """
        squares: dict[str, float] = {}
        for (name, _), card, value in zip(self.names, self.cards, values.tolist(), strict=True):
            if name.startswith(MOVES):
                squares[name] = squares.get(name, 0.0) + (value - card.made_at) ** 2
        return float(MOVED_ERROR * np.sqrt(sum(square**2 for square in squares.values())))

    def standing(self, values: NDArray[np.float64], step: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which parameters (P,) are shapes of effects whose amplitudes change by less than half in `step`.

        A shape's tangent is proportional to the amplitude: before the amplitude has settled, a step of the shape
        is arbitrary.
        """
        effects = np.array([name for name, _ in self.names])
        size, change = (values / self.sigma) ** 2, (step / self.sigma) ** 2
        stands = [
            change[same].sum() < 0.25 * size[same].sum()
            for same in ((effects == name) & ~self.shapes for name in effects)
        ]
        return np.array(stands, dtype=bool) & self.shapes

    def read(self, effects: Mapping[str, Values]) -> NDArray[np.float64]:
        """Take the values (P,) out of `effects`."""
        return np.array([effects[name][p] for name, p in self.names], dtype=float)

    def write(self, effects: Mapping[str, Values], values: NDArray[np.float64]) -> dict[str, dict[str, float]]:
        """Return `effects` with `values` (P,) put in."""
        changed = {name: dict(v) for name, v in effects.items()}
        for (name, parameter), value in zip(self.names, values, strict=True):
            changed[name][parameter] = float(value)
        return changed

    def penalties(self, values: NDArray[np.float64]) -> tuple[float, float]:
        """Return minus twice the log priors of `values` (P,), up to constants: of effects, of what is declared."""
        each = self.trust * np.array([p.penalty(v) for p, v in zip(self.cards, values.tolist(), strict=True)])
        return float(each[: self.effects].sum()), float(each[self.effects :].sum())
