"""``flexura identify``: poles and residues of a campaign or of FRFs in a universal file."""

import json
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.progress import progress

if TYPE_CHECKING:
    from analysis.identification.automatic import Settings
    from analysis.identification.modes import Modes
    from analysis.identification.reading import Damping
    from analysis.identification.tracked_modes import TrackedModes

FIELDS = (
    "frequency_hz",
    "sigma_frequency_hz",
    "damping_ratio",
    "sigma_damping_ratio",
    "loss_factor",
    "sigma_loss_factor",
)


@click.command(name="identify")
@click.argument("campaign", metavar="CAMPAIGN|FRFS.uff", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Run folder (default: NAME-run beside CAMPAIGN).")
@click.option(
    "--damping",
    type=click.Choice(["hysteretic", "viscous"]),
    default="hysteretic",
    show_default=True,
    help="How a pole is read: sqrt(Re k) and Im k / Re k with k = -pole^2, or |pole| and twice the damping ratio.",
)
@click.option("--mains", type=float, default=50.0, show_default=True, help="Mains frequency, Hz.")
@click.option("--json", "as_json", is_flag=True, help="Print the modes as JSON.")
@bad_input
def command(campaign: Path, out: Path | None, damping: "Damping", mains: float, as_json: bool) -> None:
    """Find the modes in CAMPAIGN's FRFs, follow them over temperature; or those of FRFS.uff, FRF by FRF.

    No order, no band and no start value is asked for: vector fitting proposes, variable projection moves the
    poles to the least-squares optimum, BIC decides how many stay, and every mode carries its standard deviations
    and the reason for its status. A campaign's result goes into the run folder (frf.h5, modes.h5, modes.csv).
    """
    from analysis.identification.automatic import Settings

    settings = Settings(mains=mains)
    if campaign.suffix.lower() in (".uff", ".unv", ".uf"):
        identify_uff(campaign, settings, damping, as_json)
    else:
        identify_campaign(campaign, out, settings, damping, as_json)


def identify_campaign(
    campaign: Path, out: Path | None, settings: "Settings", damping: "Damping", as_json: bool
) -> None:
    """Identify and track a campaign; write frf.h5, modes.h5 and modes.csv."""
    from analysis.frf import campaign_frf
    from analysis.identification.tracking import track
    from app.files.campaign import load_campaign
    from app.files.frf_file import save_frf
    from app.files.modes_file import save_modes, write_table
    from app.files.provenance import provenance
    from app.files.run_folder import run_folder

    started = time.perf_counter()
    loaded = load_campaign(campaign)
    run = run_folder(campaign, out)
    with progress() as report:
        frf = campaign_frf(loaded, mains=settings.mains or 50.0)
        tracked = track(frf, settings, report)
    chosen = {"campaign": loaded.name, "mains": settings.mains, "damping": damping}
    made_from = provenance(loaded.hashes, chosen)
    save_frf(run / "frf.h5", loaded.experiment, frf, made_from)
    save_modes(run / "modes.h5", tracked, made_from)
    write_table(run / "modes.csv", tracked, damping)
    seconds = time.perf_counter() - started
    if as_json:
        click.echo(json.dumps(campaign_record(tracked, damping, seconds), indent=1, allow_nan=False))
    else:
        show(tracked, damping)
    for note in (*frf.notes, *tracked.notes):
        click.echo(f"note: {note}", err=True)
    counts = [int(modes.real.sum()) for modes in tracked.modes]
    click.echo(
        f"{len(counts)} sweeps, {min(counts)} to {max(counts)} modes each in {seconds:.1f} s, misfit at most "
        f"{100 * tracked.misfit.max():.2f} %; results in {run}",
        err=True,
    )


def identify_uff(path: Path, settings: "Settings", damping: "Damping", as_json: bool) -> None:
    """Identify every FRF of a universal file on its own and print its modes."""
    from analysis.identification.automatic import Measured, identify
    from analysis.identification.residual_terms import choices_for
    from app.files.bad_file import ResultFileError
    from app.files.uff58 import read_frfs

    started = time.perf_counter()
    frfs = read_frfs(path)
    records: list[dict[str, Any]] = []
    with progress() as report:
        for done, frf in enumerate(frfs):
            report("identify", done / len(frfs))
            try:
                terms = choices_for(frf.quantity)
                modes = identify(Measured(frf.frequency, frf.h[None]), replace(settings, terms=terms))
            except ValueError as error:
                raise ResultFileError(f"{path}: {frf.name}: {error}") from error
            records.append({"name": frf.name, "response": frf.response, "reference": frf.reference})
            records[-1] |= modes_record(modes, damping)
        report("identify", 1.0)
    seconds = time.perf_counter() - started
    if as_json:
        click.echo(json.dumps({"frfs": records, "seconds": seconds}, indent=1, allow_nan=False))
    else:
        for record in records:
            show_modes(str(record["name"]), record["modes"])
    found = sum(len(record["modes"]) for record in records)
    click.echo(f"{len(records)} FRFs, {found} modes in {seconds:.1f} s", err=True)


def modes_record(modes: "Modes", damping: "Damping") -> dict[str, Any]:
    """Return what ``--json`` prints of one identification: modes of the plate, and poles that are none."""
    reading = modes.reading(damping)
    found: list[dict[str, Any]] = []
    rejected: list[dict[str, Any]] = []
    for j, (status, reason) in enumerate(zip(modes.status, modes.reason, strict=True)):
        values: dict[str, Any] = {name: float(getattr(reading, name)[j]) for name in FIELDS}
        values["pole_rad_s"] = [float(modes.poles[j].real), float(modes.poles[j].imag)]
        (found if modes.real[j] else rejected).append(values | {"status": status, "reason": reason})
    for pole in modes.rejected:
        place = {"frequency_hz": abs(pole.pole) / (2.0 * math.pi)}
        rejected.append(place | {"status": "computational", "reason": pole.reason})
    return {
        "residual_terms": modes.terms.name,
        "misfit": modes.misfit,
        "modes": found,
        "rejected": rejected,
    }


def campaign_record(tracked: "TrackedModes", damping: "Damping", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints of a campaign: the same per sweep, each mode with the number of its track."""
    sweeps = []
    for t, modes in enumerate(tracked.modes):
        record = modes_record(modes, damping)
        numbers = {int(n): j + 1 for j, n in enumerate(tracked.track[t]) if n >= 0}
        real = [n for n in range(len(modes.poles)) if modes.real[n]]
        for n, mode in zip(real, record["modes"], strict=True):
            mode["track"] = numbers.get(n)
        place = {"temperature_c": float(tracked.temperature[t]), "direction": tracked.direction[t]}
        sweeps.append(place | {"level_v": float(tracked.level[t])} | record)
    return {"temperatures": sweeps, "notes": list(tracked.notes), "seconds": seconds}


def show(tracked: "TrackedModes", damping: "Damping") -> None:
    """Print the modes of the coldest, a middle and the hottest sweep; modes.csv holds them all."""
    import numpy as np

    order = np.argsort(tracked.temperature, kind="stable")
    for t in sorted({int(order[0]), int(order[len(order) // 2]), int(order[-1])}):
        show_modes(f"{tracked.temperature[t]:.2f} °C", modes_record(tracked.modes[t], damping)["modes"])


def show_modes(title: str, modes: Sequence[dict[str, Any]]) -> None:
    """Print modes as a table for people."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title, header_style="bold")
    for heading in ("f [Hz]", "σ_f [Hz]", "ζ [%]", "σ_ζ [%]", "η [%]", "status"):
        table.add_column(heading, justify="left" if heading == "status" else "right")
    for mode in modes:
        table.add_row(
            f"{mode['frequency_hz']:.3f}",
            f"{mode['sigma_frequency_hz']:.3f}",
            f"{100 * mode['damping_ratio']:.3f}",
            f"{100 * mode['sigma_damping_ratio']:.3f}",
            f"{100 * mode['loss_factor']:.3f}",
            mode["status"] if mode["status"] == "kept" else f"{mode['status']}: {mode['reason']}",
        )
    Console().print(table)
