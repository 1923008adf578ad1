"""Modes of a plate with its patches connected: those that identification finds in its FRF, and their limits."""

import numpy as np
import pytest

from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.material import LocalLaws, MaterialBox
from simulation.reduction.vectors.reduce import reduce
from simulation.shell.electric_load import ElectricLoad
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments
from simulation.twin.loaded_modes import LoadedModes
from simulation.twin.twin import Twin

LAWS = LocalLaws.of_material(2.1e9, 0.372, 0.02)
BAND = (100.0, 700.0)


@pytest.fixture(scope="module")
def reduced(coarse_model):
    return DeclaredPlate(reduce(coarse_model, MaterialBox((1.5e9, 3e9), (0.34, 0.42), (0.01, 0.1)), BAND)[0])


def poles(reduced, load):
    """Of the modes within the band, with the first sensor connected; and the twin itself."""
    twin = Twin(reduced, Instruments.of_patches(0, (1,), load))
    lines = np.array(BAND)
    solved = twin.solved(twin.state(LAWS, lines), lines)
    found = LoadedModes.of(solved, solved.modal, twin.instruments, reduced.capacitance).poles
    return found[(np.abs(found) > 2 * np.pi * BAND[0]) & (np.abs(found) < 2 * np.pi * BAND[1])], twin


@pytest.mark.parametrize("resistance", [np.inf, 305e3, 3e4])
def test_an_frf_shows_these_poles(reduced, resistance):
    found, twin = poles(reduced, ElectricLoad(resistance, 120e-12))
    short, _ = poles(reduced, ElectricLoad(1e-3))
    lines, rng = np.arange(BAND[0], BAND[1], 0.5), np.random.default_rng(1)
    h = twin.frf(LAWS, lines)
    noise = 1e-5 * np.sqrt(np.mean(np.abs(h) ** 2))  # without any the search takes long
    shown = identify(
        Measured(lines, h + noise * rng.standard_normal((1, lines.size, 2)).view(complex)[..., 0])
    ).poles
    distance = np.abs(shown[:, None] - found).min(axis=0) / np.abs(found)
    moved = np.abs(found - short) / np.abs(found)
    strong = np.argsort(moved)[-3:]
    assert moved[strong].min() > 8e-5
    assert (distance[strong] < 0.05 * moved[strong]).all()


def test_a_short_circuit_leaves_the_plate_alone(reduced):
    found, twin = poles(reduced, ElectricLoad(1e-3))
    squares = twin.solved(twin.state(LAWS, np.array(BAND)), np.array(BAND)).modal.poles
    nearest = np.abs(squares[:, None] + found**2).min(axis=0)
    assert (nearest < 1e-9 * np.abs(found) ** 2).all()
