"""Commands in messages can be copied: a path in them is quoted where its name needs it."""

import ast
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from app.files.bad_file import quoted
from app.files.campaigns.loading import not_a_campaign
from app.files.results.run_folder import run_file

APP = Path(__file__).resolve().parents[2] / "app"
COMMAND = re.compile(r"flexura [a-z-]+[^;:(),]* $")
NO_PATHS = {"SPLINE", "file.samplerate", "skipped", "duration(now.silent_for)"}
"""Values of options, and numbers in sentences."""
QUOTED_ALREADY = {"campaign", "campaign_of(run)"}
"""What `app.summaries.briefing.briefing` gets: words of a command, quoted where they are put together."""
PLACEHOLDER = re.compile(r"flexura [a-z]+ (?:[^.;\n]* )?(?:CAMPAIGN|RUN|FOLDER)\b")
WORDS_OF_SYNTAX = {"declared_test.py", "uff_time.py", "new_declarations.py"}
"""Where a folder is meant that nothing knows yet."""


def _unquoted(source: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if not isinstance(node, ast.JoinedStr):
            continue
        before = ""
        for part in node.values:
            if isinstance(part, ast.Constant):
                before += str(part.value)
                continue
            assert isinstance(part, ast.FormattedValue)
            value = ast.unparse(part.value)
            typed = value.startswith("quoted(") or value in NO_PATHS | QUOTED_ALREADY
            if COMMAND.search(before) and not typed:
                yield f"line {node.lineno}: {value}"
            before += "PATH"


def test_every_command_in_a_message_quotes_its_paths() -> None:
    assert list(_unquoted('f"make it again: flexura compensate {run}"')) == ["line 1: run"]
    assert list(_unquoted('f"then: flexura gap {quoted(one)} --out {run}"')) == ["line 1: run"]
    found = {path.name: list(_unquoted(path.read_text(encoding="utf-8"))) for path in sorted(APP.rglob("*.py"))}
    assert {name: lines for name, lines in found.items() if lines} == {}


def _texts(source: str) -> Iterator[str]:
    """Yield what is no docstring."""
    tree = ast.parse(source)
    described = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        and node.body
        and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in described:
            yield node.value


def test_no_command_in_a_message_has_a_placeholder_for_a_folder_that_is_known() -> None:
    assert [*map(PLACEHOLDER.search, _texts('x = "to find it: flexura gap CAMPAIGN"'))] != [None]
    found = {
        path.name: [text for text in _texts(path.read_text(encoding="utf-8")) if PLACEHOLDER.search(text)]
        for path in sorted(APP.rglob("*.py"))
        if "commands" not in path.parts and path.name not in WORDS_OF_SYNTAX
    }
    assert {name: texts for name, texts in found.items() if texts} == {}


@pytest.mark.parametrize("name", ["plate", "Prüfung-2.0/run", "a b", "it's", "$HOME", "a;b", "", "x(1)", "~/é è"])
def test_a_quoted_path_is_one_word_of_a_shell(name: str) -> None:
    assert shlex.split(quoted(name)) == [name]


def test_a_path_that_needs_no_quotation_marks_has_none() -> None:
    assert quoted(Path("/data/Prüfstand_Ä-1.toml")) == "/data/Prüfstand_Ä-1.toml"


def test_a_run_folder_named_for_a_campaign_is_told_with_a_command_to_copy(tmp_path: Path) -> None:
    run = tmp_path / "run 1"
    run.mkdir()
    (run / "frf.h5").touch()
    assert f"flexura new plate '{run / 'frf.h5'}'" in str(not_a_campaign(run))
    with pytest.raises(Exception, match=r"make it with: flexura update"):
        run_file(run, "laws.h5", "focus")
