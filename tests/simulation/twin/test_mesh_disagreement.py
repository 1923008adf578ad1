"""The difference of two computations of one plate, as a share of the response."""

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from analysis.gap.model import SweepPoint
from analysis.local_laws import LocalLaws
from simulation.twin.mesh_disagreement import mesh_disagreement

FREQUENCY = np.linspace(100.0, 1000.0, 400)
MATERIALS = [(3e9, 0.35, 0.05), (1e9, 0.42, 0.05)]


@dataclass
class OneMode:
    """A resonance at 400 Hz for E = 2 GPa, whose stiffness is off by a share that grows as the plate softens."""

    off: float = 0.0

    def frf(self, e: float, nu: float, eta: float, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        stiffness = 400.0**2 * e / 2e9 * (1.0 + self.off * 2e9 / e)
        return (1e5 / (stiffness * (1.0 + 1j * eta) - frequency**2))[None]


@dataclass
class WithEffects:
    """The same as the gap workflow asks for it."""

    plate: OneMode

    def frf(self, point: SweepPoint, laws: LocalLaws, effects: object, frequency: NDArray[np.float64]):
        assert point.temperature == laws.reference
        assert not effects
        return self.plate.frf(np.exp(laws.value[0]), laws.value[1], np.exp(laws.value[2]), frequency)


def test_equal_plates_do_not_differ() -> None:
    assert mesh_disagreement(OneMode(), WithEffects(OneMode()), MATERIALS, FREQUENCY) == pytest.approx(
        0.0, abs=1e-9
    )


def test_a_shifted_resonance_counts_by_its_half_width_where_it_is_worst() -> None:
    """A stiffness off by s << eta changes a resonance by s/eta, times 1/sqrt(2) as rms along a Lorentzian."""
    off = 5e-4
    found = mesh_disagreement(OneMode(), WithEffects(OneMode(off)), MATERIALS, FREQUENCY)
    assert found == pytest.approx(2.0 * off / 0.05 / np.sqrt(2.0), rel=0.1)
    stiff = mesh_disagreement(OneMode(), WithEffects(OneMode(off)), MATERIALS[:1], FREQUENCY)
    assert stiff == pytest.approx(found / 3.0, rel=0.15)
