"""One check of a driver, and what came of it."""

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

CHECK_TIMEOUT = 120.0
"""A check that takes longer hangs, s of the computer's time."""


class Failed(AssertionError):  # noqa: N818 (the check says so of the driver)
    """The driver did not do what it has to."""


class NotChecked(Exception):  # noqa: N818 (nothing is wrong)
    """The driver, or its simulated counterpart, gives no way to check this."""


@dataclass(frozen=True)
class Check:
    """What a driver has to bear.

    Attributes
    ----------
    name : str
    why : str
        What would happen to a campaign otherwise.
    run : callable
        Raises `Failed` or `NotChecked`; whatever else it raises is the driver's.
    """

    name: str
    why: str
    run: Callable[[], None]


@dataclass(frozen=True)
class CheckVerdict:
    """What came of a check."""

    name: str
    why: str
    result: Literal["passed", "FAILED", "not checked"]
    said: str = ""


def verdicts(checks: Sequence[Check]) -> Iterator[CheckVerdict]:
    """Run checks one after the other; a driver that hangs ends them."""
    for n, check in enumerate(checks):
        verdict = _verdict(check)
        yield verdict
        if verdict.said.startswith("hangs"):
            for left in checks[n + 1 :]:
                yield CheckVerdict(left.name, left.why, "not checked", "a check before this one hangs")
            return


def _verdict(check: Check) -> CheckVerdict:
    raised: list[BaseException | None] = []

    def run() -> None:
        try:
            check.run()
        except BaseException as error:  # noqa: BLE001 (another's driver may raise anything)
            raised.append(error)
        else:
            raised.append(None)

    thread = threading.Thread(target=run, name=f"check {check.name}", daemon=True)
    thread.start()
    thread.join(CHECK_TIMEOUT)
    if not raised:
        return CheckVerdict(check.name, check.why, "FAILED", f"hangs: no end within {CHECK_TIMEOUT:g} s")
    error = raised[0]
    if error is None:
        return CheckVerdict(check.name, check.why, "passed")
    if isinstance(error, NotChecked):
        return CheckVerdict(check.name, check.why, "not checked", str(error))
    said = str(error) if isinstance(error, Failed) else f"{type(error).__name__}: {error}"
    return CheckVerdict(check.name, check.why, "FAILED", " ".join(said.split()))
