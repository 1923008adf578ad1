"""Kinds of ours and of other packages, the broken among them."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from drivers.kinds import KindError
from drivers.ni.cards import CARDS
from drivers.ovens.settings import OVENS, OvenSettings
from drivers.thermometers.thermometer import THERMOMETERS

Install = Callable[..., None]

GOOD = "from drivers.ovens.settings import OvenSettings\nclass Settings(OvenSettings): pass\n"


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Install:
    """Return a function that puts a package with one kind of oven on the path, as pip would."""
    monkeypatch.syspath_prepend(tmp_path)

    def put(package: str, kind: str, code: str = GOOD, points: str | None = None) -> None:
        module = package.replace("-", "_")
        (tmp_path / f"{module}.py").write_text(code, encoding="utf-8")
        info = tmp_path / f"{module}-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n", encoding="utf-8")
        listed = f"[flexura.ovens]\n{kind} = {module}:Settings\n" if points is None else points
        (info / "entry_points.txt").write_text(listed, encoding="utf-8")
        monkeypatch.delitem(sys.modules, module, raising=False)

    return put


def test_our_own_need_no_installation() -> None:
    for kinds in (OVENS, CARDS, THERMOMETERS):
        for name, brought in kinds.all().items():
            if brought[0].package == "flexura":
                kinds.find(name)
    assert {"watlow-f4t", "eurotherm-2400"} <= set(OVENS.all())


def test_a_package_brings_a_kind(install: Install) -> None:
    install("their-oven", "theirs")
    assert issubclass(OVENS.find("theirs"), OvenSettings)
    assert OVENS.all()["theirs"][0].package == "their-oven"


def test_an_unknown_kind_is_told_with_those_there_are_and_who_would_bring_it() -> None:
    with pytest.raises(KindError) as caught:
        OVENS.find("watlow-f4")
    assert caught.value.seen == "'watlow-f4'"
    assert "'espec-p300'" in caught.value.allowed
    assert "did you mean watlow-f4t?" in caught.value.remedy
    assert "entry point of flexura.ovens" in caught.value.remedy


@pytest.mark.parametrize(
    ("code", "told"),
    [
        ("raise RuntimeError('no licence\\nfound')", "RuntimeError: no licence found"),
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("def broken(:", "SyntaxError"),
        ("import no_such_vendor", "No module named 'no_such_vendor'"),
        ("Other = 1", "AttributeError"),
        ("Settings = 1", "is 1"),
        ("class Settings: pass", "their_oven.Settings"),
    ],
)
def test_a_broken_one_is_one_sentence_and_hurts_nobody_else(install: Install, code: str, told: str) -> None:
    install("their-oven", "theirs", code)
    OVENS.find("watlow-f4t")
    with pytest.raises(KindError) as caught:
        OVENS.find("theirs")
    assert told in str(caught.value)
    assert "\n" not in str(caught.value)
    assert "their-oven" in caught.value.remedy


@pytest.mark.parametrize("points", ["[flexura.ovens]\nno equality sign", "[flexura.ovens]\n = x:y", "\x00[["])
def test_damaged_metadata_hurt_nobody(install: Install, points: str) -> None:
    install("good-oven", "good")
    install("their-oven", "theirs", points=points)
    OVENS.find("watlow-f4t")
    OVENS.find("good")
    with pytest.raises(KindError):
        OVENS.find("theirs")


def test_no_package_takes_a_name_of_ours(install: Install) -> None:
    install("their-oven", "watlow-f4t", "raise RuntimeError")
    assert OVENS.find("watlow-f4t").__module__ == "drivers.ovens.controllers"


def test_two_packages_of_one_kind_are_told(install: Install) -> None:
    install("their-oven", "theirs")
    install("other-oven", "theirs")
    with pytest.raises(KindError, match="their-oven"):
        OVENS.find("theirs")
    with pytest.raises(KindError, match="other-oven"):
        OVENS.find("theirs")
