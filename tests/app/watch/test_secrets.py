"""Secrets come from the environment or from files that only their owner reads."""

import os
import sys
from pathlib import Path

import pytest

from app.watch.notifiers import TOKEN, SecretError, addresses, page_token

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no modes")


def private(file: Path, text: str, mode: int = 0o600) -> Path:
    file.write_text(text, encoding="utf-8")
    file.chmod(mode)
    return file


def test_addresses_from_variables_and_files(tmp_path: Path) -> None:
    file = private(tmp_path / "to.txt", "# mine\nslack://A/B/C\n\n mailto://me:word@example.org \n")
    given = ["ntfy://$TOPIC", "tgram://${BOT}/${CHAT}", f"@{file}", "mailto://me:$WORD@example.org"]
    environment = {"TOPIC": "t", "BOT": "b", "CHAT": "c", "WORD": "w"}
    assert addresses(given, [], environment) == [
        "ntfy://t",
        "tgram://b/c",
        "slack://A/B/C",
        "mailto://me:word@example.org",
        "mailto://me:w@example.org",
    ]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("ntfy://$NOWHERE", "no variable NOWHERE"),
        ("mailto://me:word@example.org", "seen by every user"),
        ("@none.txt", "cannot be read"),
        ("just words", "has no scheme"),
    ],
)
def test_what_cannot_be_used_is_refused_in_a_sentence(given: str, words: str) -> None:
    with pytest.raises(SecretError, match=words) as found:
        addresses([given], [], {})
    assert "word@" not in str(found.value)


@POSIX
@pytest.mark.parametrize("text", ["", "# the team's address comes here\n\n"])
def test_a_file_without_an_address_is_refused(tmp_path: Path, text: str) -> None:
    """A campaign of a night ran, and nobody was told."""
    with pytest.raises(SecretError, match="no address in it, nobody would be told"):
        addresses([f"@{private(tmp_path / 'to.txt', text)}"], [], {})


@POSIX
def test_a_file_that_others_can_read_is_refused(tmp_path: Path) -> None:
    file = private(tmp_path / "to.txt", "ntfy://t\n", 0o640)
    with pytest.raises(SecretError, match=r"mode 640.*chmod 600"):
        addresses([f"@{file}"], [], {})
    with pytest.raises(SecretError, match="mode 644"):
        page_token(private(tmp_path / "token", "x" * 30, 0o644), [], {})


def test_secrets_never_lie_in_a_campaign(tmp_path: Path) -> None:
    campaign = tmp_path / "campaign"
    campaign.mkdir()
    inside = private(campaign / "to.txt", "ntfy://t\n")
    (tmp_path / "link").symlink_to(campaign)
    for file in (inside, tmp_path / "link" / "to.txt"):
        with pytest.raises(SecretError, match="lies in the campaign"):
            addresses([f"@{file}"], [campaign], {})
    with pytest.raises(SecretError, match="lies in the campaign"):
        page_token(campaign / "new", [campaign], {})
    assert not (campaign / "new").exists()


def test_a_token_is_made_once_for_its_owner_only(tmp_path: Path) -> None:
    file = tmp_path / "token"
    token = page_token(file, [], {})
    assert token is not None
    assert len(token) >= 30
    assert page_token(file, [], {}) == token
    if os.name != "nt":
        assert file.stat().st_mode & 0o777 == 0o600


def test_a_token_of_the_environment_and_one_that_is_too_short() -> None:
    assert page_token(None, [], {}) is None
    assert page_token(None, [], {TOKEN: "0123456789abcdef"}) == "0123456789abcdef"
    for bad in ("short", "0123456789 abcdef", "é" * 20):
        with pytest.raises(SecretError, match="allowed: 16 or more") as found:
            page_token(None, [], {TOKEN: bad})
        assert bad not in str(found.value)
