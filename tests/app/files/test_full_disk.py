"""A disk that is full, fails or hangs ends no process by a signal and stops no other thread."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from app.files.atomic import atomic_hdf5, atomic_path, write_text
from app.files.disk_room import UnwrittenFileError, told
from tests.disk_faults import needs_compiler, with_faults

CAMPAIGN = """
import numpy as np
from pathlib import Path
from app.files.campaigns.folder import SWEEPS, remove_unfinished, write_index
from app.files.acquisition.events import LatestRepeat, load_latest, save_latest
from app.files.campaigns.folder import Source, read_sweep_file, write_sweep
from analysis.recordings.campaign import Sweep

folder, every = Path(sys.argv[1]), int(sys.argv[2])
(folder / SWEEPS).mkdir(parents=True)
rng = np.random.default_rng(0)
drive, response = rng.standard_normal((2, 3, 5000)).astype("f4")
sweep = Sweep(1, "up", 1.0, 20.0, 20.1, "2000-01-01T00:00:00+00:00", drive, response[None], 20.0, 20.0)
signals = rng.standard_normal((2, 7000)).astype("f4")
shown = LatestRepeat(1, 0, "20", ("drive", "S1"), signals, np.zeros(2, bool), 8e3, 5.0)
file = folder / SWEEPS / "0001_up_T+020.0.h5"
works = [lambda: save_latest(folder, shown), lambda: write_sweep(file, sweep, ("S1",), Source("x", "0")),
         lambda: write_index(folder)]

def whole():
    assert not file.exists() or read_sweep_file(file, "x")[0] is not None
    assert load_latest(folder) is not None
    assert not list(folder.rglob("*.part"))

refused = 0
works[0]()
for work in works:
    arm(folder, 0, 0)
    work()
    calls = disk.counted()
    file.unlink(missing_ok=True)
    for number in range(1, calls + 1, every):
        for error in (errno.ENOSPC, errno.EIO):
            arm(folder, number, error)
            try:
                work()
            except OSError as wrong:
                refused += 1
                assert wrong.errno == error and str(folder) in str(wrong), wrong
            arm("nothing", 0, 0)
            whole()
            file.unlink(missing_ok=True)
for work in works:
    work()
whole()
print(refused)
"""


@needs_compiler
def test_a_fault_at_any_call_is_an_error_and_leaves_whole_files(tmp_path: Path) -> None:
    """HDF5 on a file of its own died of it by SIGSEGV or SIGBUS, at once or at the next file it closed."""
    done = with_faults(tmp_path, CAMPAIGN, tmp_path / "campaign", 1)
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) >= 12


HANGS = """
import threading, time
import numpy as np
from pathlib import Path
from app.files.atomic import atomic_hdf5
from app.files.hdf5_file import opened_hdf5

file = Path(sys.argv[1]) / "new.h5"
def work():
    with atomic_hdf5(file) as stored:
        stored["x"] = np.arange(100_000.0)
arm("nothing", 0, 0)
work()
arm(file.parent, 0, 0)
work()
for number in range(1, disk.counted() + 1):
    arm(file.parent, number, -1)
    writer = threading.Thread(target=work)
    writer.start()
    for tick in range(20):  # of a supervision
        time.sleep(0.01)
    assert writer.is_alive(), number
    arm("nothing", 0, 0)
    writer.join()
    with opened_hdf5(file) as stored:
        assert len(stored["x"]) == 100_000
print("other threads went on")
"""


@needs_compiler
def test_a_disk_that_hangs_does_not_stop_other_threads(tmp_path: Path) -> None:
    """HDF5 waits for the disk with Python's interpreter lock held: an oven's supervision stood still with it."""
    (tmp_path / "share").mkdir()
    done = with_faults(tmp_path, HANGS, tmp_path / "share", seconds=60.0)
    assert (done.returncode, done.stdout) == (0, "other threads went on\n"), done.stderr[-2000:]


LITTLE_MEMORY = """
import os, resource, sys
import h5py, numpy as np
from pathlib import Path
from app.files.atomic import atomic_hdf5, write_text
from app.files.disk_room import UnwrittenFileError, told

folder = Path(sys.argv[1])
data = np.random.default_rng(0).standard_normal(1_000_000)
def work():
    with atomic_hdf5(folder / "a.h5") as file:
        for n in range(4):
            file[f"x{n}"] = data
            for k in range(30):
                file.create_group(f"{n}-{k}").attrs["k"] = k
work()
before = (folder / "a.h5").read_bytes()
refused = 0
for spare in (1, 4, 9, 16, 17, 24, 30, 33, 40, 60, 70, 90):
    now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (now + spare * 1_000_000, resource.RLIM_INFINITY))
    try:
        work()
    except UnwrittenFileError as wrong:
        assert "a.h5: cannot be written (not enough memory" in str(wrong), wrong
        refused += 1
    resource.setrlimit(resource.RLIMIT_AS, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
    assert (folder / "a.h5").read_bytes() == before
    assert os.listdir(folder) == ["a.h5"]
print(refused)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="a limit of memory, as Linux has it")
def test_too_little_memory_is_an_error_and_leaves_the_old_file(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LITTLE_MEMORY, tmp_path],
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(done.stdout) >= 5


def test_what_is_missing_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("app.files.disk_room.os.write", full)
    monkeypatch.setattr("app.files.disk_room.shutil.disk_usage", lambda _: type("Usage", (), {"free": 1_500_000}))
    with pytest.raises(UnwrittenFileError, match=r"needs 2 MB, 1\.5 MB are free, 0\.5 MB are missing.*make room"):
        write_text(tmp_path / "big.txt", "x" * 2_000_000)
    assert not list(tmp_path.iterdir())


def test_an_error_about_another_file_is_not_the_written_one_s(tmp_path: Path) -> None:
    other = tmp_path / "none" / "read.txt"
    with pytest.raises(FileNotFoundError, match=r"read\.txt"), atomic_path(tmp_path / "new.txt"):
        other.read_text()
    with pytest.raises(FileNotFoundError, match=r"read\.txt"), atomic_hdf5(tmp_path / "new.h5"):
        other.read_text()
    assert not list(tmp_path.iterdir())


def test_a_name_that_is_too_long_is_an_error_that_names_it_and_wants_a_shorter_one(tmp_path: Path) -> None:
    with (
        pytest.raises(UnwrittenFileError, match=r"xxx\.h5: cannot be written \(.*\); name a shorter one, and run"),
        atomic_hdf5(tmp_path / f"{'x' * 300}.h5"),
    ):
        pass
    with pytest.raises(OSError, match="long") as raised:
        (tmp_path / ("x" * 300)).mkdir()
    said = told(raised.value) or ""
    assert said.endswith("); name a shorter one, and run it again")


def test_the_error_passes_from_one_process_to_another() -> None:
    import pickle

    error = pickle.loads(pickle.dumps(UnwrittenFileError(errno.ENOSPC, "cannot be written", "a.h5")))  # noqa: S301
    assert (str(error), error.errno) == ("a.h5: cannot be written", errno.ENOSPC)
