"""Values come back from HDF5 as they went in, and a file that holds something else is refused."""

from dataclasses import dataclass

import h5py
import numpy as np
import pytest

from app.files.hdf5_file import read_value, write_value


@dataclass(frozen=True)
class Inner:
    matrix: np.ndarray
    name: str


@dataclass(frozen=True)
class Outer:
    inner: Inner
    flags: np.ndarray
    span: tuple[float, float]
    names: tuple[str, ...]
    count: int
    share: float
    good: bool

    def __post_init__(self) -> None:
        if self.share > 1.0:
            raise ValueError(f"share {self.share:g}; allowed up to 1")


@dataclass(frozen=True)
class Spare:
    count: int
    inner: Inner | None = None


@pytest.mark.parametrize("inner", [None, Inner(np.eye(2), "there")])
def test_a_part_that_may_lack_comes_back_or_lacks(tmp_path, inner) -> None:
    with h5py.File(tmp_path / "v.h5", "w") as file:
        write_value(file.create_group("v"), Spare(2, inner))
    with h5py.File(tmp_path / "v.h5") as file:
        found = read_value(file["v"], Spare)
    assert found.count == 2
    assert (found.inner is None) == (inner is None)
    if inner is not None:
        np.testing.assert_array_equal(found.inner.matrix, inner.matrix)


def outer() -> Outer:
    matrix = np.random.default_rng(0).standard_normal((80, 90)) * (1 + 2j)
    return Outer(Inner(matrix, "η"), np.array([True, False]), (1.0, 2.5), ("a", "ü"), 3, 0.25, True)


def test_a_value_comes_back_bit_by_bit(tmp_path) -> None:
    with h5py.File(tmp_path / "v.h5", "w") as file:
        write_value(file.create_group("v"), outer())
    with h5py.File(tmp_path / "v.h5") as file:
        back = read_value(file["v"], Outer)
    first = outer()
    assert np.array_equal(back.inner.matrix, first.inner.matrix)
    assert np.array_equal(back.flags, first.flags)
    assert back.flags.dtype == bool
    assert (back.inner.name, back.span, back.names) == (first.inner.name, first.span, first.names)
    assert (back.count, back.share, back.good) == (3, 0.25, True)


def test_a_missing_part_is_named(tmp_path) -> None:
    with h5py.File(tmp_path / "v.h5", "w") as file:
        write_value(file.create_group("v"), outer())
        del file["v/inner/matrix"]
        with pytest.raises(ValueError, match=r"/v/inner lacks a readable 'matrix'"):
            read_value(file["v"], Outer)


def test_a_value_that_its_own_class_refuses_is_refused(tmp_path) -> None:
    with h5py.File(tmp_path / "v.h5", "w") as file:
        write_value(file.create_group("v"), outer())
        file["v"].attrs["share"] = 2.0
        with pytest.raises(ValueError, match=r"share 2; allowed up to 1"):
            read_value(file["v"], Outer)
