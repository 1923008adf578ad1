"""Pictures of a campaign that two inputs drove in turn: no FRF of one stands under the name of the other."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from numpy.typing import NDArray

from analysis.material import Material
from analysis.recordings.frf import Frf
from analysis.updated import Updated
from app.files.results.laws_file import TwinFrf
from app.report import measured

TEMPERATURE = np.repeat([0.0, 10.0, 20.0, 30.0, 40.0], 2)
SOURCE = np.tile([0, 1], 5)
FREQUENCY = np.linspace(100.0, 900.0, 81)


@pytest.fixture
def frf() -> Frf:
    rng = np.random.default_rng(2)
    h = (10.0**SOURCE)[:, None, None] * np.exp(2j * np.pi * rng.random((10, 1, 81)))
    return Frf(
        temperature=TEMPERATURE, direction=("up",) * 10, level=np.ones(10), frequency=FREQUENCY, h=h,
        variance=np.full(h.shape, 1e-4), coherence=np.full(h.shape, 0.99), excluded=np.zeros(81, dtype=bool),
        channels=("S1",), labels=("S1/A1 [V/V]", "S1/hammer [V/N]"), units=("V/V", "V/N"),
        source=SOURCE, sources=("A1", "hammer"),
    )  # fmt: skip


@pytest.fixture
def estimates() -> Updated:
    one = np.ones(10)
    material = Material(one, 0.3 * one, 0.05 * one)
    share = 0.01 * np.arange(1.0, 11.0)
    return Updated(TEMPERATURE, material, material, np.zeros((10, 4, 4)), 1.0, 0.0, share, share, 0.5 * share,
                   one, one > 0.0, further=np.array([[2.0, 0.0]]))  # fmt: skip


def drawn(figure: Figure, axes: int, label: str) -> NDArray[np.float64]:
    (line,) = (one for one in figure.axes[axes].lines if one.get_label() == label)
    return np.asarray(line.get_ydata())


@pytest.mark.parametrize(("source", "label"), [(0, "S1/A1 [V/V]"), (1, "S1/hammer [V/N]")])
def test_overlays_and_waterfall_are_of_one_input(frf: Frf, estimates: Updated, source: int, label: str) -> None:
    twin = TwinFrf(FREQUENCY, 1.01 * frf.h, 1e-4, 950.0)
    figure = measured.overlays(frf, twin, estimates, source=source)
    for column, temperature in enumerate((0.0, 20.0, 40.0)):
        (row,) = np.flatnonzero((temperature == TEMPERATURE) & (source == SOURCE))
        np.testing.assert_array_equal(drawn(figure, column, "measured"), np.abs(frf.h[row, 0]))
        np.testing.assert_array_equal(drawn(figure, column, "updated twin"), np.abs(twin.h[row, 0]))
        assert f"misfit {100 * estimates.misfit[row]:.2f} %" in figure.axes[column].get_title()
    assert figure.axes[0].get_ylabel() == f"|H| {label}"
    lines = measured.waterfall(frf.of_source(source))
    np.testing.assert_allclose(drawn(lines, 1, "20.0 °C"), 20.0 * source, atol=1e-9)


def test_misfit_has_a_line_for_each_input(frf: Frf, estimates: Updated) -> None:
    figure = measured.misfit(estimates, frf)
    for source, name in enumerate(("A1", "hammer")):
        own = source == SOURCE
        np.testing.assert_array_equal(
            drawn(figure, 0, f"updated twin, {name} driven"), 100 * estimates.misfit[own]
        )
        floor = drawn(figure, 0, f"noise of the measurement, {name} driven")
        np.testing.assert_array_equal(floor, 100 * estimates.noise_floor[own])
