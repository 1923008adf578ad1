"""Output that nobody takes: a closed pipe, a lost terminal, a full disk behind a log, a closed stream."""

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
posix = pytest.mark.skipif(sys.platform == "win32", reason="terminals and pipes as POSIX has them")

SPEAKS = """
import signal, sys
import app.main
import click

@click.command()
def command():
    click.echo("a result " * 2000)
    click.echo("a note", err=True)
    from app.terminal.campaign import campaign_screen
    from app.terminal.progress import progress
    with progress() as report:
        for n in range(200):
            report("stage", n / 200)
    from pathlib import Path
    from app.terminal.streams import keep_unseen
    Path("worked").touch()
    click.echo("NOT AT REST", err=True)
    keep_unseen(Path("ending.txt"), "NOT AT REST: the oven")
    raise click.exceptions.Exit(int(sys.argv[1]))

signal.signal(signal.SIGHUP, signal.SIG_IGN)
app.main.flexura.add_command(command, "speak")
app.main.Verbs.get_command = lambda self, ctx, name: command
app.main.main(["speak"])
"""


def speak(
    folder: Path, status: int, stdout: int | None, stderr: int | None, closed: str = "", unbuffered: str = ""
) -> int:
    """Run a verb that prints, draws a bar and ends with `status`; return its exit status."""
    command = [sys.executable, "-c", SPEAKS, str(status)]
    if closed:
        command = ["/bin/sh", "-c", f'exec "$@" {closed}', "sh", *command]
    surroundings = os.environ | {"PYTHONPATH": str(ROOT), "TERM": "xterm", "PYTHONUNBUFFERED": unbuffered}
    done = subprocess.run(
        command, cwd=folder, env=surroundings, stdout=stdout, stderr=stderr, timeout=60, check=False
    )
    assert (folder / "worked").exists()
    return done.returncode


def _closed_pipe() -> int:
    reader, writer = os.pipe()
    os.close(reader)
    return writer


def _lost_terminal() -> int:
    main, terminal = os.openpty()
    os.close(main)
    return terminal


def _full() -> int:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    return os.open("/dev/full", os.O_WRONLY)


LOST: dict[str, Callable[[], int]] = {"closed pipe": _closed_pipe, "lost terminal": _lost_terminal, "full": _full}


@posix
@pytest.mark.parametrize("way", LOST)
@pytest.mark.parametrize("status", [0, 3])
def test_both_streams_lost(way: str, status: int, tmp_path: Path) -> None:
    """As where ``2>&1 | tee`` is ended by the Ctrl-C that ends the campaign, or its terminal was closed."""
    handle = LOST[way]()
    try:
        found = speak(tmp_path, status, handle, handle)
    finally:
        os.close(handle)
    assert found == (1 if (way, status) == ("full", 0) else status)  # its result is not where it was sent to
    assert (tmp_path / "ending.txt").read_text() == "NOT AT REST: the oven\n"


@posix
@pytest.mark.parametrize("way", LOST)
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_the_result_lost_alone(way: str, unbuffered: str, tmp_path: Path) -> None:
    handle = LOST[way]()
    (tmp_path / "ending.txt").write_text("of an earlier run")
    with (tmp_path / "log").open("w") as log:
        assert speak(tmp_path, 3, handle, log.fileno(), unbuffered=unbuffered) == 3
    os.close(handle)
    said = (tmp_path / "log").read_text()
    assert "NOT AT REST" in said
    assert "Traceback" not in said
    assert "Exception ignored" not in said
    assert not (tmp_path / "ending.txt").exists()


@posix
@pytest.mark.parametrize("closed", [">&-", "2>&-", ">&- 2>&-"])
def test_streams_that_were_closed_at_the_start(closed: str, tmp_path: Path) -> None:
    assert speak(tmp_path, 3, subprocess.DEVNULL, subprocess.DEVNULL, closed) == 3
    assert (tmp_path / "ending.txt").exists() == ("2>&-" in closed)


@posix
def test_a_result_that_a_full_disk_does_not_take_is_not_well(tmp_path: Path) -> None:
    handle = _full()
    with (tmp_path / "log").open("w") as log:
        assert speak(tmp_path, 0, handle, log.fileno()) == 1
    os.close(handle)
    assert "the result could not be printed (No space left on device)" in (tmp_path / "log").read_text()
