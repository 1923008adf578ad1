"""``flexura acquire`` of an experiment with ``kind = "hammer"``."""

import time
import traceback
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.output import Output
from app.files.bad_file import quoted

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from app.files.declarations.experiment import RigKind
    from app.files.declarations.hammer_experiment import HammerExperiment
    from app.stages.acquire_hammer import HammerOutcome
    from app.terminal.campaign import Ending


def acquire_hits(
    file: Path,
    rig: "RigKind | None",
    out: Path | None,
    output: Output,
    *,
    again: bool,
    test_shot: bool,
    beside: "Callable[[Path], AbstractContextManager[None]]",
) -> None:
    """Record a hammer test, or take it up where it was interrupted.

    Parameters
    ----------
    test_shot : bool
        Whether the option was given, which belongs to a campaign of sweeps.
    beside : callable
        Has the folder watched, if that is asked for, as long as its context lasts.
    """
    from app.files.declarations.hammer_experiment import read_hammer_experiment

    started = time.perf_counter()
    if test_shot:
        raise click.BadParameter(
            "belongs to a campaign of sweeps; a hammer test has none", param_hint="--test-shot"
        )
    declared = read_hammer_experiment(file)

    from app.files.acquisition.hammer_folder import require_our_test
    from app.files.campaigns.folder import ENDING
    from app.files.campaigns.kind import is_hammer_folder
    from app.files.declarations.hammer_experiment import require_simulated
    from app.rig.doctor import require_port, require_room
    from app.terminal.end_signals import undisturbed
    from app.terminal.streams import keep_unseen

    kind = rig or declared.rig
    declared = declared.on(kind)
    if kind == "simulated":
        require_simulated(declared, file)
    folder = (out or file.resolve().with_name(file.stem + "-campaign")).resolve()
    acquired = declared.model_dump(mode="json") | {"rig": kind}
    # a test killed on a real rig may have left its oven on: checked once that is open, as that brings it to rest
    if kind == "simulated" or declared.oven is None or not is_hammer_folder(folder):
        require_our_test(folder, acquired)  # before a twin is built
        require_room(declared, folder)
        if kind != "simulated" and not is_hammer_folder(folder):
            require_port(declared, file)
    if kind != "simulated" and declared.oven is not None and not declared.oven.expires:
        output.note("this oven continues if the computer fails: see docs/guide/real-hardware.md on oven.program")
    with beside(folder):
        ending = _run(declared, kind, file, folder, acquired, again, started, output)
        summary: dict[str, Any] = {"campaign": str(folder), "rig": kind, "points": len(declared.mallet.places)}
        with undisturbed():  # another Ctrl-C must not take the place of what is said here
            output.result(lambda: summary | ending.record)
            say = output.failure if ending.status else output.summary
            say(ending.line)
            keep_unseen(folder / ENDING, ending.line)
    if ending.status:
        raise click.exceptions.Exit(ending.status)


def _run(
    declared: "HammerExperiment",
    kind: "RigKind",
    file: Path,
    folder: Path,
    acquired: dict[str, Any],
    again: bool,
    started: float,
    output: Output,
) -> "Ending":
    """Record; return how it ended, complete or broken off."""
    from app.files.acquisition.hammer_folder import hammer_log
    from app.files.campaign_error import CampaignFileError
    from app.files.campaigns.folder import Source
    from app.files.provenance import sha256
    from app.rig.assembly import hammer_rig, rig_places
    from app.stages.acquire_hammer import acquire_hammer, interrupted_at
    from app.terminal.campaign import HammerScreen, broken_off, hammer_keys
    from drivers.hammer.campaign import no_key
    from drivers.rig.end_requests import EndRequests, RigInterrupted, RigStopped
    from drivers.rig.session import Session

    with ExitStack() as stack:
        with output.progress() as report:  # of reducing the twin of a simulated rig
            opened = stack.enter_context(hammer_rig(declared, kind, file, interrupted_at(folder), report))
        requests, key = stack.enter_context(EndRequests()), stack.enter_context(hammer_keys())
        screen = HammerScreen(declared.mallet.places, shown=not output.quiet, keys=key is not no_key)
        session = None
        if opened.oven is not None and declared.limits is not None:
            session = Session(opened.oven, declared.limits, hammer_log(folder), requests.check)
        try:
            outcome = acquire_hammer(
                opened,
                session,
                declared,
                folder,
                Source(file.name, sha256(file)),
                acquired,
                screen,
                key=key,
                check=requests.check,
                again=again,
                places=rig_places(declared, kind),
            )
        except BaseException as error:
            unsafe = None if session is None else session.unsafe
            if isinstance(error, CampaignFileError) and not unsafe:
                raise
            if not isinstance(error, RigStopped | RigInterrupted | OSError | CampaignFileError):
                traceback.print_exception(error)
            return broken_off(error, unsafe, folder, requests.number)
        unsafe = () if session is None else session.unsafe or ()
        return _complete(outcome, unsafe, folder, time.perf_counter() - started)


def _complete(outcome: "HammerOutcome", unsafe: tuple[str, ...], folder: Path, seconds: float) -> "Ending":
    """Return the ending of a test that was not broken off."""
    from app.terminal.campaign import NOT_AT_REST, NOT_GOOD_ENOUGH, Ending, not_at_rest

    state = "stopped" if outcome.stopped else "complete with hits missing" if outcome.missing else "complete"
    record = {
        "state": state,
        "accepted": outcome.accepted,
        "missing": outcome.missing,
        "rejected": outcome.rejected,
        "skipped": outcome.skipped,
        "made_now": outcome.made_now,
        "doubted": outcome.doubted,
        "unsafe": list(unsafe),
        "seconds": seconds,
    }
    line = f"{outcome.accepted} hits in {folder}, {outcome.made_now} of them now, {outcome.rejected} rejected"
    if outcome.stopped:
        line = f"stopped: {line}; {outcome.missing} are missing: run the same command again to continue"
    elif outcome.missing:
        line += f"; {outcome.missing} are missing at {outcome.skipped} skipped points (--again asks for them)"
    else:
        line += f"; flexura identify {quoted(folder)}, flexura update {quoted(folder)}"
    if outcome.doubted:
        line += f"; the temperature of {outcome.doubted} is in doubt (events.jsonl says why)"
    status = NOT_AT_REST if unsafe else NOT_GOOD_ENOUGH if outcome.missing else 0
    return Ending(record, line + not_at_rest(unsafe), status)
