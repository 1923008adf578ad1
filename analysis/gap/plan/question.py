"""What a comparison leaves open: which of two effects it was, or whether an effect is there at all."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from analysis.effect_card import Values
from analysis.gap.report import GapReport

RIVALS = 3
"""Rivals of one effect that are asked about: those further down are less like it."""


@dataclass(frozen=True)
class Question:
    """One thing that a comparison left open.

    Attributes
    ----------
    effect : str
        Found, or not observable.
    rival : str or None
        Effect that the data cannot tell from it; None where the question is whether `effect` is there.
    values : mapping
        Of `effect` as found; empty where there is no rival: then one standard deviation of its prior counts.
    """

    effect: str
    rival: str | None = None
    values: Values = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """Return ``look-alike`` or ``blind spot``."""
        return "blind spot" if self.rival is None else "look-alike"

    @property
    def effects(self) -> tuple[str, ...]:
        """Return the effects that it is about."""
        return (self.effect,) if self.rival is None else (self.effect, self.rival)


def open_questions(report: GapReport, cards: Sequence[str]) -> tuple[Question, ...]:
    """List what a comparison left open, look-alikes first.

    With the verdict ``unknown`` the hints are asked about: each against the candidates that explain the next most.

    Parameters
    ----------
    report : GapReport
    cards : sequence of str
        Effects that can be computed; others are left out.

    Returns
    -------
    tuple of Question
    """
    known = set(cards)
    found: Mapping[str, Values] = report.state.effects
    asked = [
        Question(effect.name, rival, dict(found[effect.name]))
        for effect in report.effects
        if effect.name in known and effect.name in found
        for rival in _rivals(report, effect.name, effect.equivalent)
        if rival in known and rival not in found
    ]
    asked += [Question(one.effect) for one in report.not_observable if one.effect in known]
    return tuple(asked)


def _rivals(report: GapReport, effect: str, equivalent: Sequence[str]) -> Sequence[str]:
    if equivalent or report.verdict != "unknown":
        return equivalent[:RIVALS]
    fitted = [row for row in report.candidates if row.fitted is not None and row.effect != effect]
    return [row.effect for row in sorted(fitted, key=lambda row: -(row.fitted or 0.0))[:RIVALS]]
