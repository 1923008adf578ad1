"""Exports in a script write what the verb writes."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import flexura
from app.files.bad_file import ResultFileError
from app.main import flexura as program

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "pp-plate"


def test_sweeps_are_those_of_the_verb(tmp_path: Path) -> None:
    written = flexura.export_sweeps(EXAMPLE, "csv", tmp_path / "ours", progress=False)
    words = ["export", str(EXAMPLE), "--to", "csv", "--out", str(tmp_path / "theirs")]
    assert CliRunner().invoke(program, words).exit_code == 0
    assert len(written) == 1 + 16  # and the declaration
    for path in written:
        assert path.read_bytes() == (tmp_path / "theirs" / path.name).read_bytes()


def test_wrong_forms_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="to 'xls'; allowed: tdms, mat, csv, uff"):
        flexura.export_sweeps(EXAMPLE, "xls", tmp_path)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="to 'wma'"):
        flexura.export_filters(tmp_path, "wma")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="prefix 'Tür'; allowed: a small letter"):
        flexura.export_filters(tmp_path, "c", prefix="Tür")  # it ended while the file was written
    with pytest.raises(ValueError, match="temperature is for npz, wav and csv; onnx follows every"):
        flexura.export_filters(tmp_path, "onnx", temperature=20.0)


def test_a_method_that_is_none_is_no_spline(tmp_path: Path) -> None:
    """The filters of a spline were exported and rendered for any word."""
    with pytest.raises(ResultFileError, match="method 'nearest': allowed are network, low-rank, cubic-spline"):
        flexura.export_filters(tmp_path, "npz", method="nearest")
    with pytest.raises(ResultFileError, match="method 'nearest': allowed are network"):
        flexura.render("a.wav", tmp_path, temperature=20, method="nearest")
