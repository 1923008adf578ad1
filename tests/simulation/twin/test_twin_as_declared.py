"""Volts in, volts out: against direct solution, and the sensitivities against differences."""

from dataclasses import replace

import numpy as np
import pytest

from analysis.material import LocalLaws
from simulation.shell.electric_load import ElectricLoad
from simulation.twin.declared_plate import DeclaredPlate
from simulation.twin.instruments import Instruments
from simulation.twin.twin import Twin

LOAD = ElectricLoad(305e3, 120e-12)
MATERIAL = (2.1e9, 0.372, 0.071)
LAWS = LocalLaws.of_material(*MATERIAL)
SCALE = np.array([MATERIAL[0], 1.0, MATERIAL[2]])[:, None, None]
"""Derivatives are by log E, nu and log eta."""


@pytest.fixture(scope="module")
def twin(coarse):
    return Twin(DeclaredPlate(coarse), Instruments.of_patches(0, (1, 2), LOAD))


def test_voltages_equal_direct_solution(coarse_model, twin):
    lines = np.array([120.0, 288.0, 640.0])
    full = coarse_model.frf(*MATERIAL, lines, actuator=0, sensors=(1, 2), load=LOAD)
    answer = twin.frf(LAWS, lines)
    assert answer.shape == (2, 3)
    assert np.abs(answer - full).max() < 2e-4 * np.sqrt(np.mean(np.abs(full) ** 2))


def test_connecting_a_second_sensor_changes_the_first(coarse):
    lines = np.linspace(100.0, 700.0, 80)
    alone = Twin(DeclaredPlate(coarse), Instruments.of_patches(0, (1,), LOAD)).frf(LAWS, lines)[0]
    together = Twin(DeclaredPlate(coarse), Instruments.of_patches(0, (1, 2), LOAD)).frf(LAWS, lines)[0]
    change = np.abs(together - alone).max() / np.abs(alone).max()
    assert 1e-5 < change < 0.05


def test_sensors_can_be_listed_in_any_order(coarse, twin):
    lines = np.linspace(100.0, 700.0, 5)
    swapped = Twin(DeclaredPlate(coarse), Instruments.of_patches(0, (2, 1), LOAD)).frf(LAWS, lines)
    assert np.allclose(swapped[::-1], twin.frf(LAWS, lines), rtol=1e-10)


def test_few_coordinates_answer_like_all(twin):
    lines = np.linspace(100.0, 700.0, 300)
    few, all_of_them = (t.frf(LAWS, lines) for t in (twin, replace(twin, reach=np.inf)))
    assert np.abs(few - all_of_them).max() < 1e-5 * np.abs(all_of_them).max()


def test_effects_on_the_plate_are_refused_of_a_plate_as_declared(twin):
    state = twin.state(LAWS, np.array([200.0]))
    with pytest.raises(ValueError, match="thickness: this twin holds the plate as declared only"):
        twin.plate.require(state.with_(thickness=1.1 * state.thickness))


@pytest.mark.parametrize("index", [0, 1, 2])
def test_sensitivities_equal_central_differences(twin, index):
    """Richardson's combination of two steps: fourth order, so that rounding and truncation stay below 1e-6."""
    lines = np.linspace(100.0, 700.0, 300)
    twin = replace(twin, reach=np.inf)
    line = twin.linearise(LAWS, lines)
    value, slopes = line.transfer, line.by_material / SCALE
    assert np.allclose(value, twin.frf(LAWS, lines), rtol=1e-10)

    def central(step):
        up, down = list(MATERIAL), list(MATERIAL)
        up[index] += step
        down[index] -= step
        one, other = (twin.frf(LocalLaws.of_material(*there), lines) for there in (up, down))
        return (one - other) / (2 * step)

    step = 2e-4 * MATERIAL[index]
    expected = (4 * central(step) - central(2 * step)) / 3
    assert slopes.shape == (3, 2, 300)
    assert np.abs(slopes[index] - expected).max() < 1e-6 * np.abs(expected).max()


def elastic_modes(twin, e, nu, eta):
    """Natural frequencies, Hz, and loss factors up to the band's end: a pole is w_n**2 (1 + j eta_n)."""
    poles = twin.plate.reduced.modal_form(e, nu, eta).damped_poles()
    poles = poles[poles.real < (2 * np.pi * twin.band[1]) ** 2]
    return np.sqrt(poles.real) / (2 * np.pi), poles.imag / poles.real


def test_modes_are_the_plates(coarse_model, twin):
    frequency, loss = elastic_modes(twin, *MATERIAL)
    full = coarse_model.eigenfrequencies(*MATERIAL[:2], 25)[6:]
    inside = full[(full > 100.0) & (full < 700.0)]
    found = frequency[(frequency > 100.0) & (frequency < 700.0)]
    assert found == pytest.approx(inside, rel=1e-3)  # damping couples modes a little: the patches have none
    assert np.all((loss > 0.9 * MATERIAL[2]) & (loss < MATERIAL[2]))


def test_scaling_law_of_a_bare_like_plate(twin):
    """Stiffer by s, and patches aside: frequencies rise, at most by the square root of s."""
    low, high = (elastic_modes(twin, e, 0.38, 0.05)[0] for e in (1.6e9, 2.4e9))
    count = high.size
    ratio = high / low[:count]
    assert np.all((ratio < 1.5**0.5) & (ratio > 0.93 * 1.5**0.5))


def test_box_band_and_error_are_the_reduced_models(coarse, twin):
    assert (twin.box, twin.band, twin.error) == (coarse.box, coarse.band, coarse.error)
    with pytest.raises(ValueError, match="loss_factor"):
        twin.frf(LocalLaws.of_material(2e9, 0.38, 0.5), [200.0])
    with pytest.raises(ValueError, match="frequency"):
        twin.linearise(LAWS, [2000.0])


@pytest.mark.parametrize(("actuator", "sensors"), [(0, ()), (0, (0, 1)), (3, (1,)), (0, (-1,))])
def test_wrong_patches_are_refused(coarse, actuator, sensors):
    with pytest.raises(ValueError, match=r"twin|instruments"):
        Twin(DeclaredPlate(coarse), Instruments.of_patches(actuator, sensors, LOAD))
