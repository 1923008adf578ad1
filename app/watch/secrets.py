"""Secrets of the watcher: addresses of messages and the page's token, from the environment or a file of mode 600.

They are in no argument, where every user of the computer sees them, and in no folder of a campaign, which is
copied and passed on.
"""

import os
import re
import secrets
import stat
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from urllib.parse import urlsplit

from app.files.bad_file import ResultFileError
from app.files.parsed_text import read_text

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
            found += [line.strip() for line in lines if line.strip() and not line.lstrip().startswith("#")]
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
