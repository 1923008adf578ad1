"""Energies of a panel's twin, with and without dashpots, against those of its equations solved line by line."""

import numpy as np
import pytest

from analysis.focusing.energy import Grid
from analysis.material import MaterialBox
from app.files.declarations.panel import SECTION_2, read_panel
from app.twins.panel_twin import PanelTwin
from simulation.reduction.reduced_model import ReducedModel
from simulation.shell.rigidity import plane_stress_moduli

MATERIAL = (2.0e9, 0.35, 0.05)
LINES = np.linspace(20.0, 90.0, 70)


@pytest.mark.parametrize("damped", [False, True])
def test_energies_are_those_of_the_solved_fields(damped: bool) -> None:
    """Poles are no answer to dashpots: with them the energies are taken from the fields."""
    rng, size = np.random.default_rng(8), 7
    grid = Grid.of(read_panel(SECTION_2))
    squares = (2.0 * np.pi * np.geomspace(15.0, 400.0, size)) ** 2 / plane_stress_moduli(*MATERIAL[:2])[0]
    turned, _ = np.linalg.qr(rng.standard_normal((size, size)))
    patch = rng.standard_normal((size, 2)) * 60.0
    dashpots = rng.standard_normal((size, 2)) * 4.0 if damped else np.zeros((size, 0))
    reduced = ReducedModel(
        stiffness_1=(turned * squares) @ turned.T,
        stiffness_2=np.zeros((size, size)),
        stiffness_patch=patch @ patch.T,
        coupling=rng.standard_normal((size, 2)),
        capacitance=np.ones(2),
        box=MaterialBox((1e9, 3e9), (0.3, 0.4), (0.01, 0.1)),
        band=(10.0, 100.0),
        error=0.0,
        dashpots=dashpots,
        deflection=rng.standard_normal((len(grid.points), size)),
        points=grid.points,
    )
    found = PanelTwin.of(reduced, grid).forms(*MATERIAL, LINES, 1e-6)
    stiffness, damping = reduced.stiffness(*MATERIAL), dashpots @ dashpots.T
    for line, frequency in enumerate(LINES):
        w = 2.0 * np.pi * frequency
        field = -reduced.deflection @ np.linalg.solve(
            stiffness + 1j * w * damping - w**2 * np.eye(size), reduced.coupling
        )
        plate = field.conj().T @ (grid.area[:, None] * field)
        target = field.conj().T @ ((grid.area * grid.target)[:, None] * field)
        np.testing.assert_allclose(found.plate[0, line], plate, rtol=1e-9, atol=1e-9 * np.abs(plate).max())
        np.testing.assert_allclose(found.target[0, line], target, rtol=1e-9, atol=1e-9 * np.abs(target).max())
        aim = 1e-6 * field.conj().T @ (grid.area * grid.target)
        np.testing.assert_allclose(found.aim[0, line], aim, rtol=1e-9, atol=1e-9 * np.abs(aim).max())
