"""Files that belong together: all of them are there, or what was there before."""

from pathlib import Path

import pytest

from app.files.atomic import written_together
from app.files.bad_file import ResultFileError

NAMES = ("a.wav", "b.csv", "c.h")


def write(folder, text):
    with written_together(folder, NAMES) as paths:
        for path in paths:
            path.write_text(text, encoding="utf-8")


def held(folder):
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.iterdir()) if path.is_file()}


def test_all_take_their_names_and_nothing_else_is_left(tmp_path):
    write(tmp_path / "new", "first")
    write(tmp_path / "new", "second")
    assert held(tmp_path / "new") == dict.fromkeys(NAMES, "second")


@pytest.mark.parametrize("taken", NAMES)
def test_a_name_that_cannot_be_taken_leaves_the_others_as_they_were(tmp_path, taken):
    """A folder of that name stands in the way: every rename before and after it is undone."""
    others = [name for name in NAMES if name != taken]
    for name in others[:1]:  # the other one is new
        (tmp_path / name).write_text("old", encoding="utf-8")
    (tmp_path / taken).mkdir()
    with pytest.raises(ResultFileError, match="cannot be written"):
        write(tmp_path, "new")
    assert held(tmp_path) == dict.fromkeys(others[:1], "old")


@pytest.mark.parametrize("refused", NAMES)
def test_a_rename_the_system_refuses_undoes_those_before(tmp_path, monkeypatch, refused):
    write(tmp_path, "old")
    replace = Path.replace

    def refusing(self, target):
        if self.name == refused + ".part":
            raise PermissionError(13, "in use by another program")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", refusing)
    with pytest.raises(ResultFileError, match="in use by another program"):
        write(tmp_path, "new")
    assert held(tmp_path) == dict.fromkeys(NAMES, "old")


def half_written(folder):
    with written_together(folder, NAMES) as paths:
        paths[0].write_text("half", encoding="utf-8")
        raise ZeroDivisionError


def test_an_error_while_they_are_written_leaves_nothing(tmp_path):
    with pytest.raises(ZeroDivisionError):
        half_written(tmp_path)
    assert held(tmp_path) == {}
