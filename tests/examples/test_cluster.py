"""The scripts that make clusters, each with one fleet of two small recordings; ssh and Slurm are stood in for."""

import json
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.app.conftest import tiny_campaign

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("distributed") is None, reason="the extra cluster is not installed"),
]
EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "cluster"
SSH = """#!/bin/sh
while [ "$1" != "${1#-}" ]; do if [ "$1" = -o ]; then shift; fi; shift; done
echo "$1" >> %(log)s
shift
exec sh -c "$*"
"""
SBATCH = """#!/bin/sh
echo sbatch >> %(log)s
setsid sh "$1" > %(log)s.job 2>&1 < /dev/null &
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
echo scancel >> %(log)s
kill -- -"$1"
"""


@pytest.fixture
def campaigns(tmp_path: Path) -> Path:
    for name in ("first", "second"):
        tiny_campaign().write(tmp_path / "doors" / name)
    return tmp_path / "doors"


def stand_in(folder: Path, **programs: str) -> Path:
    """Write programs of other names; the file that they note their calls in."""
    folder.mkdir()
    log = folder / "log"
    for name, text in programs.items():
        (folder / name).write_text(text % {"log": log})
        (folder / name).chmod(0o755)
    return log


def run(script: str, first: str, campaigns: Path, programs: Path | None = None) -> dict[str, object]:
    words = ["run", str(campaigns), "--until", "identify", "--out", str(campaigns.parent / "out"), "--quiet"]
    before = "" if programs is None else f"{programs}{os.pathsep}"
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / script), first, *words],
        env=os.environ | {"PATH": before + os.environ["PATH"]},
        cwd=campaigns.parent,
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, object] = json.loads((campaigns.parent / "out" / "fleet.json").read_text(encoding="utf-8"))
    return found


def assert_done(record: dict[str, object]) -> None:
    pieces = record["pieces"]
    assert isinstance(pieces, list)
    assert [(one["name"], one["good"]) for one in pieces] == [("first", True), ("second", True)]


def test_a_cluster_of_this_machine(campaigns: Path) -> None:
    assert_done(run("local_cluster.py", "2", campaigns))


def test_a_cluster_over_ssh(campaigns: Path, tmp_path: Path) -> None:
    log = stand_in(tmp_path / "programs", ssh=SSH)
    assert_done(run("ssh_cluster.py", "anna,bert:1", campaigns, log.parent))
    assert sorted(log.read_text().split()) == ["anna", "bert"]


@pytest.mark.skipif(find_spec("dask_jobqueue") is None, reason="the extra slurm is not installed")
def test_a_cluster_of_slurm_jobs(campaigns: Path, tmp_path: Path) -> None:
    log = stand_in(tmp_path / "programs", sbatch=SBATCH, scancel=SCANCEL)
    assert_done(run("slurm_cluster.py", "1", campaigns, log.parent))
    assert "sbatch" in log.read_text().split()


@pytest.mark.skipif(find_spec("snakemake") is None, reason="Snakemake is not installed")
def test_jobs_of_snakemake(campaigns: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [
            *(sys.executable, "-m", "snakemake", "--cores", "1", "--snakefile", str(EXAMPLES / "Snakefile")),
            *("--config", f"campaigns={campaigns}", f"out={tmp_path / 'out'}", "until=identify"),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert_done(json.loads((tmp_path / "out" / "fleet.json").read_text(encoding="utf-8")))
