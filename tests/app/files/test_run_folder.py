"""Where results gather, and what is said when one is not there."""

import pytest

from app.files.bad_file import ResultFileError
from app.files.run_folder import run_file, run_folder


def test_default_is_beside_the_campaign(tmp_path) -> None:
    (tmp_path / "plate").mkdir()
    assert run_folder(tmp_path / "plate", None) == tmp_path / "plate-run"
    assert (tmp_path / "plate-run").is_dir()


def test_a_place_that_cannot_be_written_asks_for_out(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultFileError, match="name another with --out"):
        run_folder(tmp_path / "plate", tmp_path / "file" / "run")


def test_a_missing_result_names_its_verb(tmp_path) -> None:
    with pytest.raises(ResultFileError, match=r"holds no laws\.h5; make it with: flexura update"):
        run_file(tmp_path, "laws.h5")
