"""A panel whose stiffness is known at every place: each part of it is as stiff as its temperature says."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from analysis.weather.family import WarmAnswer


@dataclass(frozen=True)
class WarmSupportedPlate:
    """Modes of a supported plate, coupled by K_ij = √(λ_i λ_j) ∫ φ_i φ_j E(T)/E dm."""

    plate: Any
    laws: Any

    @property
    def space(self):
        return self.plate.space

    @property
    def points(self):
        return self.plate.grid.points

    def tilted(self, temperature, across):
        xi, zeta = self.plate.panel.plate.normalised(self.points)
        return temperature + 0.5 * (across[0] * xi + across[1] * zeta)

    def answer(self, temperature, frequency):
        material = self.laws.at(temperature)
        nu, eta = float(material.poisson_ratio.mean()), float(material.loss_factor.mean())
        root = np.sqrt(self.plate.eigenvalues(1.0, nu, 0.0).real)
        shapes = self.plate.shapes(self.points)
        mass = self.plate.panel.plate.mass / len(self.points)
        stiffness = (
            (shapes.T * (mass * material.youngs_modulus)) @ shapes * np.outer(root, root) * (1.0 + 1j * eta)
        )
        omega = 2.0 * np.pi * np.asarray(frequency)
        dynamic = stiffness - (omega**2)[:, None, None] * np.eye(len(root))
        forces = self.plate.forces
        found = np.linalg.solve(dynamic, np.broadcast_to(forces, (len(omega), *forces.shape)))
        amplitude = found.transpose(2, 0, 1)
        return WarmAnswer(amplitude, (amplitude @ forces).transpose(2, 0, 1))


@pytest.fixture(scope="session")
def warm(make_plate, make_panel, six, softening):
    settings = {"taps": 128, "sample_rate": 11_025.0, "delay": 64, "transform_length": 1_024}
    plate = make_plate(make_panel(six, band=(100.0, 500.0), edges=(60.0, 560.0), **settings))
    return WarmSupportedPlate(plate, softening)
