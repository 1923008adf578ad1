"""What a specimen answers with something hidden in it, as its rig and the effects' sizes ask for it."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from analysis.arrays import Complex, Real
from analysis.sweep_point import SweepPoint
from app.rig.plate_transfer import Followed, PlateTransfer, TwinTransfer

FOLLOWING: Mapping[str, Followed] = {
    "thermal_lag": frozenset({"rate"}),
    "amplitude_softening": frozenset({"level"}),
}
"""Effects that look at more than the temperature."""


class KnownTransfer(TwinTransfer):
    """Effects of which is known what they follow: fewer answers need to be computed."""

    @property
    def follows(self) -> Followed:
        """What any of the effects follows."""
        return frozenset().union(*(FOLLOWING.get(name, frozenset()) for name in self.effects))


@dataclass(frozen=True)
class OneInput:
    """A plate with several inputs as a rig sees it that drives one of them.

    Attributes
    ----------
    plate : PlateTransfer
    source : int
        The input.
    louder : float
        Its gain over that of the first input: levels are counted by the first's.
    """

    plate: PlateTransfer
    source: int
    louder: float

    @property
    def band(self) -> tuple[float, float]:
        """The plate's."""
        return self.plate.band

    @property
    def outputs(self) -> int:
        """Number of sensors."""
        return self.plate.outputs

    @property
    def follows(self) -> Followed:
        """What the plate follows."""
        return self.plate.follows

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """Transfer (K, F)."""
        return self.plate(replace(point, source=self.source, level=point.level * self.louder), frequency)
