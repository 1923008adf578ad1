"""Exports in a script write what the verb writes."""

from pathlib import Path

import pytest
from click.testing import CliRunner

import flexura
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
