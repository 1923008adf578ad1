"""One sweep out of line is left out; effects, however large, are not."""

import numpy as np

from analysis.material import Material
from analysis.recordings.frf import Frf
from analysis.updated import Updated
from analysis.updating.update import outlier_sweeps

TEMPERATURE = np.concatenate([np.arange(0.0, 61.0, 4.0), np.arange(60.0, -1.0, -4.0)])
WAYS = ("up",) * 16 + ("down",) * 16


def campaign(temperature, ways, chi2) -> tuple[Frf, Updated]:
    count, lines = len(temperature), np.arange(100.0, 130.0)
    ones, shape = np.ones(count), (count, 1, lines.size)
    frf = Frf(
        temperature=temperature,
        direction=ways,
        level=ones,
        frequency=lines,
        h=np.ones(shape, dtype=complex),
        variance=np.ones(shape),
        coherence=np.ones(shape),
        excluded=np.zeros(lines.size, dtype=bool),
        channels=("S1",),
    )
    material = Material(2e9 * ones, 0.35 * ones, 0.05 * ones)
    unity = np.ones((count, 4, 4))
    ready = np.ones(count, dtype=bool)
    return frf, Updated(temperature, material, material, unity, 1.0, 0.0, ones, ones, ones, chi2, ready)


def test_one_bad_sweep_is_left_out_and_said() -> None:
    chi2 = np.full(32, 1.02)
    chi2[5] = 250.0
    frf, updated = campaign(TEMPERATURE, WAYS, chi2)
    assert outlier_sweeps(frf, updated) == [5]
    left = frf.without([5], "no plate explains it")
    assert left.h.shape[0] == len(left.direction) == 31
    assert left.notes == ("sweep at 20.0 °C (up, 1 V) left out: no plate explains it",)
    np.testing.assert_array_equal(left.temperature, np.delete(TEMPERATURE, 5))


def test_what_grows_with_temperature_is_an_effect() -> None:
    gradient = 1.0 + 3.0 * (TEMPERATURE - 22.0) ** 2
    assert outlier_sweeps(*campaign(TEMPERATURE, WAYS, gradient)) == []
    far_apart = np.array([0.0, 20.0, 40.0, 60.0])
    assert outlier_sweeps(*campaign(far_apart, ("up",) * 4, np.array([1.0, 400.0, 1.0, 1.0]))) == []


def test_a_wrong_plate_is_no_stray() -> None:
    assert outlier_sweeps(*campaign(TEMPERATURE, WAYS, np.full(32, 900.0))) == []
