"""``flexura compensate``: temperature-dependent filters by networks and other methods."""

import functools
import time
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click
from click.core import ParameterSource

from analysis.compensation.settings import ACROSS, PLACES, SPACINGS, Training
from app.commands.bad_input import bad_input
from app.commands.options import (
    FOCUSING_METHODS,
    PANEL,
    RUN,
    TRANSFERS,
    WEATHER,
    filter_options,
    laws_of_twin,
    out_folder,
)
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.focusing.methods import Method


COMPENSATION_BYTES = 20e6
"""Bytes of ``compensation.h5``, roughly: with two actuators it is 11 MB."""

EXAMPLES = """\b
Examples:
  flexura compensate plate-run
  flexura compensate plate-run --spacing 4 --restarts 3
  flexura compensate plate-run --place 8
  flexura compensate plate-run --across 10 --across 20
  flexura compensate plate-run --weather examples/warming-car.toml
  flexura compensate --transfers scan.h5 --panel scanned.toml --out scan-run
  flexura compensate plate-run --feed temperature --start random --split matlab --seed 7
"""


Verb = TypeVar("Verb", bound=Callable[..., object])

PAPER_CHOICES = ("feed", "scale", "start", "split", "design")
"""Options that --as-paper sets."""

TRAINING_OPTIONS = (
    click.option(
        "--nodes",
        type=click.IntRange(1, 100),
        default=Training.nodes,
        show_default=True,
        help="Hidden nodes; fewer where temperatures placed or measured are few.",
    ),
    click.option(
        "--restarts", type=click.IntRange(1, 100), default=1, show_default=True, help="Trainings per actuator."
    ),
    click.option(
        "--feed",
        type=click.Choice(("rigidity", "temperature")),
        default="rigidity",
        show_default=True,
        help="What the networks are fed: log √D of the plate at the temperature, "
        "or the temperature as in the paper.",
    ),
    click.option(
        "--scale",
        type=click.Choice(("global", "tap")),
        default="global",
        show_default=True,
        help="One scale for an actuator's taps, or each tap stretched to -1..1 as MATLAB does.",
    ),
    click.option(
        "--start",
        type=click.Choice(("warm", "random")),
        default="warm",
        show_default=True,
        help="Output layer from a ridge fit, or random as in MATLAB.",
    ),
    click.option(
        "--split",
        type=click.Choice(("none", "matlab")),
        default="none",
        show_default=True,
        help="Train on all temperatures, or leave a random 15 % out as MATLAB does.",
    ),
    click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of all that is random."),
)


def training_options(verb: Verb) -> Verb:
    """Add the options of the training to a verb, which receives them as one mapping, `training`."""

    @functools.wraps(verb)
    def training(*args: Any, **options: Any) -> object:
        given = {one.name: options.pop(one.name) for one in fields(Training) if one.name in options}
        return verb(*args, training=given, **options)

    for option in reversed(TRAINING_OPTIONS):
        training = option(training)
    return cast("Verb", training)


def training_of(choices: dict[str, Any], as_paper: bool) -> Training:
    """Return the training settings; UsageError for an option given together with --as-paper."""
    named = [option for option in PAPER_CHOICES if typed(option)]
    if as_paper and named:
        raise click.UsageError(f"--as-paper sets --{named[0]} itself: leave one of them out")
    return Training(**choices).as_paper() if as_paper else Training(**choices)


def typed(option: str) -> bool:
    """Whether an option was given, not left at its default."""
    return click.get_current_context().get_parameter_source(option) is not ParameterSource.DEFAULT


@click.command(
    name="compensate", epilog=EXAMPLES, short_help="Train networks that give filters at any temperature."
)
@click.argument("run", type=RUN, required=False)
@click.option("--panel", type=PANEL, help="Panel file (default: that of RUN's filters.h5).")
@click.option(
    "--spacing",
    type=click.FloatRange(*SPACINGS),
    default=5.0,
    show_default=True,
    help="°C between training temperatures.",
)
@click.option(
    "--place",
    type=click.IntRange(*PLACES),
    help="Place so many training temperatures where the filters need them, instead of every SPACING.",
)
@click.option(
    "--across",
    type=click.FloatRange(*ACROSS),
    multiple=True,
    help="Loss of contrast for this difference between two sides of the panel, K; repeat for more.",
)
@click.option(
    "--weather",
    type=WEATHER,
    help="Judge filters while the panel warms up or cools down unevenly: a weather's file (*.toml).",
)
@click.option(
    "--transfers",
    type=TRANSFERS,
    help="Measured transfers at five temperatures or more (HDF5, a folder of UFF58), in place of laws and twin.",
)
@training_options
@click.option(
    "--device", default="cpu", show_default=True, help="Where networks are trained: cpu, cuda, cuda:1, ..."
)
@click.option(
    "--method",
    type=click.Choice(FOCUSING_METHODS),
    help="How the filters are designed that are followed (default: as in RUN's filters.h5, else stif).",
)
@click.option(
    "--as-paper", is_flag=True, help="Feed, scale, start, split and design as in the paper, all at once."
)
@filter_options
@laws_of_twin
@out_folder("Folder for compensation.h5 (default: beside the laws).")
@output_options("the figures of every method")
@bad_input
def command(
    run: Path | None,
    panel: Path | None,
    spacing: float,
    place: int | None,
    across: tuple[float, ...],
    weather: Path | None,
    transfers: Path | None,
    training: dict[str, Any],
    device: str,
    method: "Method | None",
    as_paper: bool,
    filters: dict[str, Any],
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Train one network per actuator: temperature in, the taps of its filter out.

    RUN is a run folder with laws.h5, or a laws file (default: the current folder). Of a folder, those of its
    best twin are used: corrected, if flexura gap named an effect there. Trains on the filters every
    SPACING °C, designed as in RUN's filters.h5 unless said otherwise, and judges networks, linear interpolation,
    cubic splines, interpolation at equal reduced frequency and principal filters against the filters computed
    every 0.25 °C. With --weather, the heat equation of the plate is solved, and filters are judged that know its
    field of temperatures from one thermometer, from several, or from the panel's own response. The uncertainty
    of the contrast due to that of the laws is given as a band. With --transfers, trains on the filters of all
    measured temperatures, and tests each inner one with networks trained without it. Writes compensation.h5. Exit
    status 1 where a network is refused, or loses more than 0.02 of contrast at any line of any temperature tested.
    """
    from analysis.compensation.evidence_collapse import EvidenceCollapseError

    started = time.perf_counter()
    filters = filters | ({"design": "inverse-fft"} if as_paper else {})
    chosen = training_of(training, as_paper)
    if transfers is None:
        if place is not None and typed("spacing"):
            raise click.UsageError("--place and --spacing each choose the training temperatures: name one of them")
    else:
        _refuse_with_transfers(twin, place, across, weather)

    from app.stages.panel.requests import CompensateRequest

    wanted = CompensateRequest(
        run,
        twin,
        panel,
        filters,
        method,
        spacing,
        place,
        across,
        chosen,
        typed("nodes"),
        transfers=transfers,
        weather=weather,
    )
    task = wanted.task()
    if out is not None:
        task.require_folder(out)

    from app.files.results.run_folder import run_folder
    from app.stages import compensate
    from app.stages.panel.inputs import checked_device
    from app.summaries.compensation import notes, record, summary, tables
    from app.summaries.numbers import extent_record, led
    from app.terminal.tables import show

    checked_device(device)
    with run_folder(task.beside, out or task.beside, COMPENSATION_BYTES) as folder, output.progress() as report:
        try:
            computed = task.compute(report, device)
        except EvidenceCollapseError as error:
            output.failure(f"refused: {error}")
            raise click.exceptions.Exit(1) from error
        target = compensate.save(folder, computed, task.hashes(), task.extent)
        task.remember(folder)
    found = computed.compensation
    seconds = time.perf_counter() - started
    output.result(lambda: record(found, seconds) | extent_record(task.extent), lambda: show(tables(found)))
    for note in [*task.notes, *notes(found, task.training)]:
        output.note(note)
    output.summary(f"{led(task.extent)}panel {task.panel.title!r}, {summary(found, target, seconds)}")
    if found.largest_loss[0] > compensate.GOOD_LOSS:
        raise click.exceptions.Exit(1)


def _refuse_with_transfers(
    twin: Path | None, place: int | None, across: tuple[float, ...], weather: Path | None
) -> None:
    """Refuse options on temperatures or laws together with measured transfers."""
    if twin is not None or place is not None or across or weather or typed("spacing"):
        raise click.UsageError(
            "--transfers takes the place of --twin, and trains on the temperatures measured: leave out "
            "--spacing, --place, --across and --weather"
        )
