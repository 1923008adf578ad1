"""``flexura acquire``: run or resume an experiment on a rig."""

import time
import traceback
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import EXPERIMENT, out_folder, telling_options, which_rig
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from app.files.declarations.experiment import AcquiredExperiment, RigKind
    from app.terminal.campaign import Ending
    from drivers.rig.campaign import Outcome
    from drivers.rig.rig import Rig
    from drivers.rig.session import Session

EXAMPLES = """\b
Examples:
  flexura acquire examples/simulated-rig.toml --out simulated
  flexura acquire my-experiment.toml --rig simulated --out rehearsal
  flexura acquire my-experiment.toml --test-shot
  flexura acquire my-experiment.toml --again
  flexura acquire examples/hammer-rig.toml --out hammered
"""


@click.command(name="acquire", epilog=EXAMPLES, short_help="Run a campaign on the rig, or resume it.")
@click.argument("experiment", type=EXPERIMENT)
@which_rig
@click.option("--test-shot", is_flag=True, help="One short sweep as things are, the oven left alone; no campaign.")
@click.option("--again", is_flag=True, help="Repeat the legs for sweeps that were missed or failed.")
@click.option("--watch", is_flag=True, help="Start flexura watch on it: its page, in a process of its own.")
@telling_options
@out_folder("Campaign folder (default: NAME-campaign beside EXPERIMENT).")
@output_options("the summary")
@bad_input
def command(
    experiment: Path,
    rig: "RigKind | None",
    test_shot: bool,
    again: bool,
    watch: bool,
    notify: tuple[str, ...],
    notify_command: tuple[str, ...],
    out: Path | None,
    output: Output,
) -> None:
    """Run EXPERIMENT (a TOML file) on the rig, or take it up where it was interrupted.

    Sweeps are triggered by the temperature measured; each is checked, repeated within bounds, and written as one
    finished file. However it ends (Ctrl-C, an error, a lost oven or card, a full disk, a closed terminal), the
    oven is brought to rest and the drive to 0 V, and the same command resumes it later: finished sweeps are
    never touched. Meanwhile, flexura view on the campaign folder shows how it gets on, and can pause or stop it.

    With --test-shot no campaign is begun: cards, oven and disk are checked, then one short sweep is played at the
    present temperature. The report shows level, clipping, coherence, noise and hum of every input, and the
    duration of the campaign. Every campaign begins with such a shot, and stops there if a cable is disconnected.

    With --watch, or with --notify or --notify-command, flexura watch runs beside it until it has told how the
    campaign ended. Whatever happens to that process, the campaign does not notice. What could not be told is
    said here; once the campaign has ended, that is waited for, 10 s at most.

    An EXPERIMENT with kind = "hammer" is a hammer test: hits are asked for point by point, and each is judged and
    written at once. On a terminal, u undoes the last hit, s skips the point, r repeats it, q stops. identify,
    update and gap take its folder.

    Exit status 1 where sweeps or hits are missing at the end, or the rig stopped the campaign; 3 where something
    could not be verified to be at rest (NOT AT REST: go there and switch it off).
    """
    from app.files.declarations.hammer_experiment import declares_hammer_test

    if declares_hammer_test(experiment):
        from app.commands.acquire_hammer import acquire_hits

        _require_told(notify, notify_command, out)

        def beside(folder: Path) -> "AbstractContextManager[None]":
            return _watched(folder, watch, notify, notify_command, output)

        acquire_hits(experiment, rig, out, output, again=again, test_shot=test_shot, beside=beside)
        return
    from app.files.declarations.experiment import read_acquired_experiment

    started = time.perf_counter()
    _require_told(notify, notify_command, out)
    declared = read_acquired_experiment(experiment)

    from app.files.acquisition.same_experiment import require_ours
    from app.files.campaigns.folder import ENDING
    from app.files.campaigns.kind import is_campaign_folder
    from app.rig.doctor import require_port, require_room
    from app.terminal.end_signals import undisturbed
    from app.terminal.streams import keep_unseen

    folder = (out or experiment.resolve().with_name(experiment.stem + "-campaign")).resolve()
    kind = rig or declared.rig
    declared = declared.on(kind)
    acquired = declared.model_dump(mode="json") | {"rig": kind}
    if test_shot or kind == "simulated" or not is_campaign_folder(folder):
        require_ours(folder, {"acquired": acquired})  # checked before a twin is built
        require_room(declared, folder)
        if kind != "simulated" and not (test_shot or is_campaign_folder(folder)):
            require_port(declared, experiment)
    # a campaign killed on a real rig may have left it on: checked once the rig is open, as that brings it to rest
    _advise(declared, kind, output)
    if test_shot:
        _shoot(declared, kind, experiment, folder, output)
        return
    with _watched(folder, watch, notify, notify_command, output):
        ending = _run(declared, kind, experiment, folder, acquired, again, started, output)
        summary: dict[str, Any] = {"campaign": str(folder), "rig": kind, "sweeps": declared.protocol.count}
        with undisturbed():  # another Ctrl-C must not take the place of what is said here
            output.result(lambda: summary | ending.record)
            say = output.failure if ending.status else output.summary
            say(ending.line)
            keep_unseen(folder / ENDING, ending.line)
    if ending.status:
        raise click.exceptions.Exit(ending.status)


def _require_told(notify: tuple[str, ...], notify_command: tuple[str, ...], out: Path | None) -> None:
    """Refuse what the watcher would refuse, before anything begins; what only it can find out, it says itself."""
    if notify or notify_command:
        from app.watch.notifiers import notifiers

        notifiers(notify, notify_command, [] if out is None else [out])


@contextmanager
def _watched(
    folder: Path, watch: bool, notify: tuple[str, ...], notify_command: tuple[str, ...], output: Output
) -> "Iterator[None]":
    """Have the campaign watched by a process of its own, if that is asked for."""
    if not (watch or notify or notify_command):
        yield
        return
    from app.watch.beside import watched_beside

    with watched_beside(folder, notify, notify_command, output.note):
        yield


def _run(
    declared: "AcquiredExperiment",
    kind: "RigKind",
    experiment: Path,
    folder: Path,
    acquired: dict[str, Any],
    again: bool,
    started: float,
    output: Output,
) -> "Ending":
    """Run the campaign; return how it ended, completed or broken off."""
    from app.files.acquisition.campaign_folder import campaign_log
    from app.files.campaign_error import CampaignFileError
    from app.terminal.campaign import broken_off, completed
    from drivers.rig.end_requests import EndRequests, RigInterrupted, RigStopped
    from drivers.rig.session import Session

    with _open(declared, kind, experiment, output) as opened, EndRequests() as requests:
        session = Session(opened, declared.limits, campaign_log(folder), requests.check)
        try:
            outcome = _acquire(session, declared, experiment, folder, acquired, again, output)
        except BaseException as error:
            if isinstance(error, CampaignFileError) and not session.unsafe:
                raise
            if not isinstance(error, RigStopped | RigInterrupted | OSError | CampaignFileError):
                traceback.print_exception(error)
            with session.told_if_it_hangs():
                return broken_off(error, session.unsafe, folder, requests.number)
        with session.told_if_it_hangs():
            return completed(outcome, session.unsafe or (), folder, time.perf_counter() - started)


def _advise(declared: "AcquiredExperiment", kind: "RigKind", output: Output) -> None:
    from analysis.protocol.objections import change_within_sweep, unseen_lag

    if kind != "simulated" and not declared.oven.expires:
        output.note("this oven continues if the computer fails: see docs/guide/real-hardware.md on oven.program")
    for sentence in change_within_sweep(declared.sweep.duration, declared.programme.ramp_rate):
        output.note(f"{sentence}. From three temperatures on, it is taken into account, to first order")
    for sentence in () if declared.plate_measured else unseen_lag(declared.recorded(declared.sample_rate)):
        output.note(sentence)


@contextmanager
def _open(declared: "AcquiredExperiment", kind: "RigKind", experiment: Path, output: Output) -> "Iterator[Rig]":
    """Yield the rig; the progress of reducing its twin is shown."""
    from app.rig.assembly import rig_of

    with ExitStack() as stack:
        try:
            with output.progress() as report:
                rig = stack.enter_context(rig_of(declared, kind, experiment, report))
        except KeyboardInterrupt:
            if kind == "simulated":
                output.note("nothing was begun: the simulated plate was still being made")
            raise
        yield rig


def _shoot(
    declared: "AcquiredExperiment", kind: "RigKind", experiment: Path, folder: Path, output: Output
) -> None:
    """Print the checks before a campaign; after a failed check no twin is reduced and nothing is played."""
    from app.commands.doctor import show
    from app.rig.doctor import look_before, shoot
    from app.terminal.campaign import NOT_AT_REST, not_at_rest
    from drivers.rig.end_requests import EndRequests
    from drivers.rig.survey import FindingState

    findings = list(look_before(declared, kind, folder))
    unsafe: tuple[str, ...] = ()
    if all(one.state is not FindingState.BAD for one in findings):
        with _open(declared, kind, experiment, output) as opened, EndRequests() as requests:
            of_shot, unsafe = shoot(declared, kind, opened, requests.check)
        findings += of_shot
    bad = [one for one in findings if one.state is FindingState.BAD]
    rows = [{"what": o.what, "state": str(o.state), "seen": o.seen, "next_step": o.next_step} for o in findings]
    record = {"ready": not (bad or unsafe), "rig": kind, "findings": rows, "unsafe": list(unsafe)}
    output.result(lambda: record, lambda: show(findings))
    if unsafe:
        output.failure(not_at_rest(unsafe).lstrip())
        raise click.exceptions.Exit(NOT_AT_REST)
    if bad:
        output.failure(f"not ready: {', '.join(dict.fromkeys(one.what for one in bad))}")
        raise click.exceptions.Exit(1)
    output.summary(f"ready for {experiment}; the output is at 0 V, the oven was left as it is")


def _acquire(
    session: "Session",
    declared: "AcquiredExperiment",
    experiment: Path,
    folder: Path,
    acquired: dict[str, Any],
    again: bool,
    output: Output,
) -> "Outcome":
    from app.files.campaigns.folder import Source
    from app.files.provenance import sha256
    from app.rig.assembly import rig_places
    from app.stages.acquire import acquire_campaign
    from app.terminal.campaign import campaign_screen

    source = Source(experiment.name, sha256(experiment))
    with campaign_screen(acquired["rig"] == "simulated", shown=not output.quiet) as screen:
        places = rig_places(declared, acquired["rig"])
        return acquire_campaign(session, declared, folder, source, acquired, screen, again=again, places=places)
