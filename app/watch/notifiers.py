"""Ways to tell people: Apprise and commands of their own, each in a process that is ended if it hangs."""

import json
import os
import queue
import shlex
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from app.watch.apprise_process import FAILED, NOT_INSTALLED, UNKNOWN
from app.watch.news import News
from app.watch.secrets import TOKEN, SecretError
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
        self._turn = threading.Lock()
        self.delivered, self.failed = 0, 0
        self.last_failure = ""
        for notifier in notifiers:
            line: queue.Queue[News] = queue.Queue()
            self._lines.append(line)
            threading.Thread(target=self._work, args=(notifier, line), name=notifier.name, daemon=True).start()

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

    def _work(self, notifier: Notifier, line: "queue.Queue[News]") -> None:
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
