"""``flexura acquire``: run, or take up again, an experiment on a rig."""

import signal
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

    from app.files.experiment_toml import RigKind
    from drivers.rig.campaign import Moment, Outcome


class Signals:
    """Ends a campaign on Ctrl-C, on SIGTERM and when the terminal is closed: with everything at rest.

    A signal that arrives while Python runs a destructor (nidaqmx's tasks have one) raises into nothing; so it is
    kept, and `check`, called at every reading, raises it again. Only the first one raises by itself: a second must
    not cut short what brings the rig to rest.

    Attributes
    ----------
    arrived : int or None
        Number of the first signal.
    """

    NAMES = ("SIGINT", "SIGTERM", "SIGHUP")

    def __init__(self) -> None:
        self.arrived: int | None = None
        self._before: dict[int, Any] = {}
        self._unraisable = sys.unraisablehook

    def __enter__(self) -> "Signals":
        """Take the signals over."""
        for number in (getattr(signal, name) for name in self.NAMES if hasattr(signal, name)):
            self._before[number] = signal.signal(number, self._keep)
        self._unraisable, sys.unraisablehook = sys.unraisablehook, self._told_later
        return self

    def __exit__(self, *_: object) -> None:
        """Give them back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)
        sys.unraisablehook = self._unraisable

    def check(self) -> None:
        """Raise RigInterrupted if a signal has arrived."""
        from drivers.rig.errors import RigInterrupted

        if self.arrived is not None:
            raise RigInterrupted(signal.Signals(self.arrived).name)

    def _keep(self, number: int, _: object) -> None:
        if self.arrived is None:
            self.arrived = number
            self.check()

    def _told_later(self, lost: "UnraisableHookArgs") -> None:
        """Keep Python from printing a traceback over what `check` is going to raise again."""
        from drivers.rig.errors import RigInterrupted

        if not isinstance(lost.exc_value, RigInterrupted):
            self._unraisable(lost)


EXAMPLES = """\b
Examples:
  flexura acquire examples/simulated-rig.toml --out simulated
  flexura acquire my-experiment.toml --rig simulated --out rehearsal
  flexura acquire my-experiment.toml --again
"""


@click.command(name="acquire", epilog=EXAMPLES, short_help="Run a campaign on the rig, or take it up again.")
@click.argument("experiment", type=PATH)
@click.option("--rig", type=click.Choice(["simulated", "ni"]), help="Which rig (default: what EXPERIMENT says).")
@click.option("--again", is_flag=True, help="Run the legs once more for what was missed or failed.")
@out_folder("Campaign folder (default: NAME-campaign beside EXPERIMENT).")
@output_options("the summary")
@bad_input
def command(experiment: Path, rig: "RigKind | None", again: bool, out: Path | None, output: Output) -> None:
    """Run EXPERIMENT (a TOML file) on the rig, or take it up where it was interrupted.

    Sweeps are triggered by the temperature measured; each is checked, repeated within bounds, and written as one
    finished file. On Ctrl-C, on an error, when the oven or a card is lost or the disk is full, the drive is
    brought to 0 V and the oven to rest, and the same command goes on later: what is finished is never touched.
    Meanwhile, flexura view on the campaign folder shows how it gets on, and can pause or stop it.

    Exit status 1 where sweeps are missing at the end, or the rig stopped the campaign.
    """
    from drivers.ni.errors import DaqError
    from drivers.rig.errors import RigInterrupted, RigStopped

    folder = (out or experiment.resolve().with_name(experiment.stem + "-campaign")).resolve()
    started = time.perf_counter()
    summary: dict[str, Any] = {"campaign": str(folder)}
    signals = Signals()
    try:
        with signals:
            outcome, summary["rig"], summary["sweeps"] = _acquire(experiment, rig, folder, again, signals, output)
    except RigStopped as stopped:
        summary |= {"state": "stopped", "why": str(stopped), "unsafe": list(stopped.unsafe)}
        _told(summary, output, f"stopped: {stopped}")
    except RigInterrupted as interrupted:
        summary |= {"state": "stopped", "why": str(interrupted), "unsafe": list(interrupted.unsafe or ())}
        _told(summary, output, _interrupted_line(interrupted.unsafe))
        raise SystemExit(128 + (signals.arrived or 0)) from interrupted
    except DaqError as error:
        summary |= {"state": "stopped", "why": str(error), "unsafe": []}
        _told(summary, output, f"the rig cannot be opened: {error}")
    except OSError as error:
        summary |= {"state": "stopped", "why": str(error), "unsafe": []}
        _told(summary, output, f"stopped: {folder} cannot be written: {error}. Make room, then run this again")
    else:
        summary |= {
            "state": "complete" if not outcome.missing else "complete with sweeps missing",
            "finished": outcome.finished,
            "missing": outcome.missing,
            "made_now": outcome.made_now,
            "unsafe": list(outcome.unsafe),
            "seconds": time.perf_counter() - started,
        }
        line = _line(outcome, folder, time.perf_counter() - started)
        if not outcome.missing and not outcome.unsafe:
            output.result(lambda: summary)
            output.summary(line)
            return
        _told(summary, output, line)
    raise click.exceptions.Exit(1)


def _acquire(
    experiment: Path, kind: "RigKind | None", folder: Path, again: bool, signals: Signals, output: Output
) -> "tuple[Outcome, str, int]":
    from analysis.protocol.advice import smeared
    from app.acquisition import acquire_campaign
    from app.campaign_screen import campaign_screen
    from app.files.acquired_campaign import require_ours
    from app.files.experiment_toml import read_acquired_experiment
    from app.files.provenance import sha256
    from app.files.sweep_file import Source
    from app.rig import rig_of

    declared = read_acquired_experiment(experiment)
    for sentence in smeared(declared.sweep.duration, declared.programme.ramp_rate):
        output.note(sentence)
    chosen = kind or declared.rig
    declared = declared.on(chosen)
    source = Source(experiment.name, sha256(experiment))
    acquired = {"rig": chosen, **declared.model_dump(mode="json")}
    require_ours(folder, {"acquired": acquired})  # before a twin is built
    with output.progress() as report:
        opened = rig_of(declared, chosen, experiment, report)
        rig = opened.__enter__()
    try:
        with campaign_screen(chosen == "simulated", shown=not output.quiet) as screen:

            def observer(moment: "Moment") -> None:
                signals.check()
                screen(moment)

            outcome = acquire_campaign(rig, declared, folder, source, acquired, observer, again=again)
    finally:
        opened.__exit__(*sys.exc_info())
    return outcome, chosen, declared.protocol.count


def _line(outcome: "Outcome", folder: Path, seconds: float) -> str:
    line = f"{outcome.finished} sweeps in {folder}, {outcome.made_now} of them now, in {seconds:.1f} s"
    if outcome.missing:
        line += f"; {outcome.missing} are missing (events.jsonl says why; --again tries once more)"
    return line + _not_at_rest(outcome.unsafe)


def _interrupted_line(unsafe: "tuple[str, ...] | None") -> str:
    """Say how an interrupted rig was left; None: it was not running, so that nothing is known of it."""
    rest = "; the drive is at 0 V and the oven at rest" if unsafe == () else ""
    return f"stopped{rest}; run the same command again to go on" + _not_at_rest(unsafe or ())


def _not_at_rest(unsafe: tuple[str, ...]) -> str:
    return "".join(f"\nNOT AT REST: {what}" for what in unsafe)


def _told(summary: dict[str, Any], output: Output, line: str) -> None:
    output.result(lambda: summary)
    output.failure(line)
