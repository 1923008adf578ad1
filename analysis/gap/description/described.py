"""What an unknown cause is like: a load at a place, a modulus or a gain over frequency, and what it depends on."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from analysis.arrays import Real
from analysis.effect_card import Values
from analysis.estimates import Estimate
from analysis.gap.description.place_map import PlaceMap

CONSTANT, VARIES = 3.0, 0.1
"""A cause counts as the same in all circumstances if no factor is this many sigma, or this share, from 1."""


@dataclass(frozen=True)
class Curve:
    """Two curves over frequency.

    Attributes
    ----------
    frequency : (B,) ndarray, Hz
    value, sigma : (2, B) ndarray
        Of a load: its apparent mass, real and minus imaginary part, kg. Of a modulus: relative change of storage
        modulus and loss factor. Of a gain: of its logarithm, and phase, rad.
    """

    frequency: Real
    value: Real
    sigma: Real


@dataclass(frozen=True)
class Form:
    """One form that a cause may have, as fitted.

    Attributes
    ----------
    name : str
        ``mass``, ``spring``, ``dashpot``, ``resonator``, ``load``, ``modulus``, ``gain``.
    effect : str
        By which it was computed.
    values : mapping
        Of that effect.
    parameters : tuple of Estimate
        The same with standard deviations.
    nats : float
        Log evidence over the twin without it.
    share : float
        Share of the excess over the noise that it explains.
    curve : Curve or None
    also : tuple of (float, float)
        Other places from which it explains as much, m.
    """

    name: str
    effect: str
    values: Values
    parameters: tuple[Estimate, ...]
    nats: float
    share: float
    curve: Curve | None = None
    also: tuple[tuple[float, float], ...] = ()

    @property
    def place(self) -> tuple[Estimate, Estimate] | None:
        """Where it acts; None where it is no load at a place."""
        known = {one.name: one for one in self.parameters}
        return (known["x"], known["y"]) if {"x", "y"} <= set(known) else None


@dataclass(frozen=True)
class Dependence:
    """How a cause's strength changes with one circumstance.

    Attributes
    ----------
    on : str
        ``temperature``, ``ramp``, ``level``, ``channel``, ``time``.
    label : tuple of str
        Of each value of the circumstance.
    factor, sigma : (L,) ndarray
        Strength over that of the fit to all sweeps.
    """

    on: str
    label: tuple[str, ...]
    factor: Real
    sigma: Real

    @property
    def constant(self) -> bool:
        """Whether it is the same throughout, as far as the data say."""
        away = abs(self.factor - 1.0)
        return bool(((away < CONSTANT * self.sigma) | (away < VARIES)).all())


@dataclass(frozen=True)
class Description:
    """Description of what a twin lacks and no effect explains.

    Attributes
    ----------
    best : Form
        The form with most evidence.
    forms : tuple of Form
        All that were fitted, most evidence first.
    map : PlaceMap
    dependence : tuple of Dependence
        Of the best form.
    beside : mapping
        Effects that were on.
    """

    best: Form
    forms: tuple[Form, ...]
    map: PlaceMap = field(repr=False)
    dependence: tuple[Dependence, ...]
    beside: Mapping[str, Values]
