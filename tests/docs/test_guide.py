"""The guide tells what is true: its commands run, its links lead somewhere, its messages are the program's."""

import ast
import json
import os
import re
import runpy
import shlex
import shutil
import stat
import subprocess
import sys
import tomllib
from pathlib import Path

import click
import pytest

from analysis.declaration.plate import Plate
from analysis.declaration.transducers import Drive, Patch, Sensor
from analysis.experiment import check_patches
from app.commands.options import Existing
from app.files.campaigns.channels import read_experiment
from app.main import flexura
from simulation.effects.library import LIBRARY

ROOT = Path(__file__).resolve().parents[2]
TODAY = [page for page in sorted((ROOT / "docs").rglob("*.md")) if page.parent.name != "history"]
PAGES = [ROOT / "README.md", *TODAY]
BASH = shutil.which("bash")
GUIDE = ROOT / "docs" / "guide"
STARTS = r"(?:flexura|python3 start\.py)"
NO_VERBS = ("tests", "docs", "VERB", "--help")
"""Words that start.py does not hand on to flexura, and what stands for a verb."""
FENCED = re.compile(r"(<!-- not run: [^\n]*-->\n)?```sh\n(.*?)```(?:\n\n((?: {4}[^\n]*\n)+))?", re.DOTALL)
"""Remark, commands, and what they print, right below and indented; three dots stand for what differs each time."""
LONG = {
    "any-plate.md",
    "closing-a-gap.md",
    "five-minutes.md",
    "filters.md",
    "frfs-of-other-programs.md",
    "hammer-test.md",
    "health.md",
    "listening.md",
    "modal-test.md",
    "real-hardware.md",
    "recorded-campaign.md",
}
"""Pages whose commands take more than a quarter of a minute."""


def name(page: Path) -> str:
    return str(page.relative_to(ROOT))


def typed(line: str) -> list[str]:
    """Words of a command as flexura gets them: without what starts it, what follows a pipe, and remarks."""
    words = shlex.split(re.split(r" (?:[|>]|>>) | {4,}", line)[0], comments=True)
    return words[2:] if words[0] == "python3" else words[1:]


def command_lines(page: Path) -> list[list[str]]:
    """Every flexura command of a page, in fences and in indented blocks."""
    text = page.read_text(encoding="utf-8")
    return [typed(line) for line in re.findall(rf"^(?: {{4}})?({STARTS} .*)$", text, re.MULTILINE)]


def mentioned(page: Path) -> list[list[str]]:
    """Those in a sentence or a table, which may leave out what does not matter there."""
    return [typed(line) for line in re.findall(rf"`({STARTS} [^`\n]*)`", page.read_text(encoding="utf-8"))]


def parse(words: list[str]) -> None:
    """Raise click's own refusal of a verb, option or value that flexura does not have; files need not be there."""
    command = flexura.get_command(click.Context(flexura), words[0])
    if command is None:
        raise click.UsageError(f"{words[0]} is no verb")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Existing, "convert", click.Path.convert)
        command.make_context(words[0], words[1:])


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_command_can_be_typed(page: Path) -> None:
    for words in command_lines(page):
        if words[0] not in NO_VERBS:
            parse(words)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_command_mentioned_exists(page: Path) -> None:
    for words in mentioned(page):
        if words[0] not in NO_VERBS and "SHELL" not in words:
            try:
                parse([word.strip("[]") for word in words])
            except click.MissingParameter:
                continue


def anchors(page: Path) -> set[str]:
    """Fragments that a code host gives to the headings of a page."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_link_leads_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)]+)\)", page.read_text(encoding="utf-8")):
        if "://" in link:
            continue
        target, _, fragment = link.partition("#")
        there = (page.parent / target).resolve() if target else page
        assert there.exists(), f"{name(page)}: {link}"
        assert not fragment or fragment in anchors(there), f"{name(page)}: {link}"


def test_every_picture_is_shown_and_made_by_the_command_for_it() -> None:
    made = runpy.run_path(str(ROOT / "docs" / "make_images.py"))["MADE"]
    shown = {
        Path(link).stem
        for page in PAGES
        for link in re.findall(r"!\[[^]]*\]\(([^)]+\.png)\)", page.read_text(encoding="utf-8"))
        if Path(link).parent.name == "images"  # those of docs/verification.md have their own folder and command
    }
    images = {path.stem for path in (ROOT / "docs" / "images").iterdir() if path.is_file()}
    assert images == shown == made


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    for page in [*GUIDE.glob("*.md"), *(ROOT / "docs").glob("*.md")]:
        assert page.name == "README.md" or f"{page.name})" in index, page.name


def test_the_plate_of_any_shape_is_one() -> None:
    page = (GUIDE / "file-formats.md").read_text(encoding="utf-8")
    example, transducers, *_ = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    declared = json.loads(json.dumps(tomllib.loads(example)))
    plate = Plate.model_validate(declared["plate"])
    check_patches(plate, [Patch.model_validate(patch) for patch in declared["patch"]])
    assert len(plate.supported_edges()) == 2
    others = json.loads(json.dumps(tomllib.loads(transducers)))
    sensors = [Sensor.model_validate(sensor) for sensor in others["sensor"]]
    for transducer in (*(Drive.model_validate(drive) for drive in others["drive"]), *sensors):
        transducer.check(plate)
    assert 10 < len(sensors[1].channels(plate)) < 30


def sentences() -> str:
    """Every string of the program; values filled in later stand as an ellipsis."""
    found = []
    for file in (
        f
        for floor in ("analysis", "app", "drivers", "flexura", "simulation")
        for f in (ROOT / floor).rglob("*.py")
    ):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.append(node.value)
            elif isinstance(node, ast.JoinedStr):
                found.append("".join(p.value if isinstance(p, ast.Constant) else "…" for p in node.values))
    starter = (ROOT / "start.py").read_text(encoding="utf-8")
    return "\n".join([*found, re.sub(r"\{[^{}]*(\{[^{}]*\})?[^{}]*\}", "…", starter)])


def test_the_messages_in_troubleshooting_are_those_of_the_program() -> None:
    page = (GUIDE / "troubleshooting.md").read_text(encoding="utf-8")
    said = sentences()
    messages: list[str] = re.findall(r"^\| `([^`]+)` \|", page, re.MULTILINE)
    assert len(messages) > 40
    for message in messages:
        for piece in re.split(r" ?… ?", message):
            assert piece.strip() in said, f"no message says: {piece}"


def test_the_library_is_listed_as_it_is() -> None:
    experiment = read_experiment(ROOT / "examples" / "pp-plate")
    page = (ROOT / "docs" / "gap.md").read_text(encoding="utf-8")
    section = page.partition("## The effects of the library")[2].partition("\n## ")[0]
    listed = re.findall(r"^\| `(\w+)` \| (.*?) \| (.*?) \|$", section, re.MULTILINE)
    cards = [effect.card(experiment) for effect in LIBRARY.values()]
    assert [(name, summary) for name, summary, _ in listed] == [(card.name, card.summary) for card in cards]
    assert [re.findall(r"`(\w+)`", parameters) for *_, parameters in listed] == [
        [parameter.name for parameter in card.parameters] for card in cards
    ]


@pytest.fixture
def laboratory(tmp_path: Path) -> dict[str, str]:
    """Make a folder as a reader has it, with the examples in it and flexura on the path; the environment."""
    scripts = tmp_path / "scripts"
    scripts.mkdir()
    for program, options in (("flexura", "-P -m flexura"), ("python", "")):
        script = scripts / program
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" {options} "$@"\n', encoding="utf-8")
        script.chmod(script.stat().st_mode | stat.S_IXUSR)
    (tmp_path / "desk").mkdir()
    (tmp_path / "desk" / "examples").symlink_to(ROOT / "examples", target_is_directory=True)
    path = os.pathsep.join([str(scripts), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}


def pages_to_run() -> list[object]:
    runnable = [
        page
        for page in sorted(GUIDE.glob("*.md"))
        if any(not no for no, *_ in FENCED.findall(page.read_text(encoding="utf-8")))
    ]
    return [
        pytest.param(page, marks=[pytest.mark.slow] if page.name in LONG else [], id=page.name)
        for page in runnable
    ]


@pytest.mark.skipif(BASH is None, reason="the guide's commands are those of a POSIX shell, and there is no bash")
@pytest.mark.parametrize("page", pages_to_run())
def test_the_commands_of_a_page_run_from_top_to_bottom(
    page: Path, laboratory: dict[str, str], tmp_path: Path
) -> None:
    for not_run, block, shown in FENCED.findall(page.read_text(encoding="utf-8")):
        if not_run:
            continue
        assert BASH is not None
        done = subprocess.run(
            [BASH, "-euo", "pipefail", "-c", block],
            cwd=tmp_path / "desk",
            env=laboratory,
            capture_output=True,
            text=True,
            check=False,
        )
        printed = f"{done.stdout}\n{done.stderr}".replace("\xa0", " ")  # a value stays beside its unit
        assert done.returncode == 0, f"{block}\n{printed}"
        for line in map(str.strip, shown.splitlines()):
            assert re.search(".*".join(map(re.escape, line.split("..."))), printed), f"{line}\n{printed}"
