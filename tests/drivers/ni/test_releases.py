"""Other releases of nidaqmx: the oldest with a gRPC extra worth having, one between, and the newest.

Each gets an environment of its own, in which the user's script drives this process' server over a
port, and the cards' driver drives the server of that environment, down to the last bit.
"""

import hashlib
import os
import subprocess
import sys
import venv
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from drivers.ni.daqmx import DaqmxCards
from drivers.ni.simulated.servicer import InProcessChannel, SimulatedDaq, serving
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring

ROOT = Path(__file__).resolve().parents[3]
# What the numbers depend on, and what the driver cannot be imported without.
BESIDE = [f"{name}=={version(name)}" for name in ("numpy", "scipy", "pydantic")]

DRIVER = """
import hashlib, sys
import numpy as np
from drivers.ni.daqmx import DaqmxCards
from drivers.ni.simulated.servicer import InProcessChannel
from drivers.ni.simulated.servicer import SimulatedDaq
from drivers.ni.simulated.surroundings import Surroundings
from drivers.ni.wiring import Wiring

plate = lambda drive, rate, temperature: 0.5 * drive[None]
server = SimulatedDaq(Surroundings(plate, {"cDAQ1Mod1/ai1": 0}), seed=4)
wiring = Wiring.model_validate_json(sys.argv[1])
with DaqmxCards(wiring, InProcessChannel(server)) as cards:
    record = cards.sweep(np.sin(np.arange(20_000) / 10.0))
    temperatures = cards.temperatures()
assert server.lacking == set(), server.lacking
print(hashlib.sha256(record.drive.tobytes() + record.responses.tobytes() + temperatures.tobytes()).hexdigest())
"""


@pytest.fixture(scope="module")
def index(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Skip where packages cannot be had at all; a release that cannot be installed is a failure."""
    pinned = f"nidaqmx=={version('nidaqmx')}"
    probe = subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "download",
            "--no-deps",
            "-q",
            "-d",
            tmp_path_factory.mktemp("probe"),
            pinned,
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    if probe.returncode:
        pytest.skip(f"no package index answers: {probe.stderr.strip().splitlines()[-1]}")


@pytest.fixture(scope="module", params=["nidaqmx[grpc]==0.9.0", "nidaqmx[grpc]==1.2.0", "nidaqmx[grpc]"])
def python(index: None, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("release")
    venv.create(folder, with_pip=True)
    interpreter = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    subprocess.run([interpreter, "-m", "pip", "install", "-q", request.param, *BESIDE], check=True)
    return interpreter


@pytest.mark.slow
def test_script_runs_unmodified(python: Path, surroundings: Surroundings) -> None:
    server = SimulatedDaq(surroundings, seed=7)
    with serving(server) as address:
        done = subprocess.run(
            [python, ROOT / "examples/nidaqmx_script.py", address], capture_output=True, text=True, check=False
        )
    assert done.returncode == 0, done.stderr
    assert "ai0 peak 439.72 Hz amplitude 1.50000" in done.stdout
    assert server.lacking == set()
    assert server.output_voltage() == 0.0


@pytest.mark.slow
def test_driver_measures_the_same_to_the_last_bit(python: Path, wiring: Wiring) -> None:
    one = wiring.model_copy(update={"responses": wiring.responses[:1]})
    server = SimulatedDaq(
        Surroundings(lambda drive, rate, temperature: 0.5 * drive[None], {"cDAQ1Mod1/ai1": 0}), seed=4
    )
    with DaqmxCards(one, InProcessChannel(server)) as cards:
        record = cards.sweep(np.sin(np.arange(20_000) / 10.0))
        temperatures = cards.temperatures()
    here = hashlib.sha256(record.drive.tobytes() + record.responses.tobytes() + temperatures.tobytes()).hexdigest()
    done = subprocess.run(
        [python, "-c", DRIVER, one.model_dump_json()],
        cwd=ROOT,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == here
