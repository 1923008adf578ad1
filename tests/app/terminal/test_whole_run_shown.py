"""The end of a run on a narrow terminal: what is to be copied stays in one piece."""

import pytest

from app.files.results.run_record import RunRecord
from app.terminal.whole_run import show


def test_a_command_is_on_one_line_below_the_table(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    command = "flexura gap '/data of May/a campaign with a long name' --out '/results/first one'"
    show(
        RunRecord(
            campaign="x",
            stages={},
            found=(
                ("modes", "three modes " * 10),
                ("next", f"Ask what the twin lacks: {command}\nMore: the guide"),
            ),
        )
    )
    lines = capsys.readouterr().out.splitlines()
    assert f"next: Ask what the twin lacks: {command}" in lines
    assert lines[-1] == "next: More: the guide"
    assert any("three modes" in line and "│" in line for line in lines)
