"""Transfer of the simulated rig's plate at a steady temperature: its twin, with effects or without."""

from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from analysis.arrays import Complex, Real
from analysis.local_laws import LocalLaws
from analysis.material import MaterialLaws
from analysis.sweep_point import SweepPoint
from analysis.twin_model import Effects
from simulation.twin.reduced_plate import ReducedPlate
from simulation.twin.twin import Twin

Followed = frozenset[Literal["rate", "level"]]


class PlateTransfer(Protocol):
    """Outputs per unit of the input: sensor volts per volt on the actuator patch, in most campaigns."""

    @property
    def band(self) -> tuple[float, float]:
        """Where it is certified, Hz; it answers a little outside too."""
        ...

    @property
    def outputs(self) -> int:
        """Number of outputs K."""
        ...

    @property
    def follows(self) -> Followed:
        """What of a `SweepPoint` may matter besides its temperature."""
        ...

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """Transfer (K, F) over `frequency` (F,), Hz; ValueError outside the laws' range."""
        ...


@dataclass(frozen=True)
class TwinTransfer:
    """The twin, some effects on; strain energies are counted already (`Twin.referred`) where any asks.

    A `SweepPoint`'s temperature is what a sensor on the plate would read, the rig's own thermal lag in it; its
    rate is that temperature's. So `thermal_lag` comes on top: the plate behind its own sensor.
    """

    twin: Twin[ReducedPlate]
    laws: MaterialLaws
    effects: Effects = field(default_factory=dict)

    @property
    def band(self) -> tuple[float, float]:
        """The twin's."""
        return self.twin.band

    @property
    def outputs(self) -> int:
        """Number of outputs."""
        return self.twin.outputs

    @property
    def follows(self) -> Followed:
        """Effects, a user's own among them, may follow rate and level; the plate as declared does not."""
        return frozenset({"rate", "level"}) if self.effects else frozenset()

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """`Twin.uncertified_frf` with the laws expanded about the temperature that the plate then has.

        Frequencies just outside the band are asked for, too.
        """
        return self.twin.uncertified_frf(self.local_laws(point), frequency, self.effects, point)

    def local_laws(self, point: SweepPoint) -> LocalLaws:
        """Return the laws near the plate's mean temperature; ValueError where they do not reach."""
        return self.laws.local(self.mean_temperature(point))

    def mean_temperature(self, point: SweepPoint) -> float:
        """Of the plate at one sweep, degrees Celsius."""
        steady = {name: v for name, v in self.effects.items() if not self.twin.library[name].needs_strain_energy}
        if not steady:
            return point.temperature
        near = self.laws.local(point.temperature)
        return float(self.twin.state(near, np.array(self.band), steady, point).mean_temperature)
