"""Keys of a terminal, also of one that has gone."""

import os
import sys

import pytest

from app.terminal.campaign import hammer_keys
from drivers.hammer.campaign import no_key

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="needs pseudo-terminals")


def test_a_terminal_that_has_gone_gives_no_key_and_ends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    import pty

    ours, theirs = pty.openpty()
    with os.fdopen(theirs) as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        with hammer_keys() as key:
            assert key() is None
            os.write(ours, b"x")
            assert key() is None
            os.write(ours, b"u")
            assert key() == "undo"
            os.close(ours)
            assert key() is None
            assert key() is None
        with hammer_keys() as key:
            assert key is no_key or key() is None
