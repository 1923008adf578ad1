"""What the simulated rig's plate answers at a steady temperature: the plain twin, or the one with effects."""

from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from analysis.gap.model import Effects, SweepPoint
from analysis.local_laws import LocalLaws
from analysis.material import MaterialLaws
from simulation.twin.effect_twin import EffectTwin
from simulation.twin.plain_twin import Twin

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Followed = frozenset[Literal["rate", "level"]]


class Transfer(Protocol):
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
class PlainTransfer:
    """The twin of the plate as declared."""

    twin: Twin
    laws: MaterialLaws

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
        """Nothing: only the temperature counts."""
        return frozenset()

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """`Twin.uncertified_frf`: frequencies just outside the band are asked for, too."""
        material = self.laws.at(point.temperature)
        constants = (
            float(material.youngs_modulus[0]),
            float(material.poisson_ratio[0]),
            float(material.loss_factor[0]),
        )
        return self.twin.uncertified_frf(*constants, frequency)


@dataclass(frozen=True)
class EffectTransfer:
    """The twin with some effects on; strain energies are counted already (`EffectTwin.referred`) where any asks.

    A `SweepPoint`'s temperature is what a sensor on the plate would read, the rig's own thermal lag in it; its
    rate is that temperature's. So `thermal_lag` comes on top: the plate behind its own sensor.
    """

    twin: EffectTwin
    laws: MaterialLaws
    effects: Effects

    @property
    def band(self) -> tuple[float, float]:
        """The twin's."""
        return self.twin.operators.band

    @property
    def outputs(self) -> int:
        """Number of outputs."""
        return len(self.twin.experiment.outputs)

    @property
    def follows(self) -> Followed:
        """Effects, a user's own among them, may follow rate and level."""
        return frozenset({"rate", "level"})

    def __call__(self, point: SweepPoint, frequency: Real) -> Complex:
        """`EffectTwin.frf` with the laws expanded about the temperature that the plate then has."""
        return self.twin.frf(point, self.local_laws(point), self.effects, frequency)

    def local_laws(self, point: SweepPoint) -> LocalLaws:
        """Return the laws near the plate's mean temperature; ValueError where they do not reach."""
        return self.laws.local(self.mean_temperature(point))

    def mean_temperature(self, point: SweepPoint) -> float:
        """Of the plate at one sweep, degrees Celsius."""
        steady = {name: v for name, v in self.effects.items() if not self.twin.library[name].needs_strain_energy}
        near = self.laws.local(point.temperature)
        return float(self.twin.state(point, near, steady, np.array(self.band)).mean_temperature)
