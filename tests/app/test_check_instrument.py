"""flexura check-instrument: what it says, and what it refuses."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from app.commands import check_instrument
from app.main import flexura, main
from drivers.checks.trial import CheckVerdict
from drivers.ovens.f4t import F4T
from drivers.ovens.line_settings import SerialPort
from drivers.rig.occupancy import occupied

DECLARED = """\
[oven]
kind = "scpi"
port = "/dev/there-is-none"
minimum = 0.0
maximum = 60.0
max_rate = 2.0
room_temperature = 22.0
temperature = { query = "MEAS:TEMP?" }
set_point = { query = "SOUR:TEMP?", command = "SOUR:TEMP {value}" }
rest_at = 22.0

[thermometer]
kind = "modbus-map"
port = "/dev/there-is-none"
sensors = [{ at = 0, scale = 0.1 }]
"""

CARDS = """\
[cards]
output = "cDAQ1Mod2/ao0"
drive_input = "cDAQ1Mod1/ai0"
responses = ["cDAQ1Mod1/ai1"]
sample_rate = 8500.0
"""


def run(*words: object) -> Result:
    return CliRunner().invoke(flexura, ["check-instrument", *(str(word) for word in words)])


def refused(capsys: pytest.CaptureFixture[str], named: object) -> str:
    """Run it as the shell does; return what it says on its way to exit status 2."""
    with pytest.raises(SystemExit) as ended:
        main(["check-instrument", str(named)])
    assert ended.value.code == 2
    return capsys.readouterr().err


@pytest.fixture
def declared(tmp_path: Path) -> Path:
    file = tmp_path / "mine.toml"
    file.write_text(DECLARED, encoding="utf-8")
    return file


def test_a_kind_by_its_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SerialPort, "__init__", lambda *_: pytest.fail("no hardware is touched"))
    result = run("watlow-f4t")
    assert result.exit_code == 0, result.output
    assert result.stdout.count("passed ") == 19
    assert "19 of 19 checks passed" in result.stderr


def test_what_a_file_declares(declared: Path) -> None:
    result = run(declared, "--json")
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["passed"] is True
    assert {row["instrument"] for row in told["checks"]} == {"oven scpi", "thermometer modbus-map"}
    assert all(row["why"] for row in told["checks"])


def test_a_driver_that_fails(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(F4T, "safe", lambda self: None)
    result = run("watlow-f4t")
    assert result.exit_code == 1
    assert "checks failed: " in result.stderr
    assert "rest may be requested twice (oven watlow-f4t)" in result.stderr
    assert "it reported no error when brought to rest, and continues" in result.stdout


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (('kind = "scpi"', 'kind = "scpy"'), "did you mean scpi?"),
        (("rest_at = 22.0", ""), "neither run nor rest_at"),
        (("at = 0", "at = -1"), "thermometer.sensors[0].at"),
        (("at = 0", "register = 0"), "thermometer.sensors[0].register"),
        (("[oven]", "[plate]"), "unknown key"),
    ],
)
def test_a_bad_declaration(
    declared: Path, change: tuple[str, str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = declared.read_text(encoding="utf-8").replace(*change)
    if change[0] == "[oven]":
        text, told = text.split("[thermometer]")[0], "no [cards], no [oven]"
    declared.write_text(text, encoding="utf-8")
    assert told in refused(capsys, declared)


@pytest.mark.parametrize(
    ("named", "told"), [("toaster", "'espec-p300'"), ("modbus-map", "it needs set_point, temperature")]
)
def test_a_bad_kind(named: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert told in refused(capsys, named)


def test_really_without_an_instrument_is_not_known_to_be_at_rest(declared: Path) -> None:
    result = run(declared, "--really", "--json")
    assert result.exit_code == 3
    told = json.loads(result.stdout)
    assert told["really"] is True
    assert "cannot be opened" in told["unsafe"][0]
    assert [row["name"] for row in told["checks"]] == ["answers at all", "answers at all"]
    assert "NOT AT REST" in result.stderr


def test_a_drive_that_cannot_be_brought_to_0_v_is_told(tmp_path: Path) -> None:
    """Without the NI driver nobody knows what the output plays."""
    file = tmp_path / "mine.toml"
    file.write_text(CARDS, encoding="utf-8")
    result = run(file, "--really", "--json")
    assert result.exit_code == 3
    assert "turn the amplifier off" in json.loads(result.stdout)["unsafe"][0]
    assert "NOT AT REST: the drive" in result.stderr


@pytest.mark.parametrize("how", ["Ctrl-C between two instruments", "a line that cannot be printed"])
def test_really_cut_short_all_is_brought_to_rest(
    declared: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    rested: list[bool] = []
    started: list[str] = []

    def checks(*_: object, **__: object) -> Iterator[CheckVerdict]:
        started.append("")
        yield CheckVerdict("silence", "a dead line must end a campaign", "passed", "")
        if how.startswith("Ctrl-C"):
            signal.raise_signal(signal.SIGINT)

    def rest(_: object) -> tuple[str, ...]:
        signal.raise_signal(signal.SIGINT)  # once more: nothing cuts the rest short
        rested.append(True)
        return ()

    for name in ("check_real_oven", "check_thermometer"):
        monkeypatch.setattr(f"drivers.checks.instruments.{name}", checks)
    monkeypatch.setattr(check_instrument, "_rest", rest)
    if not how.startswith("Ctrl-C"):
        monkeypatch.setattr(check_instrument, "show", raises_broken_pipe)
    result = run(declared, "--really")
    assert rested == [True]
    assert result.exit_code != 0
    if how.startswith("Ctrl-C"):
        assert "stopped by SIGINT before the others" in result.stdout
        assert len(started) == 1


def raises_broken_pipe(*_: object) -> None:
    raise BrokenPipeError


def test_instruments_in_use_are_left_alone(declared: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A campaign has the oven: the checks would ramp it, and rest it."""
    monkeypatch.setattr(SerialPort, "__init__", lambda *_: pytest.fail("the instrument was asked"))
    with occupied(["oven at /dev/there-is-none"], "flexura acquire, campaign mine"):
        result = run(declared, "--really", "--json")
        assert run(declared).exit_code == 0  # the simulated counterparts are nobody's
    assert result.exit_code == 3
    told = json.loads(result.stdout)
    assert (told["passed"], told["checks"]) == (False, [])
    assert "flexura acquire, campaign mine" in told["unsafe"][0]


def test_a_verdict_is_shown_with_why_it_matters(capsys: pytest.CaptureFixture[str]) -> None:
    check_instrument.show([CheckVerdict("silence", "a dead line must end a campaign", "FAILED", "told 0 °C")])
    shown = capsys.readouterr().out
    assert "silence" in shown
    assert "a dead line must end a campaign" in shown
    assert "told 0 °C" in shown
