"""``flexura update``: E, nu and eta of the plate at every temperature, and the laws through them."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import CAMPAIGN, Existing, effects_of_twin, mains, own_effects, run_out
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.channel import Channel
    from app.files.results.best_twin import BestTwin
    from app.stages.update_modes import UpdatingByModes


EXAMPLES = """\b
Examples:
  flexura update plate --out plate-run
  flexura update plate --twin plate-run/twin.toml --out plate-run
  flexura update modes.csv --plate plate.toml --out plate-run
"""


def update_by_modes(plate: Path, table: Path | None, out: Path | None, output: Output) -> bool:
    """Fit the twin of a plate to its modes, write laws.h5 and print the estimates.

    Parameters
    ----------
    plate : Path
        ``plate.toml``, or its folder.
    table : Path or None
        Modes; those that the declaration states where it is None.
    out : Path or None
        Run folder.

    Returns
    -------
    bool
        Whether every temperature settled.
    """
    from app.files.results.run_folder import run_folder
    from app.plate_frfs.plate_of_modes import read_plate_of_modes

    started = time.perf_counter()
    loaded = read_plate_of_modes(plate, table)
    from app.stages import update_modes as stage  # the import takes a second: a wrong file is reported before it
    from app.summaries.update import budget_lines, headline, notes, tables_of
    from app.terminal.tables import show

    beside = table if table is not None else plate.parent if plate.name == "plate.toml" else plate
    with run_folder(beside, out) as run, output.progress() as report:
        found = stage.compute(loaded, report)
    stage.save(run, loaded, found)
    updated, seconds = found.fitted.updated, time.perf_counter() - started
    output.result(
        lambda: record(found, loaded.experiment.inputs[:1], seconds),
        lambda: show(tables_of(updated), budget_lines(updated)),
    )
    for note in (*found.fitted.held, *said_of_modes(found)):
        output.note(note)
    for note in notes(updated, found.laws):
        if "flexura gap" not in note:  # which needs FRFs
            output.note(note)
    count = sum(len(one.frequency) for one in found.measured)
    output.summary(f"{count} modes, {headline(updated)}; results in {run}")
    return bool(updated.settled.all())


def record(found: "UpdatingByModes", driven: "Sequence[Channel]", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints: the estimates as of FRFs, without gains, and the modes.

    Parameters
    ----------
    driven : sequence of Channel
        The first input, whose gain is left out.
    seconds : float
        Time that it took, s.

    Returns
    -------
    dict
        Of JSON values.
    """
    from app.summaries.update import record as estimates

    whole = estimates(found.fitted.updated, seconds, driven, ())
    for row, measured, place, computed in zip(
        whole["temperatures"], found.measured, found.fitted.pairs, found.fitted.computed, strict=True
    ):
        row["modes"] = [
            {
                "mode": int(number) + 1,
                "measured_hz": float(f),
                "computed_hz": float(own[0]),
                "difference": float(own[0] / f - 1.0),
                "measured_loss_factor": None if loss != loss else float(loss),
                "computed_loss_factor": float(own[1]),
            }
            for number, f, loss, own in zip(place, measured.frequency, measured.loss_factor, computed, strict=True)
        ]
    whole["damping_scatter"] = None if found.fitted.scatter != found.fitted.scatter else found.fitted.scatter
    return {key: value for key, value in whole.items() if key not in ("gain", "sigma_gain")}


def said_of_modes(found: "UpdatingByModes") -> list[str]:
    """Say which measured mode is farthest from the twin's, and how far modal damping scatters."""
    import numpy as np

    rows = [
        (abs(float(own[0] / f) - 1.0), float(f), float(own[0]), one.temperature)
        for one, computed in zip(found.measured, found.fitted.computed, strict=True)
        for f, own in zip(one.frequency, computed, strict=True)
    ]
    away, measured, twin, temperature = max(rows)
    said = [
        f"largest difference: {measured:.1f} Hz at {temperature:.1f} °C, {twin:.1f} Hz of the twin "
        f"({100 * away:.2f} %)"
    ]
    scatter = found.fitted.scatter
    if np.isfinite(scatter):
        said.append(f"modal dampings scatter about the twin's by {100 * scatter:.2g} % (one standard deviation)")
    return said


@click.command(name="update", epilog=EXAMPLES, short_help="Find E, nu and eta at every temperature.")
@click.argument("campaign", type=CAMPAIGN)
@click.option(
    "--plate",
    type=Existing("write it with: flexura new plate"),
    metavar="PLATE.toml",
    help="What plate it is, where CAMPAIGN is a table of modes (CSV).",
)
@effects_of_twin
@own_effects
@run_out
@mains
@output_options("the estimates")
@bad_input
def command(
    campaign: Path,
    plate: Path | None,
    twin: Path | None,
    effects: Path | None,
    out: Path | None,
    mains: float,
    output: Output,
) -> None:
    """Update the twin of CAMPAIGN: E, nu and eta per temperature, one gain for each actuator, smooth laws.

    Fits the finite-element twin of the declared plate, patches and electronics to the measured FRFs, each line
    weighted by its variance. With --twin the effects in that file are on with the values they have there, and the
    laws are those of the plate under them. Pairs measured modes with the twin's: those of modes.h5 in the run
    folder if flexura identify was run, else those of one sweep. Writes frf.h5 and laws.h5 into the run folder.
    If flexura gap corrected laws there, a note says that other verbs use those.
    Exit status 1 where a temperature's fit did not settle inside the twin's certified range, and where the modes
    do not pair: the twin is no fit then, and the likely reason is looked for.
    CAMPAIGN may also be a plate with FRFs of other programs (plate.toml), or with --plate a table of natural
    frequencies and damping: then laws.h5 alone is written.

    CAMPAIGN may be running or interrupted: its finished sweeps are taken, and the result says how many of how many
    they are. Laws need three temperatures. Do the same again when more sweeps are there.
    """
    modes = _modes(campaign, plate)
    if modes is not None:
        _by_modes(*modes, out, output, told=twin or effects)
        return
    from app.files.campaigns.loading import load_campaign
    from app.files.campaigns.of_run import campaign_typed, remember_campaign
    from app.files.disk_room import room_of
    from app.files.results.best_twin import best_twin
    from app.files.results.pairing_json import pairing_record
    from app.files.results.run_folder import run_folder
    from app.summaries.modes import pairing_tables
    from app.summaries.numbers import extent_record, led
    from app.summaries.update import budget_lines, gains_text, notes, record, summary, tables_of
    from app.terminal.tables import show

    started = time.perf_counter()
    loaded = load_campaign(campaign)
    from app.stages import update  # the import takes a second: a wrong folder is reported before it
    from app.stages.update import UpdateRequest

    request = UpdateRequest(loaded, twin=twin, effects=effects, mains=mains)
    start = request.start
    with run_folder(campaign, out, room_of(campaign)) as run, output.progress() as report:
        found = update.compute(request, report, run=run)
        replaced = other_effects(run / "laws.h5", {} if start is None else start.twin.effects)
        update.save(run, request, found)
        remember_campaign(run, campaign)
    updated, seconds = found.updated, time.perf_counter() - started
    inputs, best = loaded.experiment.inputs, best_twin(run, "update")
    pairs = pairing_record(found.pairing)
    output.result(
        lambda: {
            **record(updated, seconds, inputs, found.frf.driven_by.tolist()),
            "pairing": pairs,
            "best_twin": best.record,
            **extent_record(loaded.extent),
        },
        lambda: show([*tables_of(updated, found.frf.drives), *pairing_tables(pairs)], budget_lines(updated)),
    )
    if len(inputs) > 1:
        output.note(f"gains: {gains_text(updated, inputs)}")
    for note in (*found.frf.notes, *notes(updated, found.laws, found.pairing, campaign_typed(campaign, out))):
        output.note(note)
    if start is not None:
        on = ", ".join(start.twin.effects) or "no effect"
        output.note(f"{start.path}: {on} switched on; the laws in {run / 'laws.h5'} are those under it")
    if replaced is not None:
        output.note(
            f"{run / 'laws.h5'} held the laws {replaced}; they are replaced. To keep both: --out ANOTHER-FOLDER"
        )
    for sentence in overtaken(best):
        output.note(sentence)
    said = summary(updated, run, seconds, inputs[0].gain_unit, found.pairing)
    output.summary(f"{led(loaded.extent)}{said}")
    if not updated.settled.all() or not (found.pairing is None or found.pairing.fits):
        raise click.exceptions.Exit(1)


def _by_modes(plate: Path, table: Path | None, out: Path | None, output: Output, *, told: Path | None) -> None:
    """Update by modes alone; `told` is a file of effects, which they do not show."""
    if told is not None:
        raise click.BadParameter("modes alone tell no effects; leave it out, or give FRFs", param_hint="--twin")

    if not update_by_modes(plate, table, out, output):
        raise click.exceptions.Exit(1)


def _modes(campaign: Path, plate: Path | None) -> tuple[Path, Path | None] | None:
    """Return the declared plate, and the table of its modes where they are not declared; None for FRFs."""
    if plate is not None:
        return plate, campaign
    from app.files.declarations.plate import declares_plate, plate_file
    from app.files.settings_toml import read_table

    if not declares_plate(campaign):
        return None
    table = read_table(plate_file(campaign))
    return (campaign, None) if "modes" in table and "frf" not in table else None


def overtaken(best: "BestTwin") -> list[str]:
    """Say that corrected laws take the place of those just found, or why corrected laws are not used."""
    if best.uncorrected is None:
        return list(best.ignored)
    return [
        f"these laws are those of the plain twin; report, focus and compensate use {best.twin.path.name} beside "
        f"them, corrected by flexura gap ({best.names})"
    ]


def other_effects(laws: Path, effects: dict[str, Any]) -> str | None:
    """Describe other effects with which the laws to be replaced were fitted; None if the same, or no laws."""
    from app.files.bad_file import ResultFileError
    from app.files.results.laws_file import effects_in_laws

    try:
        before = effects_in_laws(laws) if laws.is_file() else effects
    except ResultFileError:
        return None
    if before == effects:
        return None
    return f"under {', '.join(before)}" if before else "without effects"
