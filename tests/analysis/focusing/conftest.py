"""A simply supported Kirchhoff plate in closed form, driven by point forces."""

from dataclasses import dataclass

import numpy as np
import pytest

from analysis.experiment import Patch, Plate
from analysis.focusing.energy import FieldSpace
from analysis.focusing.grid import Grid
from analysis.focusing.panel import Filters, Panel, Target


@dataclass(frozen=True)
class SupportedPlate:
    """Modes sin(mπx/Lx) sin(nπy/Ly) of a thin plate, `modes` along each side."""

    panel: Panel
    modes: int = 6

    def shapes(self, points):
        x, y = np.asarray(points).T
        plate = self.panel.plate
        order = np.arange(1, self.modes + 1)
        along_x = np.sin(np.pi * np.outer(x, order) / plate.length_x)
        along_y = np.sin(np.pi * np.outer(y, order) / plate.length_y)
        scale = 2.0 / np.sqrt(plate.mass)  # mass-normalised
        return scale * (along_x[:, :, None] * along_y[:, None, :]).reshape(len(x), -1)

    def eigenvalues(self, youngs_modulus, poisson_ratio=0.33, loss_factor=0.06):
        plate = self.panel.plate
        rigidity = youngs_modulus * plate.thickness**3 / 12.0 / (1.0 - poisson_ratio**2)
        order = np.arange(1, self.modes + 1)
        wavenumber = (np.pi * order[:, None] / plate.length_x) ** 2 + (np.pi * order[None] / plate.length_y) ** 2
        mass = plate.density * plate.thickness
        return (rigidity / mass * wavenumber.ravel() ** 2) * (1.0 + 1j * loss_factor)

    @property
    def forces(self):
        return self.shapes([patch.center for patch in self.panel.patch]).T

    def amplitudes(self, youngs_modulus, frequency, loss_factor=0.06):
        """(N, F, r), m per N."""
        eigenvalues = self.eigenvalues(youngs_modulus, loss_factor=loss_factor)
        dynamic = eigenvalues[None] - (2.0 * np.pi * np.asarray(frequency)[:, None]) ** 2
        return self.forces.T[:, None, :] / dynamic[None]

    @property
    def grid(self):
        return Grid.of(self.panel)

    @property
    def space(self):
        return FieldSpace.of(self.shapes(self.grid.points), self.grid)


def panel_of(centers, **filters):
    plate = Plate(length_x=0.24, length_y=0.19, thickness=0.003, mass=0.12996, boundary="clamped")
    patches = tuple(
        Patch(id=f"A{i}", role="actuator", center=c, size=(0.01, 0.01), thickness=5e-4)
        for i, c in enumerate(centers)
    )
    target = Target(center=(0.3, 0.55), size=(0.25, 0.3), displacement=1e-6)
    return Panel(title="test", plate=plate, patch=patches, target=target, filters=Filters(**filters))


SIX = ((0.05, 0.05), (0.06, 0.14), (0.11, 0.11), (0.16, 0.05), (0.17, 0.15), (0.2, 0.1))


@pytest.fixture(scope="session")
def supported():
    return SupportedPlate(panel_of(SIX))


@pytest.fixture(scope="session")
def make_panel():
    return panel_of


@pytest.fixture(scope="session")
def make_plate():
    return SupportedPlate


@pytest.fixture
def rng():
    return np.random.default_rng(20_240_607)
