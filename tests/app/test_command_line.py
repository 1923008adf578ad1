"""The verbs beside each other: one word for one thing, quick help, quiet when asked, colour only on a screen."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import click
import pytest

import analysis
from app.commands.options import Existing
from app.main import VERBS, flexura

ROOT = Path(__file__).resolve().parents[2]
RESULTS = [verb for verb in VERBS if verb != "completion"]
"""Verbs with a result: the others write a shell's script and open a window."""
SHARED = ("--twin", "--effects", "--out", "--mains", "--quiet", "--json", "--help")
"""The order of the options that several verbs have, after their own."""
HEAVY = ("numpy", "scipy", "torch", "matplotlib", "h5py", "nidaqmx", "rich", "pydantic")
SCREENS = ("PySide6", "PyQt6", "PyQt5", "pyqtgraph", "tkinter")

Flexura = Callable[..., tuple[int, str, str]]


def verb_command(verb: str) -> click.Command:
    command = flexura.get_command(click.Context(flexura), verb)
    assert command is not None
    return command


def options_of(verb: str) -> dict[str, click.Option]:
    """Long name -> option, in the order of --help."""
    command = verb_command(verb)
    parameters = command.get_params(click.Context(command, help_option_names=["-h", "--help"]))
    return {max(p.opts, key=len): p for p in parameters if isinstance(p, click.Option)}


def loaded_by(code: str) -> set[str]:
    """Modules that another Python has loaded after `code`."""
    told = f"{code}\nprint('LOADED', *sys.modules)"
    done = subprocess.run([sys.executable, "-c", told], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(done.stdout.split("LOADED ")[1].split())


@pytest.mark.parametrize("verb", RESULTS)
def test_every_verb_can_be_quiet_and_speak_json(verb: str) -> None:
    assert {"--quiet", "--json", "--help"} <= set(options_of(verb))


@pytest.mark.parametrize("verb", RESULTS)
def test_shared_options_stand_last_and_in_one_order(verb: str) -> None:
    names = list(options_of(verb))
    shared = [name for name in SHARED if name in names]
    assert names[-len(shared) :] == shared


@pytest.mark.parametrize("name", ["--effects", "--mains", "--quiet", "--help"])
def test_one_option_is_explained_in_one_way(name: str) -> None:
    found = [options[name] for options in map(options_of, RESULTS) if name in options]
    assert len(found) > 1
    assert len({(option.help, str(option.default), repr(option.type)) for option in found}) == 1


@pytest.mark.parametrize("verb", VERBS)
def test_every_option_says_what_it_is_for(verb: str) -> None:
    assert [name for name, option in options_of(verb).items() if not option.help] == []


@pytest.mark.parametrize("verb", VERBS)
def test_the_list_of_verbs_cuts_no_sentence(verb: str) -> None:
    command = verb_command(verb)
    line = command.get_short_help_str(limit=80 - len("  simulate-daq  "))
    assert line.endswith("."), line
    assert not line.endswith("..."), line


@pytest.mark.parametrize("verb", VERBS)
def test_the_examples_of_help_can_be_typed(verb: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Existing, "convert", click.Path.convert)  # nor need the files be there
    command = verb_command(verb)
    lines = re.findall(r"^ *flexura (.*)$", f"{command.epilog or ''}\n{command.help}", re.MULTILINE)
    assert lines, f"flexura {verb} --help shows no example"
    for line in lines:
        name, *words = shlex.split(re.split(r" [|>]", line)[0])
        assert name == verb
        command.make_context(verb, words)  # raises for a word the verb does not take


def _numeric() -> Iterator[tuple[str, str, int]]:
    """Yield every option that takes numbers, and how many."""
    for verb in VERBS:
        for name, option in options_of(verb).items():
            if isinstance(option.type, click.types.FloatParamType | click.types.IntParamType):
                yield verb, name, option.nargs


@pytest.mark.parametrize(("verb", "option", "count"), list(_numeric()))
def test_a_decimal_comma_is_told_with_the_number_to_write(
    run_flexura: Flexura, verb: str, option: str, count: int
) -> None:
    status, _, said = run_flexura(verb, option, *["21,5"] * count)
    assert status == 2
    assert "Write 21.5, with a point" in said, said


def test_three_digits_behind_a_comma_may_be_thousands(run_flexura: Flexura) -> None:
    assert "Write 1.000 (or 1000, if that is meant)" in run_flexura("focus", "--sample-rate", "1,000")[2]
    assert "with a point" not in run_flexura("focus", "--temperature", "0,20,5")[2]
    assert "with a point" not in run_flexura("gap", "plate,1")[2]


@pytest.mark.parametrize(
    ("verb", "option", "count"), [case for case in _numeric() if case[:2] != ("new", "--plate")]
)
def test_nan_is_no_number(
    run_flexura: Flexura, verb: str, option: str, count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ranges let it through, for it is neither below nor above."""
    monkeypatch.setattr(Existing, "convert", click.Path.convert)
    words: list[str] = []
    for one in verb_command(verb).params:
        value = str(one.type.choices[0]) if isinstance(one.type, click.Choice) else str(tmp_path)
        if isinstance(one, click.Argument):
            words.append(value)
        elif one.required and option not in one.opts:
            words += [one.opts[0], "1" if isinstance(one.type, click.types.IntParamType) else value]
    status, _, said = run_flexura(verb, option, *["nan"] * count, *words)
    assert status == 2
    assert option in said, said


def test_the_version_is_that_of_the_code_that_runs(run_flexura: Flexura) -> None:
    """Not that of the installation's metadata, which an editable one keeps from the day it was made."""
    assert run_flexura("--version") == (0, f"flexura, version {analysis.__version__}\n", "")


def test_an_option_is_named_whose_file_is_not_there(run_flexura: Flexura) -> None:
    told = "Error: --twin nowhere.toml: does not exist; make it with: flexura gap\n"
    assert run_flexura("update", str(ROOT), "--twin", "nowhere.toml") == (2, "", told)


def test_help_waits_for_no_library() -> None:
    code = (
        "from app.main import VERBS, flexura\n"
        "for words in [[], *([verb] for verb in VERBS)]:\n"
        "    flexura.main([*words, '--help'], prog_name='flexura', standalone_mode=False)\n"
        "import sys"
    )
    assert loaded_by(code) & set(HEAVY) == set()


def test_no_verb_but_view_needs_a_screen() -> None:
    code = (
        "import pkgutil, sys, app, analysis, drivers, simulation\n"
        "from importlib import import_module\n"
        "for package in (analysis, app, drivers, simulation):\n"
        "    for module in pkgutil.walk_packages(package.__path__, package.__name__ + '.'):\n"
        "        if not module.name.startswith('app.view'):\n"
        "            import_module(module.name)"
    )
    loaded = loaded_by(code)  # the packages of app.view among them, which have to be looked into
    assert "app.report.page" in loaded
    assert loaded & set(SCREENS) == set()


def test_quiet_says_nothing_when_all_is_well(tiny: Any, tmp_path: Path, run_flexura: Flexura) -> None:
    folder = tiny.write(tmp_path / "tiny")
    assert run_flexura("import", folder, "--quiet") == (0, "", "")
    status, out, err = run_flexura("import", folder, "--quiet", "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["state"] == "unchanged"


def test_quiet_hides_no_fault(tmp_path: Path, run_flexura: Flexura) -> None:
    status, out, err = run_flexura("import", tmp_path / "absent", "--quiet")
    assert (status, out) == (2, "")
    assert "absent" in err


def test_a_note_is_told_however_quiet(tiny: Any, tmp_path: Path, run_flexura: Flexura) -> None:
    tiny.toml = tiny.toml.replace("NI-9234", "no such card")
    status, out, err = run_flexura("import", tiny.write(tmp_path / "tiny"), "--quiet")
    assert (status, out) == (0, "")
    assert err.startswith("note: module 'no such card' is unknown")


@pytest.mark.skipif(sys.platform == "win32", reason="needs a pseudo terminal")
@pytest.mark.parametrize(("no_color", "coloured"), [("", True), ("1", False)])
def test_colour_is_for_terminals_and_can_be_refused(no_color: str, coloured: bool) -> None:
    import pty

    main, terminal = pty.openpty()
    environment = os.environ | {"NO_COLOR": no_color, "TERM": "xterm"}
    command = [sys.executable, "-m", "flexura", "doctor"]
    with subprocess.Popen(command, cwd=ROOT, env=environment, stdout=terminal, stderr=subprocess.DEVNULL) as child:
        os.close(terminal)
        said = b""
        while True:
            try:
                piece = os.read(main, 4096)
            except OSError:  # Linux says so when the other side is closed
                break
            if not piece:
                break
            said += piece
        child.wait()
    os.close(main)
    assert b"disk" in said
    assert (b"\x1b[" in said) is coloured


def test_what_is_piped_has_no_colour(run_flexura: Flexura) -> None:
    _, out, err = run_flexura("doctor")
    assert "disk" in out
    assert "\x1b" not in out + err


@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        (("flexura", "co"), {"plain,compensate", "plain,completion"}),
        (("flexura", "update", "--t"), {"plain,--twin"}),
        (("flexura", "focus", "--method", "st"), {"plain,stif"}),
    ],
)
def test_tab_completes_verbs_options_and_choices(typed: tuple[str, ...], offered: set[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "flexura"],
        cwd=ROOT,
        env=os.environ
        | {
            "_FLEXURA_COMPLETE": "bash_complete",
            "COMP_WORDS": " ".join(typed),
            "COMP_CWORD": str(len(typed) - 1),
        },
        capture_output=True,
        text=True,
        check=True,
    )
    assert set(done.stdout.split()) == offered


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_prints_what_the_shell_can_read(shell: str, run_flexura: Flexura, tmp_path: Path) -> None:
    status, script, _ = run_flexura("completion", shell)
    assert status == 0
    assert f"_FLEXURA_COMPLETE={shell}_complete" in script
    if shutil.which(shell):
        (tmp_path / "script").write_text(script, encoding="utf-8")
        subprocess.run([shell, "-n", str(tmp_path / "script")], check=True)


def test_what_the_output_s_encoding_lacks_is_replaced(tmp_path: Path) -> None:
    """As where Windows redirects to a file: in cp1252, which has no sigma."""
    (tmp_path / "\u03c3").mkdir()
    done = subprocess.run(
        [sys.executable, "-m", "flexura", "doctor", "--out", tmp_path / "\u03c3"],
        cwd=ROOT,
        env=os.environ | {"PYTHONIOENCODING": "cp1252"},
        capture_output=True,
        check=True,
    )
    assert f"free at {tmp_path / '?'}," in done.stdout.decode("cp1252")


def test_a_mistyped_verb_names_the_nearest(run_flexura: Flexura) -> None:
    status, _, err = run_flexura("updat", "plate")
    assert status == 2
    assert "No such command 'updat'. Did you mean 'update'?" in err
    assert "Did you mean" not in run_flexura("xyzzy")[2]


def test_a_machine_that_sets_many_threads_slows_no_verb() -> None:
    """A cluster sets such numbers for all programs; matrices of ours are small, and two threads wait."""
    code = (
        "import sys, types, click\nfrom app.main import VERBS, main\n"
        "def threads():\n import numpy, scipy.linalg, threadpoolctl\n"
        " print('POOLS', [pool['num_threads'] for pool in threadpoolctl.threadpool_info()])\n"
        "sys.modules['app.commands.threads'] = types.SimpleNamespace(command=click.command()(threads))\n"
        "VERBS['threads'] = 'threads'\nmain(['threads'])"
    )
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "8", "OMP_NUM_THREADS": "8", "MKL_NUM_THREADS": "8"}
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=True)
    assert set(json.loads(done.stdout.split("POOLS ")[1])) == {1}


def test_a_file_whose_name_begins_like_an_option_is_told_with_how_to_name_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_flexura: Flexura
) -> None:
    (tmp_path / "-plate").mkdir()
    monkeypatch.chdir(tmp_path)
    status, _, err = run_flexura("status", "-plate")
    assert status == 2
    assert err.splitlines()[-1] == "Write ./-plate for what is called so here."
    status, _, err = run_flexura("status", "-other")
    assert "Write" not in err
