"""What is wrong with a rig or a folder stops `acquire` before a twin is built."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
Flexura = Callable[..., tuple[int, str, str]]


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("FLEXURA_CACHE", str(folder))
    return folder


def test_modules_are_looked_at_before_a_twin_is_built(tmp_path: Path, run_flexura: Flexura, cache: Path) -> None:
    file = tmp_path / "rig.toml"
    shutil.copy(EXAMPLES / "simulated-rig.toml", file)
    file.write_text(file.read_text(encoding="utf-8").replace("cDAQ1Mod2/ao0", "cDAQ1Mod7/ao0"), encoding="utf-8")
    status, _, err = run_flexura("acquire", file, "--out", tmp_path / "out")
    assert status == 2
    assert "Mod7" in err
    assert not list(cache.glob("*.h5"))


def test_a_folder_of_something_else_is_refused_before_a_twin_is_built(
    tmp_path: Path, run_flexura: Flexura, cache: Path
) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "letter.txt").write_text("mine", encoding="utf-8")
    status, _, err = run_flexura("acquire", EXAMPLES / "simulated-rig.toml", "--out", folder)
    assert status == 2
    assert "exists and is no campaign" in " ".join(err.split())
    assert not list(cache.glob("*.h5"))
