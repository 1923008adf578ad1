"""flexura simulate-daq: a user's own nidaqmx script against the cards it serves."""

import json
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from app.main import flexura
from drivers.ni.simulated.servicer import SimulatedDaq, serving
from drivers.ni.simulated.surroundings import Surroundings

ROOT = Path(__file__).resolve().parents[2]
EXAMPLE = ROOT / "examples" / "simulated-rig.toml"


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT for one child alone")
def test_serves_until_ctrl_c(tmp_path: Path) -> None:
    text = EXAMPLE.read_text(encoding="utf-8").replace("[100.0, 1500.0]", "[100.0, 600.0]")  # as in test_acquire
    file = tmp_path / "mine.toml"
    file.write_text(text.replace("duration = 2.0", "duration = 1.0"), encoding="utf-8")
    command = [sys.executable, "-m", "flexura", "simulate-daq", str(file), "--port", "0", "--json"]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout is not None
            told = json.loads(child.stdout.readline())
            assert told["address"].startswith("127.0.0.1:")
            assert "cDAQ1Mod2/ao0" in told["terminals"]
            script = [sys.executable, str(ROOT / "examples" / "nidaqmx_script.py"), told["address"]]
            done = subprocess.run(script, capture_output=True, text=True, timeout=120, check=False)
            assert done.returncode == 0, done.stderr
        finally:
            child.send_signal(signal.SIGINT)
        _, said = child.communicate(timeout=30)
    assert child.returncode == 0, said
    assert "not simulated" not in said
    levels = dict(re.findall(r"^(ai\d) peak 4[34]\d\.\d\d Hz amplitude ([\d.]+) V$", done.stdout, re.MULTILINE))
    assert float(levels["ai0"]) == pytest.approx(1.5, rel=1e-3)  # the drive's own input
    assert 0.001 < float(levels["ai1"]) < 5.0  # the plate answers


def test_a_port_that_is_taken_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    server = SimulatedDaq(Surroundings(lambda drive, rate, temperature: drive[None], {}))
    monkeypatch.setattr("app.rig.simulated_rig.simulated_rig", lambda *_: type("Parts", (), {"server": server}))
    with serving(server) as address:
        result = CliRunner().invoke(flexura, ["simulate-daq", "--port", address.rpartition(":")[2]])
    assert result.exit_code == 1
    assert "choose another with --port" in result.output


def test_a_sound_card_has_no_device_server() -> None:
    result = CliRunner().invoke(
        flexura, ["simulate-daq", str(ROOT / "examples" / "sound-card.toml"), "--port", "0"]
    )
    assert result.exit_code == 1
    assert "cards.kind" in result.output
    assert "'soundcard'; allowed: 'ni'" in result.output
