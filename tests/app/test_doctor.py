"""flexura doctor: what works on this computer, told with what to do about the rest."""

import json
import os
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner, Result
from serial.tools import list_ports

from app.main import flexura
from drivers.clock import SystemClock
from drivers.ni.simulated.servicer import SimulatedDaq, serving
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ovens.settings import oven_settings
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from tests.drivers.ovens.served import TcpPort

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "simulated-rig.toml"


@pytest.fixture
def laboratory(tmp_path: Path) -> Iterator[Path]:
    """Yield an experiment whose cards and oven are simulated, but at real ports, as the doctor sees real ones."""
    settings = oven_settings(
        {"kind": "watlow-f4t", "port": "simulated", "minimum": -5.0, "maximum": 65.0, "max_rate": 3.0}
    )
    clock = SystemClock()
    body = RegulatedOven(clock, np.random.default_rng(1), air=23.0, plate=23.0)
    server = SimulatedDaq(Surroundings(lambda drive, rate, temperature: drive[None], {"cDAQ1Mod1/ai1": 0}))
    with TcpPort(settings.simulated(body, clock)) as oven, serving(server) as cards:
        text = EXAMPLE.read_text(encoding="utf-8")
        text = text.replace('port = "simulated"', f'port = "{oven.address}"')
        text = text.replace('rig = "simulated"', 'rig = "ni"').replace("[cards]", f'[cards]\ngrpc = "{cards}"')
        file = tmp_path / "laboratory.toml"
        file.write_text(text, encoding="utf-8")
        yield file


def run(*words: object) -> Result:
    return CliRunner().invoke(flexura, ["doctor", *(str(word) for word in words)])


def findings(result: Result) -> dict[str, dict[str, str]]:
    return {row["what"]: row for row in json.loads(result.stdout)["findings"]}


def test_all_there(laboratory: Path) -> None:
    result = run(laboratory, "--json")
    assert result.exit_code == 0, result.output
    found = findings(result)
    assert json.loads(result.stdout)["ready"] is True
    assert found["NI device cDAQ1Mod1"]["seen"].startswith("NI 9234, 4 inputs")
    assert found["terminals of [cards]"] == {
        "what": "terminals of [cards]",
        "state": "good",
        "seen": "all 4 exist",
        "next_step": "",
    }
    (oven,) = [row for what, row in found.items() if what.startswith("oven")]
    assert re.fullmatch(r"answers 2[23]\.\d °C", oven["seen"])
    assert found["disk"]["state"] == found["clock"]["state"] == "good"


def test_a_terminal_that_is_not_there_is_named_with_those_that_are(laboratory: Path) -> None:
    text = laboratory.read_text(encoding="utf-8")
    laboratory.write_text(text.replace("cDAQ1Mod1/ai1", "cDAQ1Mod4/ai1"), encoding="utf-8")
    result = run(laboratory, "--json")
    assert result.exit_code == 1
    terminals = findings(result)["terminals of [cards]"]
    assert terminals["seen"] == "not there: cDAQ1Mod4/ai1"
    assert "cDAQ1Mod1/ai1" in terminals["next_step"]


def test_nobody_answers(laboratory: Path, tmp_path: Path) -> None:
    text = laboratory.read_text(encoding="utf-8")
    silent = re.sub(r'"(socket://)?127\.0\.0\.1:\d+"', lambda match: f'"{match[1] or ""}127.0.0.1:9"', text)
    (tmp_path / "silent.toml").write_text(silent, encoding="utf-8")
    result = run(tmp_path / "silent.toml")
    assert result.exit_code == 1
    assert "not ready: NI driver, oven watlow-f4t" in result.stderr
    assert "check the address in grpc" in result.stdout
    assert "Check the port's name" in result.stdout


def test_without_an_experiment_nothing_is_needed() -> None:
    result = run("--json")
    assert result.exit_code == 0
    assert {"disk", "clock", "NI driver"} <= set(findings(result))


def test_a_simulated_rig_needs_neither_driver_nor_oven() -> None:
    result = run(EXAMPLE)
    assert result.exit_code == 0
    assert "7 sweeps, about 1 h 27 min" in result.stdout


def test_a_lag_that_no_data_would_show_is_told() -> None:
    """Of the paper's own protocol: E, nu and eta were three sigma off without a word."""
    result = run(EXAMPLE.parent / "paper-protocol.toml", "--json")
    found = findings(result)["temperature of the plate"]
    assert found["state"] == "note"
    assert "one ramp of 0.4 K/min: the plate may be 2 K behind it" in found["seen"]
    assert "temperature of the plate" not in findings(run(EXAMPLE, "--json"))  # a thermocouple triggers there


def test_a_simulated_rig_that_cannot_be_wired_is_not_ready(tmp_path: Path) -> None:
    """It said "ready", and acquire refused the file."""
    wrong = tmp_path / "wrong.toml"
    wrong.write_text(
        EXAMPLE.read_text(encoding="utf-8").replace("cDAQ1Mod1/ai1", "cDAQ1Mod7/ai1"), encoding="utf-8"
    )
    result = run(wrong)
    assert result.exit_code == 1
    assert "terminal 'cDAQ1Mod7/ai1' is wired but not there" in result.output
    assert "in [cards] terminals of simulation.modules" in result.output


def test_too_small_a_disk(laboratory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    usage = shutil.disk_usage(laboratory.parent)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage._replace(free=10_000_000))
    result = run(laboratory, "--json")
    assert result.exit_code == 1
    assert findings(result)["disk"]["next_step"].startswith("make room")


def test_a_disk_whose_time_is_another(monkeypatch: pytest.MonkeyPatch) -> None:
    real = os.stat

    def skewed(path: object, **options: object) -> os.stat_result:
        found = real(path, **options)  # type: ignore[arg-type]
        return os.stat_result((*found[:8], found[8] - 90, found[9]))

    with monkeypatch.context() as patch:
        patch.setattr(os, "stat", skewed)
        result = run("--json", "--out", Path.cwd())
    assert findings(result)["clock"]["state"] == "note"
    assert "s from that of the disk" in findings(result)["clock"]["seen"]


@pytest.mark.skipif(sys.platform == "win32", reason="folders are not made read-only there")
@pytest.mark.skipif(hasattr(os, "geteuid") and os.geteuid() == 0, reason="root may write anywhere")
def test_a_disk_that_cannot_be_written(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    assert run("--out", tmp_path / "campaign").exit_code == 1
    tmp_path.chmod(0o700)


def test_a_file_in_the_place_of_a_folder(tmp_path: Path) -> None:
    """No campaign can be made below it, nor is a twin reduced for one."""
    (tmp_path / "notes").write_text("")
    result = run(EXAMPLE, "--json", "--out", tmp_path / "notes" / "campaign")
    assert findings(result)["disk"]["seen"] == f"{tmp_path / 'notes'} is a file"
    words = ["acquire", str(EXAMPLE), "--out", str(tmp_path / "notes" / "campaign")]
    assert f"{tmp_path / 'notes'} is a file; allowed: a folder" in CliRunner().invoke(flexura, words).output


@pytest.mark.parametrize(("description", "seen"), [("n/a", ""), ("USB-RS485", ": USB-RS485")])
def test_a_port_without_a_description_has_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, description: str, seen: str
) -> None:
    port = tmp_path / "ttyS0"
    port.touch()
    found = SimpleNamespace(device=str(port), description=description)
    monkeypatch.setattr(list_ports, "comports", lambda: [found])
    assert f"serial port {port}{seen}\n" in run().stdout


def test_ready_says_for_what(laboratory: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(list_ports, "comports", list)
    lacks = "ready for analysis and the simulated rig; for a real rig is missing: NI driver, serial ports\n"
    assert run().stderr == lacks
    assert run(laboratory).stderr == f"ready for {laboratory}\n"
