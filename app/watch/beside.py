"""Starts the watcher beside a campaign: a process of its own, of which nothing reaches the campaign.

It has no lock and no file of the campaign's, is in no group of processes that Ctrl-C reaches, and gives way where
both want the processor. Nothing of a campaign waits for it: what it says, its address or why there is none, then
what it could not tell, is passed on by a thread. It sees by the end of its input that the campaign's process is
gone, and stays until it has told how the campaign ended, or that it is silent.
"""

import json
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from drivers.own_process import module_command, own_surroundings

TOLD_WITHIN = 10.0
"""Seconds for which acquire waits at its end for whether that could be told; mail is refused in some five."""
MOST_LINES, LONGEST_LINE = 1000, 1000
"""Lines that are listened to before the address, and bytes of a line."""


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
        Told the page's address, or in one sentence why there is none; later what could not be told.

    Yields
    ------
    None
        At once, whatever becomes of the watcher. After a block that has not raised, there is a short wait for
        what it says of the last message: how the campaign ended.
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
    over, heard = threading.Event(), threading.Event()
    threading.Thread(target=_pass_on, args=(child, say, over, heard), name="what it says", daemon=True).start()
    try:
        yield
    finally:
        over.set()
        if child.stdin is not None:
            with suppress(OSError):
                child.stdin.close()
    if notify or commands:
        with suppress(KeyboardInterrupt):  # who wants to go need not know
            if not heard.wait(TOLD_WITHIN):
                say("whether the end of the campaign could be told is not known yet; the watcher goes on trying")


def _pass_on(
    child: "subprocess.Popen[bytes]", say: Callable[[str], None], over: threading.Event, heard: threading.Event
) -> None:
    """Pass on what the watcher says until it falls silent.

    Parameters
    ----------
    over : Event
        Set when the campaign has ended: before that, silence means that the watcher is gone.
    heard : Event
        Set at the end.
    """
    first: list[str] = []
    known = False
    try:
        for line in _lines(child):
            if known:
                say(line)
            elif len(first) < MOST_LINES:
                first.append(line)
                known = line == "}" and _address(first, say)
        if not known:
            told = [line for line in first if line]
            say(f"not watched: {told[-1] if told else 'the watcher ended without a word'}")
        elif not over.is_set():
            say("the watcher has ended; nothing more is told of this campaign")
    finally:
        heard.set()
    child.wait()


def _lines(child: "subprocess.Popen[bytes]") -> Iterator[str]:
    if child.stdout is not None:
        with suppress(OSError, ValueError), child.stdout as stream:
            while line := stream.readline(LONGEST_LINE):
                yield line.decode(errors="replace").strip()


def _address(lines: Sequence[str], say: Callable[[str], None]) -> bool:
    """Say the page's address, if that is what lines end with: JSON, after what libraries may have warned of."""
    if "{" not in lines:
        return False
    try:
        say(f"watched at {json.loads(''.join(lines[lines.index('{') :]))['url']}")
    except (ValueError, KeyError, TypeError):
        return False
    return True
