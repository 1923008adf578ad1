import hashlib
from pathlib import Path

import h5py
import numpy
import pytest

import analysis
from app.files.provenance import provenance, read_stamp, sha256, stamp


def test_hash_is_that_of_the_bytes(tmp_path: Path) -> None:
    (tmp_path / "input").write_bytes(b"\x00\xff" * 100_000)
    assert sha256(tmp_path / "input") == hashlib.sha256(b"\x00\xff" * 100_000).hexdigest()


def test_says_what_made_the_result() -> None:
    made_from = provenance({"b": "2", "a": "1"}, {"order": 3}, seed=7)
    assert made_from["flexura"] == analysis.__version__
    assert made_from["packages"]["numpy"] == numpy.__version__
    assert list(made_from["inputs"]) == ["a", "b"]
    assert (made_from["settings"], made_from["seed"]) == ({"order": 3}, 7)


def test_stamp_of_a_thousand_inputs_comes_back(tmp_path: Path) -> None:
    made_from = provenance({f"sweeps/{n:04d}.tdms": "0" * 64 for n in range(1000)})
    with h5py.File(tmp_path / "result.h5", "w") as file:
        stamp(file, made_from)
    with h5py.File(tmp_path / "result.h5") as file:
        assert read_stamp(file) == made_from


def test_settings_that_are_not_numbers_are_refused(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "result.h5", "w") as file, pytest.raises(ValueError, match="JSON"):
        stamp(file, provenance({}, {"tolerance": float("nan")}))
