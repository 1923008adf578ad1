"""What is declared but not computed yet stops a verb before a twin is built, named by its key."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
Flexura = Callable[..., tuple[int, str, str]]


def growing(text: str) -> str:
    """Declare a plate that grows with temperature."""
    assert text.count("\n[plate]\n") == 1
    return text.replace("\n[plate]\n", "\n[plate]\ndimensions_at = 23.0\nexpansion = 1.5e-4\n")


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv("FLEXURA_CACHE", str(folder))
    return folder


def refused(answer: tuple[int, str, str], cache: Path) -> None:
    status, _, err = answer
    assert status == 2
    assert "plate.expansion = 0.00015 1/K: thermal expansion can be declared" in " ".join(err.split())
    assert not cache.exists()


@pytest.mark.parametrize("verb", ["update", "gap"])
def test_a_campaign(verb: str, cut_recording, tmp_path: Path, run_flexura: Flexura, cache: Path) -> None:
    folder = tmp_path / "plate"
    cut_recording(folder, (0, 28, 60))
    file = folder / "campaign.toml"
    file.write_text(growing(file.read_text(encoding="utf-8")), encoding="utf-8")
    refused(run_flexura(verb, folder, "--out", tmp_path / "run"), cache)


def test_a_simulated_rig(tmp_path: Path, run_flexura: Flexura, cache: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(growing((EXAMPLES / "simulated-rig.toml").read_text(encoding="utf-8")), encoding="utf-8")
    refused(run_flexura("acquire", file, "--out", tmp_path / "out"), cache)


def test_a_panel_before_the_laws_are_looked_for(tmp_path: Path, run_flexura: Flexura, cache: Path) -> None:
    text = (EXAMPLES / "section2-panel.toml").read_text(encoding="utf-8")
    file = tmp_path / "panel.toml"
    file.write_text(growing(text), encoding="utf-8")
    refused(run_flexura("focus", tmp_path / "no-run", "--panel", file), cache)


def test_modules_are_looked_at_before_a_twin_is_built(tmp_path: Path, run_flexura: Flexura, cache: Path) -> None:
    file = tmp_path / "rig.toml"
    shutil.copy(EXAMPLES / "simulated-rig.toml", file)
    file.write_text(file.read_text(encoding="utf-8").replace("cDAQ1Mod2/ao0", "cDAQ1Mod7/ao0"), encoding="utf-8")
    status, _, err = run_flexura("acquire", file, "--out", tmp_path / "out")
    assert status == 2
    assert "Mod7" in err
    assert not cache.exists()


def test_a_folder_of_something_else_is_refused_before_a_twin_is_built(
    tmp_path: Path, run_flexura: Flexura, cache: Path
) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "letter.txt").write_text("mine", encoding="utf-8")
    status, _, err = run_flexura("acquire", EXAMPLES / "simulated-rig.toml", "--out", folder)
    assert status == 2
    assert "exists and is no campaign" in " ".join(err.split())
    assert not cache.exists()
