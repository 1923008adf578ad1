"""Twelve simulated panels, recorded and run as a user does it: what scatters, which are not like the others."""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.files.settings_toml import toml_text
from tests.app.chain.conftest import typed

pytestmark = pytest.mark.slow
EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
COUNT, BATCH, HEAVY = 12, 4, 8
SCATTER = 0.03
"""Of E between pieces."""
OTHER_BATCH = -0.20
MASS = 1e-3


def write(file: Path, level: float, seed: int, mass: float) -> None:
    """Declare a panel whose E is the example's times exp(level), with its own noise."""
    table = tomllib.loads((EXAMPLES / "quick-rig.toml").read_text(encoding="utf-8"))
    simulation = table["simulation"]
    simulation |= {"served": False, "seed": seed}
    laws = simulation["laws"]
    laws["youngs_modulus"] = [float(e * np.exp(level)) for e in laws["youngs_modulus"]]
    if mass:
        simulation["effects"] = {"mass_at_place": {"mass": mass, "x": 0.07, "y": 0.05}}
    file.write_text(toml_text(table), encoding="utf-8")


@pytest.fixture(scope="module")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], np.ndarray]:
    """Record twelve panels and run them; what fleet.json says, and the true levels of those that belong."""
    folder = tmp_path_factory.mktemp("fleet")
    levels = np.random.default_rng(1).normal(0.0, SCATTER, COUNT)
    (folder / "panels").mkdir()
    for k, level in enumerate(levels):
        file = folder / f"panel-{k:02d}.toml"
        write(file, level + (OTHER_BATCH if k == BATCH else 0.0), k + 1, MASS if k == HEAVY else 0.0)
        assert typed("acquire", file, "--out", folder / "panels" / file.stem, "--quiet") == 0
    status = typed(
        *("run", folder / "panels", "--only", "update", "--workers", 1, "--out", folder / "out", "--quiet")
    )
    assert status in (0, 1)
    record = json.loads((folder / "out" / "fleet.json").read_text(encoding="utf-8"))
    return record, np.delete(levels, [BATCH, HEAVY])


def test_the_other_batch_and_the_hidden_mass_are_named(fleet: tuple[dict[str, Any], np.ndarray]) -> None:
    said = {one["name"]: one for one in fleet[0]["outliers"]}
    assert set(said) == {f"panel-{BATCH:02d}", f"panel-{HEAVY:02d}"}
    assert said[f"panel-{BATCH:02d}"]["quantity"] == "youngs_modulus"
    assert said[f"panel-{BATCH:02d}"]["deviation"] == pytest.approx(OTHER_BATCH, abs=0.08)
    assert said[f"panel-{HEAVY:02d}"]["quantity"] == "misfit"


def test_scatter_between_pieces_is_the_true_one(fleet: tuple[dict[str, Any], np.ndarray]) -> None:
    record, levels = fleet
    found = record["laws"]["youngs_modulus"]
    assert found["pieces"] == COUNT - 2
    assert found["between"] == pytest.approx(levels.std(ddof=1), rel=0.15)
    assert found["within"] < SCATTER / 5
