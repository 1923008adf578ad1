"""``flexura update`` of natural frequencies and damping, without FRFs."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.output import Output

if TYPE_CHECKING:
    from collections.abc import Sequence

    from analysis.channel import Channel
    from app.stages.update_modes import UpdatingByModes


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
    from app.files.run_folder import run_folder
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
