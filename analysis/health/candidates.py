"""Changes of a panel that are looked for, each as one amplitude at one place."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from analysis.effect_card import EffectCard, Parameter, Values
from analysis.twin_model import Effects, Tangent

FAMILIES = {
    "bond_shear_lag": "bond",
    "patch_debond": "bond",
    "local_damage": "damage",
    "mass_at_place": "mass",
    "spring_at_place": "support",
    "suspension": "support",
    "elastic_foundation": "support",
}
"""Effects of the library that can come with time on a panel that was healthy, and what they are counted as. All
others belong to the plate as it was made, to the oven or to the electronics: the baseline has them already."""
DEPOLARIZATION = "depolarization"
"""Family, and name, of a patch that has lost polarization: a factor on all that it drives or gives."""
EITHER_WAY = ("suspension",)
"""Effects whose amplitude may also fall below that of the baseline: a string that has come loose."""
WORDS = {
    "bond": "softer bond",
    "depolarization": "lost polarization",
    "damage": "local damage",
    "mass": "added mass",
    "support": "changed support",
    "unknown": "a change that no effect explains",
}
"""Families for people."""


@dataclass(frozen=True)
class ChangeCandidate:
    """One amplitude that is zero in the baseline.

    Attributes
    ----------
    effect : str
        Of the library, or `DEPOLARIZATION`.
    parameter : Parameter
        The amplitude; of `DEPOLARIZATION` the share that the patch has lost.
    shapes : mapping
        Values of the effect's shapes: its place, if it has one.
    patch : str
        That lost polarization; empty for effects of the library.
    card : EffectCard or None
        Of the effect; None for `DEPOLARIZATION`.
    """

    effect: str
    parameter: Parameter
    shapes: Values = field(default_factory=dict)
    patch: str = ""
    card: EffectCard | None = field(default=None, repr=False)

    @property
    def family(self) -> str:
        """As what it is named."""
        return FAMILIES.get(self.effect, DEPOLARIZATION)

    @property
    def two_sided(self) -> bool:
        """Whether the amplitude may be negative, too."""
        return self.effect in EITHER_WAY

    @property
    def placed(self) -> bool:
        """Whether it has a place that is to be found."""
        return {"x", "y"} <= set(self.shapes)

    @property
    def title(self) -> str:
        """Name for people, with the patch if it is that of one."""
        if self.card is None:
            return f"{WORDS[self.family]} of {self.patch}"
        of_patch = f" of {self.parameter.name}" if self.effect == "patch_debond" else ""
        return f"{WORDS[self.family]}{of_patch}" if self.family == "bond" else WORDS[self.family]

    @property
    def tangent(self) -> Tangent | None:
        """How a twin is differentiated by it; None for `DEPOLARIZATION`."""
        return None if self.card is None else (self.effect, self.parameter.name, self.values(0.0))

    def values(self, amplitude: float, shapes: Values | None = None) -> dict[str, float]:
        """Values of all the effect's parameters with an amplitude, in SI units."""
        zero = {} if self.card is None else self.card.zero({**self.shapes, **(shapes or {})})
        return {**zero, self.parameter.name: amplitude}


def change_candidates(
    cards: Mapping[str, EffectCard], on: Effects, patches: tuple[str, ...]
) -> list[ChangeCandidate]:
    """List all candidates of a panel.

    Parameters
    ----------
    cards : mapping of str to EffectCard
        Of its twin.
    on : mapping
        Effects of the baseline; these are no candidates, for the twin is not linear about zero there.
    patches : tuple of str
        Patches that drive or are read.
    """
    found = [
        ChangeCandidate(name, parameter, dict(site), "", card)
        for name, card in cards.items()
        if name in FAMILIES and name not in on
        for site in card.sites
        for parameter in card.amplitudes
    ]
    lost = Parameter("lost", "1", 0.0, 0.9, 0.1, shown="%")
    return [*found, *(ChangeCandidate(DEPOLARIZATION, lost, {}, patch) for patch in patches)]
