"""Where results gather, and what is said when one is not there."""

from pathlib import Path

import pytest

from app.files.bad_file import ResultFileError
from app.files.results.run_folder import run_file, run_folder


def test_default_is_beside_the_campaign(tmp_path) -> None:
    (tmp_path / "plate").mkdir()
    with run_folder(tmp_path / "plate", None) as run:
        assert run == tmp_path / "plate-run"
    assert run.is_dir()


@pytest.mark.parametrize("written", [(), ("modes.csv",)])
def test_a_folder_made_for_what_was_refused_goes_and_one_that_holds_something_stays(tmp_path, written) -> None:
    def refused() -> None:
        with run_folder(tmp_path, tmp_path / "new" / "run") as run:
            for name in written:
                (run / name).write_text("")
            raise ValueError("refused")

    with pytest.raises(ValueError, match="refused"):
        refused()
    assert (tmp_path / "new").exists() is bool(written)


@pytest.mark.parametrize("name", ["file/run", 300 * "a"], ids=["in a file", "too long"])
def test_a_place_that_cannot_be_written_asks_for_out(tmp_path, name: str) -> None:
    (tmp_path / "file").write_text("")
    out = tmp_path / name
    with pytest.raises(ResultFileError, match="name another with --out"), run_folder(tmp_path / "plate", out):
        pass


@pytest.mark.parametrize("name", ["report.html", "music.WAV", "taps.csv"])
def test_a_folder_is_not_called_like_a_file(tmp_path, name: str) -> None:
    """report.html/report.html was made for who wanted a file."""
    with pytest.raises(ResultFileError, match="--out names a folder"), run_folder(tmp_path, tmp_path / name):
        pass
    assert not (tmp_path / name).exists()
    with run_folder(tmp_path, tmp_path / "car.v2") as folder:
        assert folder.is_dir()


def test_a_missing_result_names_its_verb(tmp_path) -> None:
    with pytest.raises(ResultFileError, match=r"holds no laws\.h5; make it with: flexura update"):
        run_file(tmp_path, "laws.h5", "focus")
    run = tmp_path / "of a run"
    run.mkdir()
    with pytest.raises(ResultFileError, match=r"make it with: flexura focus '.*of a run'"):
        run_file(run, "filters.h5", "radiation")


def test_a_folder_of_later_results_is_told_to_be_named_with_out(tmp_path) -> None:
    (tmp_path / "filters.h5").touch()
    with pytest.raises(ResultFileError, match=r"holds filters\.h5 but no laws\.h5.*this one with --out"):
        run_file(tmp_path, "laws.h5", "compensate")


def test_a_run_that_does_not_exist_is_said_not_to(tmp_path) -> None:
    with pytest.raises(ResultFileError, match=r"nope: does not exist; make it with: flexura update"):
        run_file(tmp_path / "nope", "laws.h5", "focus")


@pytest.mark.parametrize(("typed", "beside"), [("plate", "plate-run"), (".", "{0}/plate-run")])
def test_a_campaign_in_place_of_its_run_is_told_where_the_results_are(
    tmp_path, monkeypatch, typed: str, beside: str
) -> None:
    (tmp_path / "plate").mkdir()
    (tmp_path / "plate-run").mkdir()
    (tmp_path / "plate-run" / "laws.h5").touch()
    monkeypatch.chdir(tmp_path / "plate" if typed == "." else tmp_path)
    run = Path(beside.format(tmp_path.resolve()))
    with pytest.raises(ResultFileError) as caught:
        run_file(Path(typed), "laws.h5", "focus")
    assert str(caught.value) == (
        f"{typed}: holds no laws.h5; the results of this campaign are in {run}: flexura focus {run}"
    )
