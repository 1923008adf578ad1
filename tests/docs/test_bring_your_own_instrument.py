"""The page on instruments of one's own: its package, installed as by pip, passes the checks; its keys are true."""

import json
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

from app.files.allowed_values import keys_at
from drivers.ovens.declared_oven import ModbusMapOven, ScpiOven
from drivers.ovens.registers import Number, RunRegister, StatusRegister
from drivers.ovens.settings import oven_settings
from drivers.ovens.text_protocol import Phrase, RunPhrase, StatusPhrase
from drivers.thermometers.thermometer import THERMOMETERS

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "guide" / "bring-your-own-instrument.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


def tables() -> Iterator[dict[str, Any]]:
    """Yield every TOML block, read."""
    return map(tomllib.loads, blocks("toml"))


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """Return a folder with the page's package as an installation leaves it."""
    package = next(table for table in tables() if "project" in table)
    points = package["project"]["entry-points"]
    (module,) = package["tool"]["setuptools"]["py-modules"]
    (tmp_path / f"{module}.py").write_text(blocks("python")[0], encoding="utf-8")
    info = tmp_path / f"{module}-1.0.dist-info"
    info.mkdir()
    name = package["project"]["name"]
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n", encoding="utf-8")
    listed = [
        f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in kinds.items()) for group, kinds in points.items()
    ]
    (info / "entry_points.txt").write_text("".join(listed), encoding="utf-8")
    return tmp_path


def flexura(site: Path, *words: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(ROOT), str(site)])
    return subprocess.run(
        [sys.executable, "-m", "flexura", *words],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )


def test_the_package_passes_every_check(site: Path) -> None:
    done = flexura(site, "check-instrument", "hotbox-3", "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)["checks"]
    assert [(row["name"], row["said"]) for row in told if row["result"] != "passed"] == []
    assert len(told) == 19


def test_the_package_is_not_there_where_it_is_not_installed(tmp_path: Path) -> None:
    done = flexura(tmp_path, "check-instrument", "hotbox-3")
    assert done.returncode == 2
    assert "flexura.ovens" in done.stderr


def test_a_file_with_its_kind_is_read_and_its_keys_are_checked(site: Path) -> None:
    text = (ROOT / "examples" / "simulated-rig.toml").read_text(encoding="utf-8")
    file = site / "mine.toml"
    file.write_text(text.replace('kind = "watlow-f4t"', 'kind = "hotbox-3"\nbaud = 9600'), encoding="utf-8")
    done = flexura(site, "safe", str(file), "--rig", "simulated")
    assert done.returncode == 2
    assert "oven.baud = unknown key" in done.stderr
    assert "baud_rate" in done.stderr
    file.write_text(text.replace('kind = "watlow-f4t"', 'kind = "hotbox-3"'), encoding="utf-8")
    done = flexura(site, "safe", str(file), "--rig", "simulated")
    assert done.returncode == 0, done.stderr
    assert "the oven is at rest" in done.stderr


def test_every_oven_and_thermometer_on_the_page_is_one() -> None:
    ovens = [table["oven"] for table in tables() if "oven" in table]
    assert {oven["kind"] for oven in ovens} == {"modbus-map", "scpi"}
    for oven in ovens:
        oven_settings({key: value for key, value in oven.items() if key != "room_temperature"})
    (thermometer,) = (table["thermometer"] for table in tables() if "thermometer" in table)
    THERMOMETERS.find(thermometer["kind"]).model_validate(thermometer)


@pytest.mark.parametrize(
    "model", [ModbusMapOven, Number, RunRegister, StatusRegister, ScpiOven, Phrase, RunPhrase, StatusPhrase]
)
def test_every_key_is_on_the_page(model: type[BaseModel]) -> None:
    """Those of a line are explained with the ovens that have a driver."""
    known = set(re.findall(r"`(\w+)`", PAGE)) | set(re.findall(r"^(\w+) = ", PAGE, re.MULTILINE))
    elsewhere = {"timeout", "retries", "gap_after_read", "gap_after_write", "lost_after", "parity", "stop_bits"}
    assert set(keys_at(model, ())) - known - elsewhere == set()
