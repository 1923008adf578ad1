"""Closed forms: a simply supported Kirchhoff plate driven by point forces, and laws by which it softens."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from analysis.experiment import Patch, Plate
from analysis.focusing.energy import FieldSpace, Grid
from analysis.focusing.panel import Filters, Panel, Target
from analysis.focusing.panel_model import PanelModes
from analysis.material import MaterialLaws


@dataclass(frozen=True)
class SupportedPlate:
    """Modes sin(mπx/Lx) sin(nπy/Ly) of a thin plate, `orders` along each side."""

    panel: Panel
    orders: int = 6

    def shapes(self, points):
        x, y = np.asarray(points).T
        plate = self.panel.plate
        order = np.arange(1, self.orders + 1)
        along_x = np.sin(np.pi * np.outer(x, order) / plate.length_x)
        along_y = np.sin(np.pi * np.outer(y, order) / plate.length_y)
        scale = 2.0 / np.sqrt(plate.mass)  # mass-normalised
        return scale * (along_x[:, :, None] * along_y[:, None, :]).reshape(len(x), -1)

    def eigenvalues(self, youngs_modulus, poisson_ratio=0.33, loss_factor=0.06):
        plate = self.panel.plate
        rigidity = youngs_modulus * plate.thickness**3 / 12.0 / (1.0 - poisson_ratio**2)
        order = np.arange(1, self.orders + 1)
        wavenumber = (np.pi * order[:, None] / plate.length_x) ** 2 + (np.pi * order[None] / plate.length_y) ** 2
        mass = plate.density * plate.thickness
        return (rigidity / mass * wavenumber.ravel() ** 2) * (1.0 + 1j * loss_factor)

    @property
    def forces(self):
        return self.shapes([patch.center for patch in self.panel.patch]).T

    def amplitudes(self, youngs_modulus, poisson_ratio, loss_factor, frequency):
        """(N, F, r), m per N."""
        eigenvalues = self.eigenvalues(youngs_modulus, poisson_ratio, loss_factor)
        dynamic = eigenvalues[None] - (2.0 * np.pi * np.asarray(frequency)[:, None]) ** 2
        return self.forces.T[:, None, :] / dynamic[None]

    def forms(self, youngs_modulus, poisson_ratio, loss_factor, frequency, displacement=1.0):
        fields = self.amplitudes(youngs_modulus, poisson_ratio, loss_factor, frequency)
        return self.space.forms([fields], displacement)

    def modes(self, youngs_modulus, poisson_ratio, loss_factor, count):
        eigenvalues = self.eigenvalues(youngs_modulus, poisson_ratio, loss_factor)
        lowest = np.argsort(eigenvalues.real)[:count]
        return PanelModes(eigenvalues[lowest], np.eye(len(eigenvalues))[:, lowest], self.forces[lowest])

    def restricted(self, basis):
        return RestrictedPlate(self, basis)

    @property
    def grid(self):
        return Grid.of(self.panel)

    @property
    def space(self):
        return FieldSpace.of(self.shapes(self.grid.points), self.grid)


@dataclass(frozen=True)
class RestrictedPlate:
    """Galerkin's method on the columns of a basis, by direct solution."""

    whole: SupportedPlate
    basis: np.ndarray

    @property
    def panel(self):
        return self.whole.panel

    @property
    def space(self):
        return self.whole.space.restricted(self.basis)

    def amplitudes(self, youngs_modulus, poisson_ratio, loss_factor, frequency):
        eigenvalues = self.whole.eigenvalues(youngs_modulus, poisson_ratio, loss_factor)
        stiffness = (self.basis.T * eigenvalues) @ self.basis
        dynamic = stiffness - (2.0 * np.pi * np.asarray(frequency)[:, None, None]) ** 2 * np.eye(len(stiffness))
        return np.linalg.solve(dynamic, self.basis.T @ self.whole.forces).transpose(2, 0, 1)

    def forms(self, youngs_modulus, poisson_ratio, loss_factor, frequency, displacement=1.0):
        fields = self.amplitudes(youngs_modulus, poisson_ratio, loss_factor, frequency)
        return self.space.forms([fields], displacement)


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
def six():
    return SIX


@pytest.fixture(scope="session")
def make_panel():
    return panel_of


@pytest.fixture(scope="session")
def make_plate():
    return SupportedPlate


@pytest.fixture
def rng():
    return np.random.default_rng(20_240_607)


@pytest.fixture(scope="session")
def softening():
    """E from 3.2 to 1.0 GPa, nu from 0.34 to 0.45, eta about 6 %, over 0 to 60 °C."""
    t = np.linspace(0.0, 60.0, 13)
    values = np.stack(
        [
            np.log(3.2e9) - 0.0195 * t,
            0.34 + 0.11 * (t / 60.0) ** 2,
            np.log(0.06 + 0.02 * np.exp(-(((t - 17.0) / 14.0) ** 2))),
        ]
    )
    splines = [make_interp_spline(t, row, k=3) for row in values]
    coefficients = np.array([spline.c for spline in splines])
    count = coefficients.shape[1]
    return MaterialLaws(splines[0].t, coefficients, np.zeros((3, count, count)), (0.0, 60.0))
