"""What is damaged, reaches out of itself or unfolds without end is refused before it is read."""

import os
import signal
import zlib
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import h5py
import numpy as np
import pytest

from app.files.atomic import atomic_hdf5
from app.files.bad_file import ResultFileError
from app.files.hdf5_file import Hdf5FileError, opened_hdf5, result_file
from app.files.isolation import SlowReadError, require_readable, run_isolated
from app.terminal.end_signals import end_signals


def write(path: Path, also: Callable[[h5py.File], object] = lambda file: None) -> Path:
    with atomic_hdf5(path) as file:
        file.attrs["name"] = "a text"
        file.create_dataset("group/values", data=np.arange(5000.0), compression="gzip", shuffle=True)
        file.create_dataset("record", data="another text")
        file.create_dataset("flags", data=np.array([True, False]))
        file.create_dataset("complex", data=np.ones(3, dtype=complex))
        also(file)
    return path


def test_a_file_is_read_by_us_and_by_any_hdf5_viewer(tmp_path: Path) -> None:
    path = write(tmp_path / "a.h5")
    with opened_hdf5(path) as ours, h5py.File(path) as theirs:
        for file in (ours, theirs):
            np.testing.assert_array_equal(file["group/values"][()], np.arange(5000.0))
            assert file["record"].asstr()[()] == "another text"
    assert path.read_bytes().startswith(b"flexura-sealed/1 sha256 ")
    assert write(tmp_path / "b.h5").read_bytes() == path.read_bytes()


def test_every_flipped_bit_and_every_cut_is_seen(tmp_path: Path) -> None:
    whole = write(tmp_path / "a.h5").read_bytes()
    rng = np.random.default_rng(0)
    path = tmp_path / "damaged.h5"
    for place in (*range(0, 512, 5), *rng.integers(512, len(whole), 150)):
        damaged = bytearray(whole)
        damaged[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        with pytest.raises(Hdf5FileError), opened_hdf5(path):
            pass
    for length in (0, 3, 511, 512, 700, len(whole) - 1):
        path.write_bytes(whole[:length])
        with pytest.raises(Hdf5FileError), opened_hdf5(path):
            pass


def test_a_result_is_refused_with_what_makes_it_again(tmp_path: Path) -> None:
    path = write(tmp_path / "modes.h5")
    with h5py.File(path, "r+") as file:
        file["record"][()] = "edited"
    told = r"modes\.h5: not a readable modes\.h5: damaged, .*; make it again: flexura identify"
    with pytest.raises(ResultFileError, match=told), result_file(path, "identify"):
        pass
    with pytest.raises(ResultFileError, match="no such file"), result_file(tmp_path / "none.h5", "identify"):
        pass
    with h5py.File(path, "w") as file:
        file["record"] = 1
    with pytest.raises(ResultFileError, match="carries no SHA-256"), result_file(path, "identify"):
        pass


def _external_link(file: h5py.File) -> None:
    file["away"] = h5py.ExternalLink("/etc/hosts", "/")


def _soft_link(file: h5py.File) -> None:
    file["group/again"] = h5py.SoftLink("/record")


def _external_storage(file: h5py.File) -> None:
    file.create_dataset("hosts", shape=(20,), dtype="u1", external=[("/etc/hosts", 0, 20)])


def _virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout(shape=(4,), dtype="f8")
    layout[:] = h5py.VirtualSource("other.h5", "values", shape=(4,))
    file.create_virtual_dataset("values", layout)


def _cycle(file: h5py.File) -> None:
    file["group/above"] = file["group"]


def _huge(file: h5py.File) -> None:
    file.create_dataset("huge", shape=(20_000, 20_000), dtype="f8", chunks=(500, 500), compression="gzip")


def _many(file: h5py.File) -> None:
    for n in range(20):
        file.create_dataset(f"big{n}", shape=(1_000_000,), dtype="f8")


def _bomb(file: h5py.File) -> None:
    data = file.create_dataset("bomb", shape=(4096,), dtype="u1", chunks=(4096,), compression="gzip")
    data.id.write_direct_chunk((0,), zlib.compress(b"\0" * 3_000_000))


def _huge_piece(file: h5py.File) -> None:
    file.create_dataset("piece", shape=(4,), maxshape=(None,), dtype="f8", chunks=(30_000_000,))


def _texts(file: h5py.File) -> None:
    file.create_dataset("texts", data=["a", "b"])


def _reference(file: h5py.File) -> None:
    file.attrs["reference"] = file["group"].ref


def _type(file: h5py.File) -> None:
    file["type"] = np.dtype([("a", "f8"), ("b", "i4")])


def _empty(file: h5py.File) -> None:
    file["empty"] = h5py.Empty("f8")


FOREIGN = [
    (_external_link, "/away is a link to elsewhere"),
    (_soft_link, "/group/again is a link to elsewhere"),
    (_external_storage, "/hosts lies in other files"),
    (_virtual, "/values lies in other files"),
    (_cycle, "/group/above occurs twice"),
    (_huge, "/huge takes 3200000000 bytes"),
    (_many, "/big"),
    (_bomb, "/bomb holds a piece that does not unpack into 4096 bytes"),
    (_huge_piece, "/piece is packed in pieces of 240000000 bytes"),
    (_texts, "/texts is of type object"),
    (_reference, "attribute reference, is of type object"),
    (_type, "/type is neither"),
    (_empty, "/empty is empty"),
]


@pytest.mark.parametrize(("also", "said"), FOREIGN, ids=[also.__name__[1:] for also, _ in FOREIGN])
def test_contents_that_reach_out_or_unfold_are_refused(
    tmp_path: Path, also: Callable[[h5py.File], None], said: str
) -> None:
    path = write(tmp_path / "a.h5", also)
    with pytest.raises(Hdf5FileError, match=said), opened_hdf5(path):
        pass


def test_a_file_without_a_digest_is_read_in_a_process_of_its_own_first(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("values", data=np.arange(3.0))
    with opened_hdf5(path, unsealed=require_readable) as file:
        np.testing.assert_array_equal(file["values"][()], np.arange(3.0))
    path.write_bytes(path.read_bytes()[:-8])
    with pytest.raises(Hdf5FileError, match=r"damaged: .*truncated"), opened_hdf5(path, unsealed=require_readable):
        pass
    monkeypatch.setattr("app.files.isolation.START_SECONDS", 0.01)
    with pytest.raises(Hdf5FileError, match="not read within 0 s"), opened_hdf5(path, unsealed=require_readable):
        pass


@pytest.mark.parametrize(
    ("work", "refused"),
    [("while True: pass", "not read in 1 s of processor time"), ("import time; time.sleep(1.5)", "")],
    ids=["endless", "waiting"],
)
def test_a_reader_s_time_is_that_of_the_processor(
    work: str, refused: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside other programs a sound file may take long by the clock."""
    (tmp_path / "reader_at_work.py").write_text(work + "\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr("app.files.isolation.START_SECONDS", 1.0)
    monkeypatch.setattr("app.files.isolation.CLOCK_FACTOR", 30.0)
    with pytest.raises(SlowReadError, match=refused) if refused else nullcontext():
        run_isolated("reader_at_work", [], 0)


@pytest.mark.skipif(os.name == "nt", reason="signals as POSIX has them")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_to_a_reader_ends_the_program(
    number: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "reader_that_is_ended.py").write_text(f"import os\nos.kill(os.getpid(), {int(number)})\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with end_signals() as ends, pytest.raises(KeyboardInterrupt):
        run_isolated("reader_that_is_ended", [], 0)
    assert ends.status == 128 + number


def test_a_reader_has_one_thread(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of an algebra library, one for each core, take the address space that a reader is held to."""
    for pool in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        monkeypatch.delenv(pool, raising=False)
    told = tmp_path / "threads"
    lines = "import sys, threadpoolctl, numpy, pathlib\nfound = threadpoolctl.threadpool_info()\n"
    lines += "pathlib.Path(sys.argv[1]).write_text(str(max(one['num_threads'] for one in found)))\n"
    (tmp_path / "threads_of_reader.py").write_text(lines)
    monkeypatch.syspath_prepend(str(tmp_path))
    run_isolated("threads_of_reader", [str(told)], 0)
    assert told.read_text() == "1"


@pytest.mark.parametrize("entry", ["", ".", "here"])
def test_no_code_of_the_current_folder_is_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, entry: str) -> None:
    """Files lie where somebody else could put folders beside them that are named as ours."""
    path, ran = tmp_path / "a.h5", tmp_path / "ran"
    for package in ("app", "h5py"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "__init__.py").write_text(f"open({str(ran)!r}, 'w').close()")
    with h5py.File(path, "w") as file:
        file.create_dataset("values", data=np.arange(3.0))
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path) if entry == "here" else entry)
    require_readable(path)
    assert not ran.exists()
