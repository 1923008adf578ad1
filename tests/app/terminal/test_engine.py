"""How many processes are begun: those asked for, as far as they fit into memory."""

import os
from pathlib import Path

import pytest

from app.terminal.engine import Engine


def silent(stage: str, share: float) -> None:
    """Nothing is shown."""


@pytest.mark.parametrize(
    ("free", "asked", "said"),
    [(3.5e9, 4, ["2 of 4 workers: each takes up to 1.6 GB, and 3.5 GB of memory are free"]), (3.5e9, 2, [])],
)
def test_no_more_are_begun_than_fit(
    free: float, asked: int, said: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("app.terminal.engine.memory_left", lambda: free)
    notes: list[str] = []
    with Engine(asked).executor(tmp_path, 1.6e9, silent, notes.append) as executor:
        assert executor._max_workers == 2  # type: ignore[attr-defined]
        assert executor.submit(os.getpid).result() != os.getpid()
    assert notes == said


def test_one_is_begun_where_none_fits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("app.terminal.engine.memory_left", lambda: 1e8)
    notes: list[str] = []
    with Engine().executor(tmp_path, 1.6e9, silent, notes.append) as executor:
        assert executor.submit(pow, 2, 3).result() == 8
    assert notes == ["1 of 2 workers: each takes up to 1.6 GB, and 0.1 GB of memory are free"]
