"""Examples are copied from wherever Flexura is installed, and what lacks them says how to get them."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

import flexura
from app.files import shipped

Flexura = Callable[..., tuple[int, str, str]]
ROOT = Path(__file__).resolve().parents[2]


def files(folder: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.suffix != ".pyc"
    }


def test_they_are_listed_with_what_they_are(run_flexura: Flexura) -> None:
    status, out, _ = run_flexura("examples", "--json")
    found = {row["name"]: row["about"] for row in json.loads(out)}
    assert status == 0
    assert set(found) == {p.name for p in (ROOT / "examples").iterdir() if not p.name.startswith((".", "_"))}
    assert all(len(about) > 8 for about in found.values()), found
    assert "Seven sweeps" in found["simulated-rig.toml"]
    # whole sentences, however the lines are broken in the file; a heading ends without a full stop
    assert found["exciter.toml"].endswith("a patch and a patch with a charge amplifier; all simulated.")
    assert found["quick-panel.toml"].endswith("so that it is reduced in seconds.")
    assert found["pp-plate"] == "A polypropylene plate from 0 to 60 °C"


def test_the_library_names_the_same_examples() -> None:
    with pytest.raises(ValueError, match="no example 'none'") as raised:
        flexura.example("none")
    assert str(raised.value).endswith(", ".join(shipped.shipped_names()))


def test_a_file_and_a_folder_are_copied_and_nothing_is_overwritten(
    run_flexura: Flexura, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run_flexura("examples", "quick-rig.toml")[0] == 0
    assert run_flexura("examples", "examples/pp-plate/", "-q") == (0, "", "")
    assert (tmp_path / "quick-rig.toml").read_bytes() == (ROOT / "examples" / "quick-rig.toml").read_bytes()
    assert files(tmp_path / "pp-plate") == files(ROOT / "examples" / "pp-plate")
    status, _, err = run_flexura("examples", "pp-plate")
    assert status == 2
    assert "pp-plate: is there already; name another folder with --out" in err
    assert run_flexura("examples", "pp-plate", "--out", "other")[0] == 0
    assert files(tmp_path / "other" / "pp-plate") == files(ROOT / "examples" / "pp-plate")


def test_with_all_the_commands_of_help_can_be_typed(
    run_flexura: Flexura, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    status, _, err = run_flexura("identify", "examples/pp-plate")
    assert status == 2
    assert "it comes with Flexura: flexura examples --all" in err
    assert run_flexura("examples", "--all", "-q")[0] == 0
    assert files(tmp_path / "examples") == files(ROOT / "examples")


@pytest.mark.parametrize("name", ["none", "../setup.cfg", "/etc/passwd", "", "pp-plate/sweeps", "..", "."])
def test_no_other_name_copies_anything(
    run_flexura: Flexura, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(tmp_path)
    status, out, err = run_flexura("examples", name)
    assert (status, out) == (2, "")
    assert "pp-plate" in err
    assert list(tmp_path.iterdir()) == []


def test_an_installation_without_them_says_so(
    run_flexura: Flexura, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shipped, "CLONE", tmp_path / "none")
    monkeypatch.setattr(shipped, "INSTALLED", tmp_path / "none")
    status, _, err = run_flexura("examples", "pp-plate")
    assert status == 2
    assert "none here" in err


def test_an_ending_may_be_left_out_and_a_mistyped_name_is_answered_with_the_nearest(
    run_flexura: Flexura, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run_flexura("examples", "quick-rig", "-q")[0] == 0
    assert (tmp_path / "quick-rig.toml").is_file()
    status, _, said = run_flexura("examples", "pp-plat")
    assert status == 2
    assert "no example 'pp-plat'; did you mean pp-plate? there are: " in said


def test_a_mistyped_file_or_folder_is_answered_with_the_one_beside_it(
    run_flexura: Flexura, tmp_path: Path
) -> None:
    (tmp_path / "Meine Prüfung.toml").touch()
    status, _, said = run_flexura("acquire", tmp_path / "Meine Prufung.toml")
    assert status == 2
    assert f"(did you mean {tmp_path / 'Meine Prüfung.toml'}?)" in said
    assert "did you mean" not in run_flexura("acquire", tmp_path / "rig.toml")[2]
    assert "did you mean" not in run_flexura("acquire", tmp_path / "none" / "Meine Prüfung.toml")[2]


def test_pictures_of_the_window_go_into_a_folder_and_not_into_a_file(run_flexura: Flexura, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "frf.h5").touch()
    status, _, said = run_flexura("view", folder, "--screenshot", tmp_path / "a.png")
    assert status == 2
    assert "a folder is wanted" in said
    assert not (tmp_path / "a.png").exists()
