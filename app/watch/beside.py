"""Starts the watcher beside a campaign: a process of its own, of which nothing reaches the campaign.

It has no lock and no file of the campaign's, is in no group of processes that Ctrl-C reaches, and gives way where
both want the processor. Nobody waits for it: what it says first, its address or why there is none, is passed on by
a thread. It sees by the end of its input that the campaign's process is gone, and stays until it has told how the
campaign ended, or that it is silent.
"""

import json
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from drivers.own_process import module_command, own_surroundings


@contextmanager
def watched_beside(
    folder: Path, notify: Sequence[str], commands: Sequence[str], say: Callable[[str], None]
) -> Iterator[None]:
    """Start the watcher; it learns from the end of the block, as from that of this process, that nobody records.

    Parameters
    ----------
    folder : Path
        Of the campaign, which need not be there yet.
    notify, commands : sequence of str
        As ``--notify`` and ``--notify-command`` have them, without secrets.
    say : callable
        Told the page's address, or in one sentence why there is none.

    Yields
    ------
    None
        At once, whatever becomes of the watcher.
    """
    arguments = ["watch", str(folder), "--wait", "--beside", "--json", "--quiet"]
    for option, values in (("--notify", notify), ("--notify-command", commands)):
        for value in values:
            arguments += [option, value]
    try:
        child = subprocess.Popen(  # noqa: S603 (a module of ours)
            module_command("flexura", *arguments),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env=own_surroundings(),
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            start_new_session=sys.platform != "win32",
        )
    except OSError as error:
        say(f"not watched: {error.strerror}")
        yield
        return
    threading.Thread(target=_pass_on, args=(child, say), name="the watcher's address", daemon=True).start()
    try:
        yield
    finally:
        if child.stdin is not None:
            with suppress(OSError):
                child.stdin.close()


def _pass_on(child: "subprocess.Popen[bytes]", say: Callable[[str], None]) -> None:
    """Pass on what the watcher says before it falls silent."""
    if child.stdout is None:
        return
    try:
        said = child.stdout.read(100_000).decode(errors="replace").strip()
        child.stdout.close()
    except (OSError, ValueError):
        return
    try:
        say(f"watched at {json.loads(said)['url']}")
    except (ValueError, KeyError, TypeError):
        say(f"not watched: {said.splitlines()[-1] if said else 'the watcher ended without a word'}")
    child.wait()
