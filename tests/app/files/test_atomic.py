import json
import os
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import h5py
import numpy as np
import pytest

from app.files.atomic import atomic_hdf5, atomic_path, write_json, write_text
from app.files.hdf5_file import opened_hdf5


def test_file_takes_its_name_only_when_the_block_has_ended(tmp_path: Path) -> None:
    target = tmp_path / "new" / "result.txt"
    with atomic_path(target) as partial:
        partial.write_text("whole")
        assert not target.exists()
        assert partial.parent == target.parent  # a rename across file systems is a copy, and can be torn
    assert target.read_text() == "whole"
    assert [p.name for p in target.parent.iterdir()] == ["result.txt"]


@pytest.mark.parametrize("wrong", [ValueError, KeyboardInterrupt, SystemExit])
def test_broken_block_leaves_the_old_file_and_nothing_else(tmp_path: Path, wrong: type[BaseException]) -> None:
    target = tmp_path / "result.txt"
    target.write_text("old")

    def breaks() -> None:
        with atomic_path(target) as partial:
            partial.write_text("half")
            raise wrong

    with pytest.raises(wrong):
        breaks()
    assert target.read_text() == "old"
    assert os.listdir(tmp_path) == ["result.txt"]  # noqa: PTH208


def test_block_that_writes_nothing_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "result.txt"):
        pass
    assert not list(tmp_path.iterdir())


def test_broken_hdf5_leaves_nothing(tmp_path: Path) -> None:
    def breaks() -> None:
        with atomic_hdf5(tmp_path / "result.h5") as file:
            file["x"] = np.arange(10)
            raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011
        breaks()
    assert not list(tmp_path.iterdir())


def test_hdf5_written_twice_has_the_same_bytes(tmp_path: Path) -> None:
    for name in ("first.h5", "second.h5"):
        with atomic_hdf5(tmp_path / name) as file:
            group = file.create_group("laws")
            group.create_dataset("modulus", data=np.linspace(1.0, 2.0, 100), compression="gzip")
            group.attrs["unit"] = "Pa"
    assert (tmp_path / "first.h5").read_bytes() == (tmp_path / "second.h5").read_bytes()
    with h5py.File(tmp_path / "first.h5") as file:
        np.testing.assert_array_equal(file["laws/modulus"][:], np.linspace(1.0, 2.0, 100))


def test_text_keeps_its_line_ends(tmp_path: Path) -> None:
    write_text(tmp_path / "lines.txt", "a\nb\r\nη\n")
    assert (tmp_path / "lines.txt").read_bytes() == "a\nb\r\nη\n".encode()


def test_json_refuses_what_json_lacks(tmp_path: Path) -> None:
    write_json(tmp_path / "value.json", {"η": [1.5, None]})
    assert json.loads((tmp_path / "value.json").read_text(encoding="utf-8")) == {"η": [1.5, None]}
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "nan.json", {"x": float("nan")})
    assert not (tmp_path / "nan.json").exists()


def _written_often(target: Path) -> None:
    for _ in range(40):
        with atomic_hdf5(target, shared=True) as file:
            file["model"] = np.arange(50_000)


def test_processes_that_make_the_same_model_at_once_do_not_disturb_one_another(tmp_path: Path) -> None:
    """Two first comparisons of one plate wrote one `.part`, and the second found it gone: FileNotFoundError."""
    target = tmp_path / "model.h5"
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as workers:
        for one in [workers.submit(_written_often, target) for _ in range(2)]:
            one.result(timeout=120)
    with opened_hdf5(target) as file:
        assert file["model"].shape == (50_000,)
    assert [one.name for one in tmp_path.iterdir()] == ["model.h5"]
