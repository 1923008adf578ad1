"""``flexura compensate``: filters that follow the temperature, by networks and by their rivals."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import FOCUSING_METHODS, PATH, filter_options, laws_of_twin, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    import numpy as np

    from analysis.compensation.outcome import Compensation
    from analysis.focusing.panel import Panel

GOOD_LOSS = 0.02
"""Contrast that networks may lose against filters computed directly, at any line of any temperature."""


EXAMPLES = """\b
Examples:
  flexura compensate plate-run
  flexura compensate plate-run --spacing 4 --restarts 3
  flexura compensate plate-run --feed temperature --start random --split matlab --seed 7
"""


@click.command(
    name="compensate", epilog=EXAMPLES, short_help="Train networks that give filters at any temperature."
)
@click.argument("run", type=PATH, required=False)
@click.option("--panel", type=PATH, help="Panel file (default: that of RUN's filters.h5).")
@click.option(
    "--spacing",
    type=click.FloatRange(0.5, 30.0),
    default=5.0,
    show_default=True,
    help="°C between training temperatures.",
)
@click.option("--nodes", type=click.IntRange(1, 100), default=10, show_default=True, help="Hidden nodes.")
@click.option(
    "--restarts", type=click.IntRange(1, 100), default=1, show_default=True, help="Trainings per actuator."
)
@click.option(
    "--feed",
    type=click.Choice(("rigidity", "temperature")),
    default="rigidity",
    show_default=True,
    help="What the networks are fed: log √D of the plate at the temperature, or the temperature as in the paper.",
)
@click.option(
    "--scale",
    type=click.Choice(("global", "tap")),
    default="global",
    show_default=True,
    help="One scale for an actuator's taps, or each tap stretched to -1..1 as MATLAB does.",
)
@click.option(
    "--start",
    type=click.Choice(("warm", "random")),
    default="warm",
    show_default=True,
    help="Output layer from a ridge fit, or random as in MATLAB.",
)
@click.option(
    "--split",
    type=click.Choice(("none", "matlab")),
    default="none",
    show_default=True,
    help="Train on all temperatures, or leave a random 15 % out as MATLAB does.",
)
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of all that is random.")
@click.option("--device", default="cpu", show_default=True, help="Where torch trains: cpu, cuda, cuda:1, ...")
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
    nodes: int,
    restarts: int,
    feed: str,
    scale: str,
    start: str,
    split: str,
    seed: int,
    device: str,
    method: str | None,
    as_paper: bool,
    filters: dict[str, Any],
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Train one network per actuator: temperature in, the taps of its filter out.

    RUN is a run folder with laws.h5, or a laws file (default: the current folder). Trains on the filters every
    SPACING °C, designed as in RUN's filters.h5 unless said otherwise, and judges networks, linear interpolation,
    cubic splines, interpolation at equal reduced frequency and principal filters against the filters computed
    every 0.25 °C. Writes compensation.h5. Exit status 1 where a network is refused, or loses more than 0.02 of
    contrast at any line of any temperature.
    """
    from analysis.compensation.settings import Training
    from analysis.compensation.training import EvidenceCollapseError
    from analysis.focusing.over_temperature import spaced
    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.stages import compensate
    from app.stages.panel_inputs import checked_device, laws_for, method_for, panel_for, range_of

    started = time.perf_counter()
    laws_path, laws, beside = laws_for(run, twin, "compensate")
    filters = filters | ({"design": "inverse-fft"} if as_paper else {})
    declared, panel_path = panel_for(panel, beside, filters)
    followed = method_for(method, panel, beside)  # type: ignore[arg-type]
    low, high = range_of(declared, laws, laws_path)
    training = Training(
        nodes=nodes, feed=feed, scale=scale, start=start, split=split, restarts=restarts, seed=seed
    )
    training = training.as_paper() if as_paper else training
    checked_device(device)
    try:
        training.check_temperatures(len(spaced(low, high, spacing)))
    except ValueError as error:
        raise click.UsageError(f"--spacing {spacing:g}, {low:g} to {high:g} °C: {error}") from error
    folder = run_folder(beside, out or beside)
    with output.progress() as report:
        try:
            computed = compensate.compute(
                declared, laws, report, training=training, spacing=spacing, method=followed, device=device
            )
        except EvidenceCollapseError as error:
            output.failure(f"refused: {error}")
            raise click.exceptions.Exit(1) from error
    target = compensate.save(folder, computed, {path.name: sha256(path) for path in (laws_path, panel_path)})
    found = computed.compensation
    seconds = time.perf_counter() - started
    output.result(lambda: record(found, seconds), lambda: show(found))
    for note in notes(twin, declared, low, high, followed):
        output.note(note)
    output.summary(summary(found, target, seconds))
    if found.largest_loss[0] > GOOD_LOSS:
        raise click.exceptions.Exit(1)


def notes(twin: Path | None, panel: "Panel", low: float, high: float, method: str) -> list[str]:
    """Return what a user has to know of where the laws come from, how far they reach, and what is followed.

    Parameters
    ----------
    twin : Path or None
        Twin file that gave the laws; None where a run did.
    panel : Panel
    low, high : float
        Temperatures that laws and panel share, degrees Celsius.
    method : str
        How the filters followed are designed.

    Returns
    -------
    list of str
        A sentence each; empty where there is nothing to say.
    """
    from app.stages.panel_inputs import effects_left_out

    found = [] if twin is None else effects_left_out(twin)
    if (low, high) != panel.filters.operating_range:
        found.append(f"the laws cover {low:g} to {high:g} °C only")
    if method != "stif":
        found.append(f"the filters followed are those of {method}; --method stif trains on STIF")
    return found


def record(found: "Compensation", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints."""
    from analysis.focusing.performance import area_normalised

    trained = found.trained
    return {
        "methods": {
            name: {
                "contrast": float(found.contrast[m].mean()),
                "contrast_worst_line": float(found.contrast[m].min()),
                "contrast_area_normalised": float(area_normalised(found.contrast[m], found.target_share).mean()),
                "contrast_loss": float(found.largest_loss[m]),
                "contrast_loss_band_mean": float(found.contrast_loss[m].mean(axis=1).max()),
                "phase_error_deg": float(found.phase_error[m]),
                "level_ripple_db": float(found.level_ripple[m]),
                "peak_drive": float(found.peak_drive[m].max()),
                "bytes": int(found.size[m]),
                "multiplications_per_update": int(found.update_cost[m]),
                "relative_error_max_percent": _largest(found, m),
                "relative_error_mean_percent": float(found.relative_error[m].mean()),
                "left_out_max_percent": float(found.left_out[m].max()),
                "seconds": float(found.seconds[m]),
            }
            for m, name in enumerate(found.methods)
        },
        "best": found.best,
        "recommended": found.recommended,
        "focusing": found.focusing,
        "taps": found.filters.taps.shape[2],
        "latency_ms": 1e3 * found.filters.delay / found.filters.sample_rate,
        "temperatures": len(found.temperature),
        "temperature_range_c": [float(found.temperature[0]), float(found.temperature[-1])],
        "training_temperatures_c": found.training_temperature.tolist(),
        "actuators": found.relative_error.shape[2],
        "network": {
            "nodes": trained.settings.nodes,
            "parameters_determined": trained.gamma.tolist(),
            "log_evidence": trained.log_evidence.tolist(),
            "training_error_percent": trained.training_error.tolist(),
            "epochs": trained.epochs.tolist(),
            "seed": trained.settings.seed,
        },
        "contrast_direct_mean": float(found.contrast_direct.mean()),
        "seconds": seconds,
    }


def show(found: "Compensation") -> None:
    """Print a table of the methods for people."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    from analysis.focusing.performance import area_normalised

    latency = 1e3 * found.filters.delay / found.filters.sample_rate
    caption = (
        f"{found.focusing}, {found.filters.taps.shape[2]} taps, {latency:.1f} ms; all temperatures and lines\n"
        "RE: relative error, eq. (13), of energy: 0.01 % is 1 % of amplitude"
    )
    table = Table(
        title="Filters between the training temperatures",
        caption=caption,
        header_style="bold",
        box=SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    table.add_column("", no_wrap=True)
    for name in found.methods:
        table.add_column(name.replace("-", "-\n"), justify="right")
    share = found.target_share
    for figure, values in (
        ("contrast, mean", [f"{c.mean():.3f}" for c in found.contrast]),
        ("contrast, worst line", [f"{c.min():.3f}" for c in found.contrast]),
        ("contrast lost, mean", [f"{c.mean(axis=1).max():.4f}" for c in found.contrast_loss]),
        ("contrast lost, worst line", [f"{c:.4f}" for c in found.largest_loss]),
        ("contrast by area, mean", [f"{area_normalised(c, share).mean():.3f}" for c in found.contrast]),
        ("phase error, °", [f"{c:.1f}" for c in found.phase_error]),
        ("level ripple, dB", [f"{c:.1f}" for c in found.level_ripple]),
        ("peak drive", [f"{c.max():.3g}" for c in found.peak_drive]),
        ("kilobytes", [f"{c / 1e3:.0f}" for c in found.size]),
        ("multiplications, 10³", [f"{c / 1e3:.0f}" for c in found.update_cost]),
        ("time, s", [f"{c:.2f}" for c in found.seconds]),
        ("relative error, %", [f"{_largest(found, m):.1g}" for m in range(len(found.methods))]),
    ):
        table.add_row(figure, *values)
    Console().print(table)


def summary(found: "Compensation", target: Path, seconds: float) -> str:
    """Return one line for people.

    Parameters
    ----------
    found : Compensation
    target : Path
        File it was written to.
    seconds : float
        It took, s.

    Returns
    -------
    str
    """
    t = found.temperature
    return (
        f"{len(found.training_temperature)} training temperatures, judged at {len(t)} from {t[0]:g} to {t[-1]:g} "
        f"°C: the networks lose at most {found.largest_loss[0]:.2g} of contrast (relative error "
        f"{_largest(found, 0):.2g} % of energy); best here: {found.best}, "
        f"recommended: {found.recommended}; {seconds:.1f} s; {target}"
    )


def _largest(found: "Compensation", method: int) -> float:
    errors: np.ndarray[Any, Any] = found.relative_error[method]
    return float(errors.max())
