"""Lines solved by iteration in the modes of their mean, against factorizing each."""

from collections.abc import Callable

import numpy as np
import pytest

from analysis.arrays import Complex, Real
from analysis.material import LocalLaws
from simulation.reduction.composition import Composite
from simulation.reduction.effect_operators import EffectOperators
from simulation.state.plate_state import PlateState
from simulation.twin import local_solution
from simulation.twin.local_plate import LocalPlate
from simulation.twin.local_solution import LineSolver, solved_by_lines

SIZE = 12
LINES = np.linspace(100.0, 700.0, 61)


def plate(rng: np.random.Generator, one_loss: bool) -> LocalPlate:
    """Resonances over the band and beyond, patches that couple them, and dashpots of no particular place."""
    turned = np.linalg.qr(rng.standard_normal((SIZE, SIZE)))[0]
    stiffness = turned * (2 * np.pi * np.geomspace(90.0, 3000.0, SIZE)) ** 2 @ turned.T
    root = rng.standard_normal((SIZE, 3))
    patches = 0.03 * (2 * np.pi * 400.0) ** 2 * root @ root.T
    local = rng.standard_normal((SIZE, SIZE))
    loss = 0.06 * stiffness if one_loss else 0.06 * stiffness + 20.0 * local @ local.T
    normal = np.eye(SIZE) + 0.1 * (local + local.T) / np.sqrt(SIZE)
    composite = Composite(stiffness, loss, patches, np.eye(SIZE), rng.standard_normal((SIZE, 2)))
    no_operators: EffectOperators = None  # type: ignore[assignment]
    return LocalPlate(np.eye(SIZE), composite, normal, no_operators)


def varying_state(amount: float, rng: np.random.Generator) -> PlateState:
    laws = LocalLaws.of_material(2e9, 0.38, 0.06)
    return PlateState.baseline(np.zeros(1), np.zeros(1), laws, 20.0, LINES).with_(
        storage=1.0 - amount * rng.random(LINES.size),
        loss=1.0 + amount * rng.random(LINES.size),
        area_mass=0.2 * amount * rng.random(LINES.size),
        area_resistance=30.0 * amount * rng.random(LINES.size),
    )


def impedance(local: LocalPlate, state: PlateState, dashpots: Real, line: int) -> Complex:
    """Z of one line, from its definition."""
    omega = 2 * np.pi * LINES[line]
    z = state.storage[line] * local.composite.plate + 1j * state.loss[line] * local.composite.plate_loss
    z = z + local.composite.fixed - omega**2 * np.eye(SIZE) + 1j * omega * dashpots
    z = z + (1j * omega * state.area_resistance[line] - omega**2 * state.area_mass[line]) * local.normal
    return np.asarray(z)


@pytest.fixture
def dashpots(monkeypatch: pytest.MonkeyPatch) -> Callable[[float], Real]:
    """Give every plate a damping matrix of rank one and of given strength."""

    def of(strength: float) -> Real:
        row = np.random.default_rng(6).standard_normal((SIZE, 1))
        matrix = strength * row @ row.T
        monkeypatch.setattr(LocalPlate, "dashpots", lambda *_: matrix)
        return matrix

    return of


@pytest.mark.parametrize("one_loss", [True, False])
@pytest.mark.parametrize("amount", [0.0, 0.02, 0.5])
def test_every_line_is_solved_to_rounding(
    amount: float, one_loss: bool, dashpots: Callable[[float], Real]
) -> None:
    """At 0.5 the iteration does not converge everywhere: lines are factorized, too."""
    rng = np.random.default_rng(5)
    local, damping = plate(rng, one_loss), dashpots(3.0 * amount)
    state = varying_state(amount, rng)
    solver = LineSolver.of(local, state, LINES)
    some = np.arange(LINES.size)[::-3]
    right = rng.standard_normal((SIZE, some.size)) + 1j * rng.standard_normal((SIZE, some.size))
    found = solver.back(solver.solve(solver.weights(state), solver.into(right), some))
    for k, line in enumerate(some):
        wanted = np.linalg.solve(impedance(local, state, damping, line), right[:, k])
        assert np.abs(found[:, k] - wanted).max() < 1e-11 * np.abs(wanted).max()


@pytest.mark.parametrize("one_loss", [True, False])
@pytest.mark.parametrize("amount", [0.02, 0.5])
def test_every_port_is_solved_at_all_lines_in_parts(
    amount: float, one_loss: bool, dashpots: Callable[[float], Real], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(local_solution, "LINES_OF_ONE_MEAN", 25)
    rng = np.random.default_rng(7)
    local, damping = plate(rng, one_loss), dashpots(3.0 * amount)
    state = varying_state(amount, rng)
    found = solved_by_lines(local, state, LINES)
    assert found.shape == (SIZE, 2, LINES.size)
    for line in range(LINES.size):
        wanted = np.linalg.solve(impedance(local, state, damping, line), local.composite.coupling)
        assert np.abs(found[..., line] - wanted).max() < 1e-11 * np.abs(wanted).max()
