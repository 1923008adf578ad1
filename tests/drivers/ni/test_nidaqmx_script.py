"""A user's own script, unmodified, against the simulated server on a port."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from drivers.ni.simulated.servicer import SimulatedDaq, serving

SCRIPT = Path(__file__).resolve().parents[3] / "examples" / "nidaqmx_script.py"


def run(address: str, *options: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", str(SCRIPT), address, *options],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def levels(printed: str) -> dict[str, tuple[float, float]]:
    found = re.findall(r"^(ai\d) peak ([\d.]+) Hz amplitude ([\d.]+) V$", printed, re.MULTILINE)
    return {name: (float(peak), float(level)) for name, peak, level in found}


def test_knows_nothing_of_this_project() -> None:
    text = SCRIPT.read_text(encoding="utf-8")
    assert not re.search(r"^\s*(from|import) (analysis|app|drivers|simulation)\b", text, re.MULTILINE)


@pytest.mark.parametrize(("frequency", "amplitude"), [(440.0, 1.5), (1200.0, 0.25)])
def test_measures_the_tone_it_plays(
    server: SimulatedDaq, plate: object, frequency: float, amplitude: float
) -> None:
    with serving(server) as address:
        printed = run(address, "--frequency", str(frequency), "--amplitude", str(amplitude))
    assert "cDAQ1Mod1: NI 9234" in printed
    assert "rate 8533.3333 Hz" in printed
    measured = levels(printed)
    gain = abs(plate.response(np.array([frequency]), 51_200.0 / 6.0)[0, 0])  # type: ignore[attr-defined]
    assert measured["ai0"][0] == pytest.approx(frequency, abs=1.1)  # half a line of the spectrum and a little
    assert measured["ai0"][1] == pytest.approx(amplitude, rel=1e-4)
    assert measured["ai1"][1] == pytest.approx(gain * amplitude, rel=1e-3)
    assert server.output_voltage() == 0.0
    assert server.lacking == set()
