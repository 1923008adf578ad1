"""Description of a physical effect for the gap workflow, which contains no physics itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import log
from string import Formatter

Values = Mapping[str, float]
"""Parameters of one effect, by name, SI."""

PEOPLES = {
    ("kg", "g"): 1e3,
    ("m", "mm"): 1e3,
    ("s", "ms"): 1e3,
    ("s", "µs"): 1e6,
    ("1", "%"): 1e2,
    ("1/K", "%/K"): 1e2,
    ("V/V", "%"): 1e2,
    ("N/m", "N/mm"): 1e-3,
    ("N/m3", "N/cm³"): 1e-6,
    ("N s/m3", "N s/m³"): 1.0,
    ("rad", "mrad"): 1e3,
    ("1/V", "%/V"): 1e2,
    ("K", "K"): 1.0,
    ("s", "s"): 1.0,
}
"""Factors from SI units to those in which people say a number."""


USUAL = 2.0
"""Standard deviations up to which the prior of an effect's amplitude is normal. Beyond, it falls with the fourth
power: how large an undeclared thing can be is not known. A dashpot of 14 of them explained 98 % of a gap, and
beside the scatter of few modes a normal prior pulled it to nothing."""


@dataclass(frozen=True)
class Parameter:
    """One number that an effect brings into the twin.

    Attributes
    ----------
    name : str
    unit : str
        SI; ``1`` for a pure number.
    low, high : float
        What is physically possible.
    sigma : float
        Standard deviation of the prior about zero (about `typical` for a shape); see `USUAL`.
    shape : bool
        A shape (a position, a rate of softening) does nothing while the effect's amplitudes are zero.
    typical : float
        Where the search for a shape starts; 0 for amplitudes.
    shown : str
        Unit for people, see `PEOPLES`; empty for `unit` itself.
    made_at : float
        Of a declared quantity: the value about which the twin was made, and near which it is most exact.
    declared : bool
        Whether it is a declared quantity, whose prior is its tolerance: normal however far.
    only_inside : bool
        Whether a shape is told inside its range only: at a bound the effect has become another one (a relaxation
        far below the band, a loss that falls with frequency), whose name it must not have.
    """

    name: str
    unit: str
    low: float
    high: float
    sigma: float
    shape: bool = False
    typical: float = 0.0
    shown: str = ""
    made_at: float = 0.0
    declared: bool = False
    only_inside: bool = False

    def __post_init__(self) -> None:
        if self.shown and (self.unit, self.shown) not in PEOPLES:
            known = ", ".join(shown for unit, shown in PEOPLES if unit == self.unit) or "none"
            raise ValueError(f"parameter {self.name}: shown in {self.shown!r}; allowed for {self.unit!r}: {known}")
        if not self.low < self.high or not self.sigma > 0.0:
            raise ValueError(
                f"parameter {self.name}: range {self.low:g} to {self.high:g} must ascend, "
                f"prior sigma {self.sigma:g} must be above 0"
            )
        if not self.shape and not self.low <= 0.0 <= self.high:
            raise ValueError(f"parameter {self.name}: its range {self.low:g} to {self.high:g} leaves out zero")

    @property
    def centre(self) -> float:
        """Mean of the prior."""
        return self.typical if self.shape else 0.0

    def penalty(self, value: float) -> float:
        """Minus twice the log prior of a value, over that of the centre."""
        away = abs(value - self.centre) / self.sigma
        if self._usual(away):
            return away**2
        return USUAL**2 * (1.0 + 2.0 * log(away / USUAL))

    def precision(self, value: float) -> float:
        """Inverse variance of the normal prior about the centre that is as steep as this one at a value."""
        away = abs(value - self.centre) / self.sigma
        return (1.0 if self._usual(away) else (USUAL / away) ** 2) / self.sigma**2

    def _usual(self, away: float) -> bool:
        return self.shape or self.declared or away <= USUAL


PLACE = frozenset({"x", "y"})
"""Shapes of an effect that may be anywhere on the plate, m."""


@dataclass(frozen=True)
class EffectCard:
    """A candidate for what a twin lacks.

    Attributes
    ----------
    name : str
        As in files.
    summary : str
        What it is, in one line, for people.
    parameters : tuple of Parameter
        All zero (shapes anything) is the plate without the effect.
    needs : str
        What a campaign must hold to show it.
    separated_by : str
        The measurement that distinguishes it from effects with similar signatures.
    sites : tuple of mapping
        Values of the shapes from which a search starts; one empty mapping where there is no shape.
    closer_sites : tuple of mapping
        Places closer together, for changes too large to be searched from `sites`; empty where those do.
    at_a_place : tuple of mapping
        Values of the other shapes of an effect with a place, from which it is searched where another effect
        stands; empty for those of `sites`.
    after : str
        Effect that must be on before this one is a candidate: its first of two alike; empty for all others.
    form : float
        Share of the effect's signal by which a real one may differ from the formula, which only sketches its form
        (round spots for damage of any outline): what is left of that share is no further effect.
    levels : int
        Fewest levels of the drive with which a campaign shows it.
    replaces : str
        Declared quantity that this effect is beyond its tolerance; empty for all others.
    title : str
        Its name for people, a noun without article; empty for the name itself.
    phrase : str
        What was found, for people, the name of each parameter in braces where its value stands; empty for the
        title and a list of all values.
    """

    name: str
    summary: str
    parameters: tuple[Parameter, ...]
    needs: str
    separated_by: str
    sites: tuple[Values, ...] = field(default=({},))
    replaces: str = ""
    title: str = ""
    phrase: str = ""
    closer_sites: tuple[Values, ...] = ()
    at_a_place: tuple[Values, ...] = ()
    after: str = ""
    form: float = 0.0
    levels: int = 1

    def __post_init__(self) -> None:
        names = [p.name for p in self.parameters]
        if not names or len(set(names)) != len(names):
            raise ValueError(
                f"effect {self.name}: parameters {names} must be at least one, each with its own name"
            )
        if not self.amplitudes:
            raise ValueError(f"effect {self.name}: every parameter is a shape; nothing can be screened")
        said = [field for _, field, _, _ in Formatter().parse(self.phrase) if field is not None]
        if said and set(said) != set(names):
            raise ValueError(f"effect {self.name}: its phrase gives {said}; all of {names} are wanted, no others")
        shapes = {p.name for p in self.parameters if p.shape}
        for site in (*self.sites, *self.closer_sites):
            if set(site) != shapes:
                raise ValueError(
                    f"effect {self.name}: site {dict(site)} must give exactly the shapes {sorted(shapes)}"
                )
        for one in self.at_a_place:
            if set(one) != shapes - PLACE or not self.placed:
                raise ValueError(
                    f"effect {self.name}: at a place {dict(one)} must give exactly the shapes "
                    f"{sorted(shapes - PLACE)}, and x and y must be shapes"
                )

    @property
    def said(self) -> str:
        """Its name for people."""
        return self.title or self.name.replace("_", " ")

    @property
    def amplitudes(self) -> tuple[Parameter, ...]:
        """The parameters that are zero where the effect is absent."""
        return tuple(p for p in self.parameters if not p.shape)

    @property
    def placed(self) -> bool:
        """Whether it may be anywhere on the plate."""
        return {p.name for p in self.parameters if p.shape} >= PLACE

    def zero(self, site: Values | None = None) -> dict[str, float]:
        """Return values at which the effect is absent: amplitudes zero, shapes of `site` or typical."""
        return {p.name: (site or {}).get(p.name, p.typical) if p.shape else 0.0 for p in self.parameters}
