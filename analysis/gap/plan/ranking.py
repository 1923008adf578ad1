"""Measurements ranked by what they are expected to settle per hour of a laboratory."""

from collections.abc import Sequence
from dataclasses import dataclass

from analysis.gap.plan.measurement import Measurement
from analysis.gap.plan.separation import ENOUGH, Question

BLIND = 0.2
"""Weight of a blind spot: nobody saw the effect; of one that was found only the name is open."""


@dataclass(frozen=True)
class Expected:
    """What one measurement is expected to say.

    Attributes
    ----------
    measurement : Measurement
    before, after : tuple of float
        Separation of the answers to each question by the recorded campaign, and with the measurement, sigma.
    weights : tuple of float
        Of the questions.
    """

    measurement: Measurement
    before: tuple[float, ...]
    after: tuple[float, ...]
    weights: tuple[float, ...]

    @property
    def gain(self) -> float:
        """Separation that it adds, each question counted up to `ENOUGH`, and by its weight, sigma."""
        rows = zip(self.weights, self.before, self.after, strict=True)
        return sum(weight * max(min(after, ENOUGH) - min(before, ENOUGH), 0.0) for weight, before, after in rows)

    @property
    def per_hour(self) -> float:
        """The same per hour."""
        return self.gain / self.measurement.hours

    @property
    def margin(self) -> float:
        """Smallest separation of what it settles, sigma: of two as good per hour the surer is better."""
        return min((self.after[k] for k in self.settles), default=0.0)

    @property
    def settles(self) -> tuple[int, ...]:
        """Questions that it settles and the recorded campaign does not, by their places."""
        pairs = enumerate(zip(self.before, self.after, strict=True))
        return tuple(k for k, (before, after) in pairs if before < ENOUGH <= after)


@dataclass(frozen=True)
class Plan:
    """Questions, and measurements that may answer them.

    Attributes
    ----------
    questions : tuple of Question
    ranked : tuple of Expected
        Most separation per hour first; of those that settle as much in more than one place, the best place only.
    notes : tuple of str
        Measurements that could not be simulated, for people.
    """

    questions: tuple[Question, ...]
    ranked: tuple[Expected, ...]
    notes: tuple[str, ...] = ()

    @property
    def winner(self) -> Expected | None:
        """The measurement to be made next; None where none adds anything."""
        return self.ranked[0] if self.ranked and self.ranked[0].gain > 0.0 else None


def weights(questions: Sequence[Question]) -> tuple[float, ...]:
    """Return what each question counts."""
    return tuple(BLIND if one.rival is None else 1.0 for one in questions)


def ranked(questions: Sequence[Question], expected: Sequence[Expected], notes: Sequence[str] = ()) -> Plan:
    """Rank measurements; of each kind that has several places, the best place is kept.

    A measurement that settles a question comes before all that settle none: half an answer an hour is none.

    Parameters
    ----------
    questions : sequence of Question
    expected : sequence of Expected
    notes : sequence of str

    Returns
    -------
    Plan
    """
    ordered = sorted(expected, key=lambda one: (not one.settles, -round(one.per_hour, 1), -one.margin))
    best: dict[str, Expected] = {}
    for one in ordered:
        best.setdefault(one.measurement.key, one)
    return Plan(tuple(questions), tuple(best.values()), tuple(notes))
