"""Where results came from, and those that are older than what they were made from."""

from pathlib import Path

import pytest

from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance, sha256, stamp
from app.report.page import Folded, Listing, PageTable
from app.report.summary import origin, outdated, stamps

PANEL = {"plate": {"length_x": 0.24}, "patch": [{"id": "A1"}]}


def write(path: Path, inputs: dict[str, str], **settings: object) -> None:
    with atomic_hdf5(path) as file:
        stamp(file, provenance(inputs, settings))


@pytest.fixture
def run(tmp_path: Path) -> Path:
    sweeps = {f"sweeps/{n}.tdms": f"{n:064x}" for n in range(3)}
    write(tmp_path / "frf.h5", sweeps, mains=50.0)
    write(tmp_path / "laws.h5", sweeps, mains=50.0)
    write(tmp_path / "filters.h5", {"laws.h5": sha256(tmp_path / "laws.h5")}, panel=PANEL)
    write(tmp_path / "compensation.h5", {"filters.h5": sha256(tmp_path / "filters.h5")}, panel=PANEL, spacing=5.0)
    return tmp_path


NAMES = ("frf.h5", "modes.h5", "laws.h5", "filters.h5", "compensation.h5")


def test_results_made_one_after_the_other_belong_together(run: Path) -> None:
    assert list(stamps(run, NAMES)) == ["frf.h5", "laws.h5", "filters.h5", "compensation.h5"]
    assert outdated(run, stamps(run, NAMES)) == []


def test_a_result_older_than_what_it_was_made_from_is_told_of(run: Path) -> None:
    write(run / "laws.h5", {f"sweeps/{n}.tdms": f"{n:064x}" for n in range(3)}, mains=60.0)
    (said,) = outdated(run, stamps(run, NAMES))
    assert said == (
        "filters.h5 was made from another laws.h5 than the one that is here now; "
        f"make it again: flexura focus {run}"
    )


def test_a_result_that_is_told_to_be_made_again_is_not_held_against_newer_ones(run: Path) -> None:
    """The advice was to make the newer one again, too, "from one recording"."""
    write(run / "filters.h5", {"laws.h5": sha256(run / "laws.h5")}, panel=PANEL, taps=128)
    write(run / "studies.h5", {"filters.h5": sha256(run / "filters.h5")}, panel=PANEL)
    said = outdated(run, stamps(run, (*NAMES, "studies.h5")))
    assert said == [
        "compensation.h5 was made from another filters.h5 than the one that is here now; "
        f"make it again: flexura compensate {run}"
    ]


def test_results_of_two_recordings_are_told_of_once(run: Path) -> None:
    write(run / "frf.h5", {f"sweeps/{n}.tdms": f"{n + 7:064x}" for n in range(3)}, mains=50.0)
    (said,) = outdated(run, stamps(run, NAMES))
    assert "laws.h5 and frf.h5 were made from different files called sweeps/0.tdms" in said


def test_no_file_outside_the_run_is_looked_at(run: Path) -> None:
    (run.parent / "secret").write_text("x")
    write(run / "modes.h5", {"../secret": "0" * 64, str(run.parent / "secret"): "0" * 64})
    assert outdated(run, stamps(run, NAMES)) == []


def test_a_file_with_a_broken_provenance_is_refused(run: Path) -> None:
    with atomic_hdf5(run / "modes.h5") as file:
        file.create_dataset("provenance", data="[1, 2]")
    with pytest.raises(ResultFileError, match="provenance: a table"):
        stamps(run, NAMES)


def test_a_file_without_provenance_is_refused_with_what_makes_it(run: Path) -> None:
    with atomic_hdf5(run / "modes.h5") as file:
        file["something"] = 1
    with pytest.raises(ResultFileError, match=r"modes\.h5: .*provenance.* flexura identify"):
        stamps(run, NAMES)


def test_what_two_results_share_is_listed_once(run: Path) -> None:
    (folded,) = origin(stamps(run, NAMES))
    assert isinstance(folded, Folded)
    made_with, inputs, settings = folded.items
    assert isinstance(made_with, PageTable)
    assert isinstance(inputs, PageTable)
    assert isinstance(settings, Listing)
    assert len(made_with.rows) == 4
    assert ("sweeps/0.tdms", f"{0:064x}", "frf.h5, laws.h5") in inputs.rows
    assert settings.text.splitlines() == [
        "frf.h5: mains = 50.0",
        "laws.h5: mains = 50.0",
        "filters.h5: panel.plate.length_x = 0.24",
        'filters.h5: panel.patch 1 = {"id": "A1"}',
        "compensation.h5: panel as in filters.h5",
        "compensation.h5: spacing = 5.0",
    ]
