import csv
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from analysis.identification.automatic import identify
from analysis.identification.measured import Measured
from analysis.identification.modes import Modes, Rejected
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.provenance import provenance, read_stamp
from app.files.results.modes_file import load_modes, save_modes, write_table
from tests.synthetic_frf import r10


@pytest.fixture(scope="module")
def modes() -> Modes:
    case = r10(np.random.default_rng(2))
    found = identify(Measured(case.frequency, case.h[None]))
    words = tuple("confirmed" if real else "" for real in found.real)
    return replace(found, confirmation=words, rejected=(*found.rejected, Rejected(600j, "a line", "harmonic")))


@pytest.fixture
def tracked(modes: Modes) -> TrackedModes:
    return TrackedModes(
        temperature=np.array([20.0, 22.0]),
        direction=("up", "down"),
        level=np.array([1.0, 0.5]),
        channels=("S1",),
        modes=(modes, replace(modes, poles=0.97 * modes.poles)),
        track=np.array([[0, 1, -1], [0, -1, 2]]),
        start=1,
        notes=("a note",),
    )


def test_saved_modes_rebuild_their_frfs_to_the_last_bit(tracked: TrackedModes, tmp_path: Path) -> None:
    made_from = provenance({"a.tdms": "00ff"}, {"damping": "viscous"})
    save_modes(tmp_path / "modes.h5", tracked, made_from)
    again = load_modes(tmp_path / "modes.h5")
    frequency = np.linspace(90.0, 1600.0, 777)
    np.testing.assert_array_equal(again.synthesis(frequency), tracked.synthesis(frequency))
    np.testing.assert_array_equal(again.covariance, tracked.covariance)
    assert again.modes[0].confirmation == tracked.modes[0].confirmation
    assert again.modes[0].rejected == tracked.modes[0].rejected
    assert (again.status, again.notes, again.direction) == (tracked.status, tracked.notes, tracked.direction)
    assert not list(tmp_path.glob("*.part"))
    with h5py.File(tmp_path / "modes.h5") as file:
        assert read_stamp(file) == made_from


@pytest.mark.parametrize("chosen", [{}, {"damping": "viscous"}])
def test_files_of_earlier_versions_are_read_as_their_provenance_says(
    tracked: TrackedModes, tmp_path: Path, chosen: dict[str, str]
) -> None:
    save_modes(tmp_path / "now.h5", tracked.read_as("viscous"), provenance({}, chosen))
    assert load_modes(tmp_path / "now.h5").damping == "viscous"
    with h5py.File(tmp_path / "now.h5") as now, atomic_hdf5(tmp_path / "modes.h5") as earlier:
        for name in now:
            now.copy(name, earlier)
        for sweep in earlier["sweeps"].values():
            del sweep.attrs["damping"]
    assert load_modes(tmp_path / "modes.h5").damping == chosen.get("damping", "hysteretic")


def test_table_for_people_holds_the_reading(tracked: TrackedModes, tmp_path: Path) -> None:
    write_table(tmp_path / "modes.csv", tracked.read_as("viscous"))
    with (tmp_path / "modes.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [(row["temperature_c"], row["mode"]) for row in rows] == [
        ("20.0000", "1"),
        ("20.0000", "2"),
        ("22.0000", "1"),
        ("22.0000", "3"),
    ]
    assert {row["confirmation"] for row in rows} == {"confirmed"}
    assert [row["reason"] for row in rows[:2]] == list(tracked.modes[0].read_as("viscous").explanation()[:2])
    assert float(rows[1]["frequency_hz"]) == pytest.approx(tracked.reading("viscous").frequency_hz[0, 1])


@pytest.mark.parametrize("damage", ["cut", "other", "absent"])
def test_damaged_files_are_refused(tracked: TrackedModes, tmp_path: Path, damage: str) -> None:
    path = tmp_path / "modes.h5"
    if damage == "cut":
        save_modes(path, tracked, {})
        path.write_bytes(path.read_bytes()[:3000])
    elif damage == "other":
        with atomic_hdf5(path) as file:
            file["x"] = 1
    with pytest.raises(ResultFileError, match=r"modes\.h5.*flexura identify"):
        load_modes(path)
