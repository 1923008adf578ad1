"""A few hundred damaged files; ``python -m tests.fuzz`` reads twenty thousand, each within 40 s and 1 GB."""

from pathlib import Path

import pytest

pytest.importorskip("PySide6.QtSvg", reason="Qt cannot be loaded here", exc_type=ImportError)

from tests.fuzz.child import read_damaged, read_mutation, whole_files
from tests.fuzz.mutations import with_odd_values
from tests.fuzz.reader import Reader
from tests.fuzz.readers import READERS
from tests.fuzz.whole_files import write_all

COUNT = 250


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fuzz")
    write_all(folder)
    return folder


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("place", range(len(READERS)), ids=[reader.name for reader in READERS])
def test_damaged_files_are_read_or_refused_in_a_sentence(root: Path, place: int) -> None:
    reader = READERS[place]
    whole = whole_files(reader, root)
    outcomes = [
        read_mutation(place, root, whole, 1, number) for number in range(max(10, round(COUNT * reader.share)))
    ]
    assert not [said for came, said in outcomes if came not in ("read", "refused")]
    assert not [said for came, said in outcomes if "Traceback" in said]
    if reader.digest:
        assert [came for came, _ in outcomes].count("refused") > 0.5 * len(outcomes)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("reader", [r for r in READERS if r.name.startswith("TOML")], ids=lambda r: r.name)
def test_declarations_with_odd_values_are_read_or_refused_in_a_sentence(root: Path, reader: Reader) -> None:
    whole = whole_files(reader, root)
    for name in reader.files:
        for damaged in with_odd_values(whole[name][0]):
            came, said = read_damaged(reader, root, whole, name, damaged)
            assert came in ("read", "refused"), said
