"""Ways to tell people: Apprise and commands of their own, each in a process that is ended if it hangs.

Secrets of the watcher: addresses of messages and the page's token, from the environment or a file of mode 600.

They are in no argument, where every user of the computer sees them, and in no folder of a campaign, which is
copied and passed on.
"""

import json
import os
import queue
import re
import secrets
import shlex
import shutil
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol
from urllib.parse import urlsplit

from app.files.bad_file import ResultFileError
from app.files.parsed_text import read_text
from app.watch.apprise_process import FAILED, NOT_INSTALLED, UNKNOWN
from app.watch.news import News
from drivers.own_process import module_command, own_surroundings

ATTEMPT_TIMEOUT = 30.0
"""Seconds that one attempt may take."""
ATTEMPT_DELAYS = (0.0, 30.0, 120.0)
"""Seconds before each attempt: a mail server that is busy, a network that is away for a moment."""
MOST_WAITING = 50
"""Messages that wait for one notifier; of more, the oldest are dropped."""
WRONG = {
    FAILED: "was not delivered",
    UNKNOWN: "Apprise knows no such address",
    NOT_INSTALLED: "Apprise is not installed: pip install 'flexura[notify]'",
}


class Notifier(Protocol):
    """Something that can tell a message."""

    @property
    def name(self) -> str:
        """What it is called where people read it: without secrets."""
        ...

    def tell(self, news: News) -> str:
        """Tell it; return what went wrong, empty for nothing."""
        ...


@dataclass(frozen=True)
class AppriseNotifier:
    """An address of Apprise.

    Attributes
    ----------
    url : str
        With secrets; never shown.
    number : int
        Its place on the command line, from 1.
    """

    url: str
    number: int

    @property
    def name(self) -> str:
        """Scheme and number: all else may be secret."""
        return f"{self.url.partition('://')[0]} (address {self.number})"

    def tell(self, news: News) -> str:
        """Tell it through Apprise."""
        return self._run({"title": news.title, "body": news.text})

    def check(self) -> str:
        """Return what is wrong with the address, empty for nothing; nothing is sent."""
        return self._run({})

    def _run(self, order: Mapping[str, str]) -> str:
        status = _run(
            module_command("app.watch.apprise_process"), json.dumps({"url": self.url, **order}), own_surroundings()
        )
        return (
            WRONG.get(status, f"ended with {status}") if isinstance(status, int) and status else str(status or "")
        )


@dataclass(frozen=True)
class CommandNotifier:
    """A command: the message on its standard input; title, kind and campaign in its environment.

    Attributes
    ----------
    command : tuple of str
        Program and arguments; no shell sees them.
    """

    command: tuple[str, ...]

    @property
    def name(self) -> str:
        """The program: arguments may be secret."""
        return self.command[0]

    def check(self) -> str:
        """Return what is wrong with the program, empty for nothing; it is not run."""
        program = self.command[0]
        if shutil.which(program) is not None:
            return ""
        there = Path(program) if os.sep in program or "/" in program else None  # others are looked for on the PATH
        if there is None or not there.exists():
            return "there is no such program; name one that is installed, or its whole path"
        if there.is_dir():
            return "is a folder; name a program in it"
        return f"is not executable; allow it with chmod +x {program}, or name the program that runs it before it"

    def tell(self, news: News) -> str:
        """Run it."""
        said = {"FLEXURA_TITLE": news.title, "FLEXURA_KIND": news.kind, "FLEXURA_CAMPAIGN": news.campaign}
        said |= {"FLEXURA_MESSAGE": news.text}
        inherited = {name: value for name, value in os.environ.items() if name != TOKEN}
        status = _run(self.command, f"{news.title}\n{news.text}\n", inherited | said)
        return f"ended with {status}" if isinstance(status, int) and status else str(status or "")


def command_of(text: str) -> CommandNotifier:
    """Take ``--notify-command`` apart: a JSON list, or words as a shell would split them, quotes and all.

    Raises
    ------
    SecretError
        If it is neither.
    """
    try:
        words = json.loads(text) if text.lstrip().startswith("[") else shlex.split(text, posix=os.name != "nt")
    except ValueError as error:
        raise SecretError(f"--notify-command {text!r}: {error}; allowed: a program and its arguments") from error
    good = isinstance(words, list) and words and all(isinstance(word, str) and "\0" not in word for word in words)
    if not good or not words[0]:
        raise SecretError(
            f"--notify-command {text!r}: allowed: a program and its arguments, or a JSON list of them"
        )
    return CommandNotifier(tuple(words))


def notifiers(
    notify: Sequence[str], notify_command: Sequence[str], campaigns: Iterable[Path]
) -> "list[AppriseNotifier | CommandNotifier]":
    """Return those of ``--notify`` and ``--notify-command``.

    Raises
    ------
    SecretError
        As from `addresses`; for an address that Apprise does not know, and a program that cannot be run.
    """
    commands = [command_of(text) for text in notify_command]
    apprise = [AppriseNotifier(url, place) for place, url in enumerate(addresses(notify, campaigns), 1)]
    for option, asked in (("--notify-command", commands), ("--notify", apprise)):
        for one in asked:
            if wrong := one.check():
                raise SecretError(f"{option}: {one.name}: {wrong}")
    return [*apprise, *commands]


class Messenger:
    """Tells messages through every notifier, each in a thread of its own: none waits for another.

    Parameters
    ----------
    notifiers : sequence of Notifier
    complain : callable
        Told, once for each message, what could not be delivered.
    attempts : sequence of float
        Seconds before each attempt.
    """

    def __init__(
        self,
        notifiers: Sequence[Notifier],
        complain: Callable[[str], None],
        attempts: Sequence[float] = ATTEMPT_DELAYS,
    ) -> None:
        self._complain, self._attempts = complain, attempts
        self._ended = threading.Event()
        self._lines: list[queue.Queue[News]] = []
        self._failing: dict[int, tuple[str, str, str]] = {}
        self._turn = threading.Lock()
        self.delivered, self.failed = 0, 0
        self.last_failure = ""
        for number, notifier in enumerate(notifiers):
            self._lines.append(queue.Queue())
            threading.Thread(target=self._work, args=(number, notifier), name=notifier.name, daemon=True).start()

    def tell(self, news: News) -> None:
        """Tell a message, soon."""
        for line in self._lines:
            while line.qsize() >= MOST_WAITING:
                try:
                    line.get_nowait()
                    line.task_done()
                except queue.Empty:
                    break
            line.put(news)

    def wait(self, seconds: float) -> None:
        """Wait until everything is told, but no longer than this."""
        until = time.monotonic() + seconds
        while any(line.unfinished_tasks for line in self._lines) and time.monotonic() < until:
            time.sleep(0.05)

    def end(self) -> None:
        """Make no further attempts."""
        self._ended.set()

    def untold(self) -> list[str] | None:
        """Say which messages are to be tried again; None while one has still to be tried for the first time."""
        with self._turn:
            waiting = {number: line.unfinished_tasks for number, line in enumerate(self._lines)}
            failing = {number: self._failing.get(number) for number, count in waiting.items() if count}
        said = []
        for number, one in failing.items():
            if one is None:
                return None
            kind, name, wrong = one
            what = f"a message ({kind}) is" if waiting[number] == 1 else f"{waiting[number]} messages are"
            said.append(f"{what} not told yet by {name}: {wrong}; tried again for three minutes at most")
        return said

    def _work(self, number: int, notifier: Notifier) -> None:
        line = self._lines[number]
        while True:
            news = line.get()
            wrong = ""
            for wait in self._attempts:
                if self._ended.wait(wait):
                    break
                try:
                    wrong = notifier.tell(news)
                except Exception as error:  # noqa: BLE001 (whatever it is, the next message is told)
                    wrong = f"{type(error).__name__}"
                if not wrong:
                    break
                with self._turn:
                    self._failing[number] = news.kind, notifier.name, wrong
            with self._turn:
                self._failing.pop(number, None)
                if wrong:
                    self.failed += 1
                    self.last_failure = f"{notifier.name}: {wrong}"
                else:
                    self.delivered += 1
            if wrong:
                self._complain(f"a message ({news.kind}) could not be told by {notifier.name}: {wrong}")
            line.task_done()


def _run(command: Sequence[str], said: str, environment: Mapping[str, str]) -> int | str:
    """Run a command to its end or to its time; return its exit status, or what went wrong."""
    try:
        child = subprocess.Popen(  # noqa: S603 (a list of arguments that the user gave, or a module of ours)
            list(command),
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=dict(environment),
            start_new_session=sys.platform != "win32",
        )
    except (OSError, ValueError) as error:
        return f"cannot be started: {getattr(error, 'strerror', None) or error}"
    try:
        child.communicate(said.encode(), ATTEMPT_TIMEOUT)
    except subprocess.TimeoutExpired:
        _kill(child)
        return f"took longer than {ATTEMPT_TIMEOUT:g} s and was ended"
    return child.returncode


def _kill(child: "subprocess.Popen[bytes]") -> None:
    """End a process, and those that it started."""
    if sys.platform == "win32":
        child.kill()
    else:
        import signal

        with suppress(ProcessLookupError):  # it ended just now
            os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    if child.stdin is not None:
        child.stdin.close()


VARIABLE = re.compile(r"\$(?:\{(\w+)\}|(\w+))")
TOKEN = "FLEXURA_WATCH_TOKEN"  # noqa: S105 (the name of a variable)
SHORTEST_TOKEN = 16
"""Characters of a token: nobody guesses it at some thousand attempts per second."""
MOST_ADDRESSES = 20
"""Addresses."""


class SecretError(ResultFileError):
    """A secret is missing, or lies where others can read it."""


def addresses(
    given: Sequence[str], folders: Iterable[Path], environment: Mapping[str, str] = os.environ
) -> list[str]:
    """Return the addresses that messages go to.

    Parameters
    ----------
    given : sequence of str
        Of ``--notify``: ``@FILE`` with one address a line, or an address in which ``$NAME`` or ``${NAME}`` stand
        for variables of the environment.
    folders : iterable of Path
        Campaigns, in which no secret may lie.

    Raises
    ------
    SecretError
        For a file or variable that is missing, a file that others can read or that lies in a campaign, and a
        password in the argument itself.
    """
    found: list[str] = []
    folders = list(folders)
    for one in given:
        if one.startswith("@"):
            lines = _private(Path(one[1:]).expanduser(), "--notify", folders).splitlines()
            inside = [line.strip() for line in lines if line.strip() and not line.lstrip().startswith("#")]
            if not inside:
                raise SecretError(f"--notify {one}: no address in it, nobody would be told; allowed: one a line")
            found += inside
        else:
            _require_no_password(one)
            found.append(VARIABLE.sub(lambda name: _variable(name, environment), one))
    wrong = next((number for number, one in enumerate(found, 1) if "://" not in one), None)
    if wrong is not None:
        raise SecretError(
            f"--notify: address {wrong} has no scheme; allowed: an address of Apprise, as ntfy://TOPIC"
        )
    if len(found) > MOST_ADDRESSES:
        raise SecretError(f"--notify: {len(found)} addresses; allowed: at most {MOST_ADDRESSES}")
    return found


def page_token(
    file: Path | None, folders: Iterable[Path], environment: Mapping[str, str] = os.environ
) -> str | None:
    """Return the token of the page: that of a file, which is made where it is missing, or of the environment.

    Parameters
    ----------
    file : Path or None
        Of ``--token-file``.
    folders : iterable of Path
        Campaigns, in which it may not lie.
    environment : mapping
        ``FLEXURA_WATCH_TOKEN`` counts where there is no file.

    Returns
    -------
    str or None
        None where there is neither.

    Raises
    ------
    SecretError
        For a file that others can read or that cannot be written, and a token that is too short or cannot be
        typed.
    """
    token = environment.get(TOKEN)
    where = TOKEN
    if file is not None:
        where = f"--token-file {file}"
        if not file.exists():
            _require_outside(file, "--token-file", list(folders))
            _write_new(file, secrets.token_urlsafe(24) + "\n")
        token = _private(file, "--token-file", list(folders)).strip()
    if token is not None and (
        len(token) < SHORTEST_TOKEN or not token.isascii() or not token.isprintable() or " " in token
    ):
        raise SecretError(
            f"{where}: {len(token)} characters; allowed: {SHORTEST_TOKEN} or more letters, digits and "
            "signs, no spaces"
        )
    return token


def _variable(name: re.Match[str], environment: Mapping[str, str]) -> str:
    word = name.group(1) or name.group(2)
    if word not in environment:
        raise SecretError(f"--notify: the environment has no variable {word}; set it before flexura is started")
    return environment[word]


def _require_no_password(address: str) -> None:
    try:
        password = urlsplit(address).password
    except ValueError:  # what Apprise reads need not be a URL by the book
        return
    if password and not VARIABLE.fullmatch(password):
        raise SecretError(
            "--notify: a password in an argument is seen by every user of this computer; write $NAME for it, a "
            "variable of the environment, or the address into a file of mode 600, --notify @FILE"
        )


def _private(file: Path, option: str, folders: Sequence[Path]) -> str:
    """Read a file that only its owner can read."""
    _require_outside(file, option, folders)
    try:
        mode = stat.S_IMODE(file.stat().st_mode)
        if sys.platform != "win32" and mode & 0o077:
            raise SecretError(
                f"{option} {file}: mode {mode:o}, others can read it; allowed: 600 (chmod 600 {file})"
            )
        return read_text(file)
    except (OSError, UnicodeDecodeError) as error:
        raise SecretError(f"{option} {file}: cannot be read: {error}") from error
    except ResultFileError:
        raise
    except ValueError as error:
        raise SecretError(f"{option} {file}: {error}") from error


def _require_outside(file: Path, option: str, folders: Sequence[Path]) -> None:
    inside = next((folder for folder in folders if file.resolve().is_relative_to(folder.resolve())), None)
    if inside is not None:
        raise SecretError(
            f"{option} {file}: lies in the campaign {inside}, which is copied and passed on; move it"
        )


def _write_new(file: Path, text: str) -> None:
    try:
        handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w", encoding="utf-8") as opened:
            opened.write(text)
    except OSError as error:
        raise SecretError(f"--token-file {file}: cannot be written: {error.strerror}") from error
