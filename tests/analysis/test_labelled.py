"""FRFs, modes and estimates as xarray and pandas take them."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest

from analysis import labelled
from analysis.labelled import LabelledArrays
from analysis.material import Material
from analysis.recordings.frf import Frf
from analysis.updated import Updated

LINES = np.array([100.0, 101.0, 102.0, 103.0])


@pytest.fixture
def frf() -> Frf:
    rng = np.random.default_rng(0)
    shape = (2, 3, 4)
    return Frf(
        temperature=np.array([10.0, 30.0]),
        direction=("up", "down"),
        level=np.array([1.0, 2.0]),
        frequency=LINES,
        h=rng.standard_normal(shape) + 1j * rng.standard_normal(shape),
        variance=rng.uniform(1.0, 2.0, shape),
        coherence=np.ones(shape),
        excluded=np.array([False, True, False, False]),
        channels=("a", "b", "c"),
        notes=("a note",),
        labels=("x",) * 6,
        units=("m/s/N",) * 6,
        source=np.array([0, 1]),
        sources=("near", "far"),
    )


def test_an_frf_of_xarray_is_found_by_its_coordinates(frf: Frf) -> None:
    pytest.importorskip("xarray")
    made = frf.to_xarray()
    assert complex(made.h.sel(channel="b", frequency=102.0)[1]) == frf.h[1, 1, 2]
    assert made.h.attrs["units"] == "m/s/N"
    assert made.temperature.attrs["units"] == "degC"
    assert made.drive.values.tolist() == ["near", "far"]
    assert made.attrs["notes"] == "a note"
    assert dict(made.sizes) == {"sweep": 2, "channel": 3, "frequency": 4}


def test_a_table_of_pandas_has_a_row_for_each_number(frf: Frf) -> None:
    pytest.importorskip("pandas")
    table = frf.to_pandas()
    assert len(table) == frf.h.size
    row = table[(table.temperature == 30.0) & (table.channel == "c") & (table.frequency == 101.0)]
    assert row.h.tolist() == [frf.h[1, 2, 1]]
    assert row.excluded.tolist() == [True]
    assert row.direction.tolist() == ["down"]
    assert table.attrs["units"]["frequency"] == "Hz"


def test_estimates_have_a_row_for_each_sweep() -> None:
    pytest.importorskip("pandas")
    ones = np.ones(2)
    material = Material(np.array([2e9, 1e9]), 0.4 * ones, 0.05 * ones)
    spread = Material(1e7 * ones, 1e-3 * ones, 1e-3 * ones)
    cold_and_warm = Updated(
        np.array([0.0, 50.0]), material, spread, np.zeros((2, 4, 4)), 1.0, 0.1, ones, ones, ones, ones, ones > 0
    )
    table = cold_and_warm.to_pandas()
    assert table.youngs_modulus.tolist() == [2e9, 1e9]
    assert table.temperature.tolist() == [0.0, 50.0]
    assert cold_and_warm.labelled().units["youngs_modulus"] == "Pa"


def test_axes_in_another_order_come_together() -> None:
    pytest.importorskip("pandas")
    values = np.arange(6).reshape(2, 3)
    made = LabelledArrays(
        {"turned": (("b", "a"), values.T), "straight": (("a", "b"), values)},
        {"a": (("a",), np.array([10, 20]))},
    ).frame()
    assert made.straight.tolist() == made.turned.tolist() == list(range(6))
    assert made.a.tolist() == [10, 10, 10, 20, 20, 20]


def test_a_package_that_is_missing_is_named_with_its_extra(frf: Frf, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(labelled, "find_spec", lambda name: None if name in ("xarray", "pandas") else find(name))
    with pytest.raises(ImportError, match=r"needs the package xarray, .*pip install 'flexura\[tables\]'"):
        frf.to_xarray()
    with pytest.raises(ImportError, match="needs the package pandas"):
        replace(frf).to_pandas()


@pytest.mark.parametrize("sweeps", [[-1], [2], [0, 5], [0, 1]])
def test_a_sweep_that_is_not_there_is_not_said_to_be_left_out(frf: Frf, sweeps: list[int]) -> None:
    with pytest.raises(ValueError, match=r"sweeps .*: 0 to 1, not all, are allowed"):
        frf.without(sweeps, "why not")
    left = frf.without([0], "too cold")
    assert left.temperature.tolist() == [30.0]
    assert left.notes[-1] == "sweep at 10.0 °C (up, 1 N at near) left out: too cold"
