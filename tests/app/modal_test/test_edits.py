"""Modes of a test dropped and added by hand, on a beam whose modes are known."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analysis.estimation.transfer import MeasuredTransfer
from analysis.identification.settings import Settings
from app.files.bad_file import ResultFileError
from app.files.results.modes_file import load_modes
from app.files.uff.frfs import write_frfs
from app.modal_test import edit_journal
from app.modal_test.edits import add_mode, drop_mode, edits_of, redo_edit, undo_edit
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import identify_test, load_test, save_test
from app.modal_test.without_windows import freed
from app.stages.identify_options import Wanted
from tests.app.modal_test.conftest import Beam, F, typed


@pytest.fixture
def run(tmp_path: Path, beam: Beam) -> Path:
    """Three accelerances of a beam with 0.1 % noise, identified."""
    rng = np.random.default_rng(0)
    frequency = np.arange(40.0, 700.0, 0.25)
    frfs = []
    for i in range(3):
        h = beam.frf(frequency, i, 0, 2)
        h = h + 1e-3 * np.abs(h).max() * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
        frfs.append(MeasuredTransfer(f"point {i + 1}", f"{i + 1}:+3", "1:+3", "acceleration", frequency, h))
    write_frfs(tmp_path / "beam.uff", frfs)
    typed("identify", tmp_path / "beam.uff", "--shared-poles", "--out", tmp_path / "run", "--quiet")
    return tmp_path / "run"


def frequencies(run: Path) -> list[float]:
    _, modes, _ = load_test(run)
    return list(modes.reading("viscous").frequency_hz[modes.real])


def test_a_dropped_mode_is_gone_and_one_added_there_comes_back(run: Path) -> None:
    before = load_modes(run / "modes.h5").modes[0]
    assert frequencies(run) == pytest.approx(list(F), rel=1e-4)
    told = drop_mode(run, 260.0)
    assert told.startswith("mode at 26")
    assert told.endswith("dropped by hand")
    assert frequencies(run) == pytest.approx([F[0], F[2]], rel=1e-4)
    assert len((run / "modes.csv").read_text(encoding="utf-8").splitlines()) == 3
    add_mode(run, 258.0)
    assert frequencies(run) == pytest.approx(list(F), rel=1e-4)
    frfs, after, _ = load_test(run)
    moved = np.abs(np.log(np.abs(after.poles[after.real]) / np.abs(before.poles[before.real])))
    assert (moved < 0.5 * np.sqrt(before.covariance[before.real, 0, 0])).all()
    by_hand = [words.startswith("added by hand") for words in np.array(after.reason)[after.real]]
    assert by_hand == [False, True, False]
    assert edits_of(run)[0] == told
    assert float(edits_of(run)[1].removeprefix("mode at ").split()[0]) == pytest.approx(F[1], rel=1e-4)
    assert edits_of(run)[1].endswith("Hz, begun at 258.000 Hz, added by hand")
    assert frfs.notes[-2:] == tuple(edits_of(run))


def test_what_is_no_mode_by_its_data_is_weak_and_unconfirmed_when_added(run: Path) -> None:
    add_mode(run, 400.0)
    _, modes, shapes = load_test(run)
    added = next(j for j, why in enumerate(modes.reason) if why.startswith("added by hand"))
    assert modes.standing(added) == "weak, unconfirmed"
    assert added in shapes.pole


def test_what_was_added_before_stays_when_another_is_added(run: Path) -> None:
    add_mode(run, 400.0)
    add_mode(run, 600.0)
    _, modes, _ = load_test(run)
    marked = [why.startswith("added by hand") for why in np.array(modes.reason)[modes.real]]
    assert marked == [False, False, True, False, True]


def test_the_mark_goes_to_the_mode_that_came_wherever_it_went(run: Path) -> None:
    """Begun at 400 Hz, nearer to the third mode than to the second, which is the one that lacks."""
    drop_mode(run, float(F[1]))
    assert "begun at 400.000 Hz" in add_mode(run, 400.0)
    _, modes, _ = load_test(run)
    marked = [why.startswith("added by hand") for why in np.array(modes.reason)[modes.real]]
    assert marked == [False, True, False]


def test_dropping_a_mode_leaves_the_others_as_they_are_under_an_exponential_window(tmp_path: Path) -> None:
    """The window moves poles 3 /s to the left, which decay with 1.2 to 6.4 /s themselves."""
    frequency, own = np.arange(40.0, 700.0, 0.25), 2j * np.pi * F * (1.0 + 0.002j)
    under = (own - 3.0)[:, None]
    h = (2e4 / (2j * np.pi * frequency - under) + 2e4 / (2j * np.pi * frequency - under.conj())).sum(0)
    rng = np.random.default_rng(0)
    h = h + 1e-3 * np.abs(h).max() * (rng.normal(size=h.shape) + 1j * rng.normal(size=h.shape))
    frfs = FrfSet("beam", (MeasuredTransfer("p", "1:+3", "1:+3", "displacement", frequency, h),), window_rate=3.0)
    wanted = Wanted(Settings(), "viscous", "auto", None)
    save_test(tmp_path, identify_test(frfs, wanted, lambda *_: None), wanted)
    _, before, _ = load_test(tmp_path)
    drop_mode(tmp_path, float(F[1]))
    _, after, _ = load_test(tmp_path)
    stayed = np.abs(before.poles.imag / (2.0 * np.pi) - F[1]) > 1.0
    for name in ("poles", "covariance"):
        np.testing.assert_array_equal(getattr(after, name), getattr(before, name)[stayed])
    assert np.array(after.reason).tolist() == np.array(before.reason)[stayed].tolist()


def test_what_cannot_be_is_refused(run: Path) -> None:
    with pytest.raises(ResultFileError, match="between 40 and"):
        add_mode(run, 3000.0)
    for frequency in F[:2]:
        drop_mode(run, float(frequency))
    with pytest.raises(ResultFileError, match="one mode cannot be dropped"):
        drop_mode(run, float(F[2]))
    with pytest.raises(ResultFileError, match="transfers"):
        drop_mode(run.parent, 100.0)


def test_a_mode_whose_own_damping_the_window_hides_is_weak(run: Path) -> None:
    """The damping with the window's is known to 6 %; the own is a tenth of that, and so known to 60 %."""
    _, modes, _ = load_test(run)
    rate = float(-9.0 * modes.poles[modes.real][0].real)
    widened = replace(
        modes, poles=modes.poles - rate, covariance=np.tile(np.diag([1e-12, 0.06**2]), (len(modes.poles), 1, 1))
    )
    judged = freed(widened, rate)
    first, last = np.flatnonzero(modes.real)[[0, -1]]
    np.testing.assert_allclose(judged.poles, modes.poles)
    assert judged.status[first] == "weak"
    assert judged.reason[first].endswith("without the window's its damping ratio is known to 60 % only")
    assert judged.status[last] == "kept"


def files_of(run: Path) -> dict[str, bytes]:
    return {name: (run / name).read_bytes() for name in edit_journal.FILES}


def test_every_change_is_undone_and_made_again_to_the_last_byte(run: Path) -> None:
    states = [files_of(run)]
    told = [drop_mode(run, F[1])]
    states.append(files_of(run))
    told.append(drop_mode(run, F[0]))
    states.append(files_of(run))
    assert [undo_edit(run), undo_edit(run)] == told[::-1]
    assert files_of(run) == states[0]
    with pytest.raises(ResultFileError, match="no change by hand that could be undone"):
        undo_edit(run)
    assert [redo_edit(run), redo_edit(run)] == told
    assert files_of(run) == states[2]
    with pytest.raises(ResultFileError, match="no change by hand that could be made again"):
        redo_edit(run)
    journal = [json.loads(line) for line in (run / "edits" / "journal.jsonl").read_text().splitlines()]
    assert [line["did"] for line in journal] == ["made"] * 2 + ["undone"] * 2 + ["made again"] * 2
    assert all(line["date"].endswith("+00:00") for line in journal)


def test_a_change_after_an_undo_takes_the_place_of_what_was_undone(run: Path) -> None:
    drop_mode(run, F[1])
    undo_edit(run)
    told = drop_mode(run, F[2])
    with pytest.raises(ResultFileError, match="made again"):
        redo_edit(run)
    assert undo_edit(run) == told
    assert frequencies(run) == pytest.approx(list(F), rel=1e-4)


def test_a_journal_of_other_results_is_not_used(run: Path, tmp_path: Path) -> None:
    drop_mode(run, F[1])
    typed("identify", tmp_path / "beam.uff", "--shared-poles", "--out", run, "--quiet")
    assert not (run / "edits").exists()
    drop_mode(run, F[1])
    before = files_of(run)
    (run / "edits" / "journal.jsonl").write_text("no journal\n")
    with pytest.raises(ResultFileError, match="no change by hand"):
        undo_edit(run)
    assert files_of(run) == before
    drop_mode(run, F[0])
    undo_edit(run)
    assert files_of(run) == before
    (run / "modes.h5").write_bytes(
        (run / "edits" / "1" / "modes.h5").read_bytes()[:-1] + b"x"
    )  # replaced by others
    with pytest.raises(ResultFileError):
        undo_edit(run)


def test_a_table_that_people_change_leaves_the_journal_alone(run: Path) -> None:
    whole = (run / "modes.csv").read_bytes()
    drop_mode(run, F[1])
    with (run / "modes.csv").open("r+b") as file:
        file.write(b"mine")
    undo_edit(run)
    assert (run / "modes.csv").read_bytes() == whole
