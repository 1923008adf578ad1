"""``flexura update``: E, nu and eta of the plate at every temperature, and the laws through them."""

import json
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.progress import Report, progress

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from analysis.campaign import Campaign
    from analysis.frf import Frf
    from analysis.material import Material, MaterialLaws
    from analysis.updating.update import Updated
    from simulation.twin import Twin

GOOD_MISFIT = 1.3
"""A twin that misses no more than this many times the noise explains the data."""


@click.command(name="update")
@click.argument("campaign", type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path), help="Run folder (default: NAME-run beside CAMPAIGN).")
@click.option(
    "--mains", type=float, default=50.0, show_default=True, help="Mains frequency, Hz, for lines left out."
)
@click.option("--json", "as_json", is_flag=True, help="Print the estimates as JSON.")
@bad_input
def command(campaign: Path, out: Path | None, mains: float, as_json: bool) -> None:
    """Update the twin of CAMPAIGN: E, nu and eta per temperature, one gain, and smooth laws.

    Fits the finite-element twin of the declared plate, patches and electronics to the measured FRFs, each line
    weighted by its variance. Writes frf.h5 and laws.h5 into the run folder. Exit status 1 where a temperature's
    fit did not settle inside the twin's certified range.
    """
    from analysis.frf import campaign_frf
    from app.files.campaign import load_campaign
    from app.files.run_folder import run_folder

    started = time.perf_counter()
    loaded = load_campaign(campaign)
    run = run_folder(campaign, out)
    with progress() as report:
        frf = campaign_frf(loaded, mains=mains)
        twin, updated, laws = update_twin(loaded, frf, report)
    save(run, loaded, frf, twin, updated, laws, {"mains": mains})
    seconds = time.perf_counter() - started
    if as_json:
        click.echo(json.dumps(record(updated, seconds), indent=1, allow_nan=False))
    else:
        show(updated)
    for note in frf.notes:
        click.echo(f"note: {note}", err=True)
    click.echo(summary(updated, laws, run, seconds), err=True)
    if not updated.settled.all():
        raise click.exceptions.Exit(1)


def update_twin(campaign: "Campaign", frf: "Frf", report: Report) -> "tuple[Twin, Updated, MaterialLaws | None]":
    """Build the campaign's twin, fit it, and draw laws through the estimates where there are enough."""
    from analysis.updating.laws import fit_laws
    from analysis.updating.update import update
    from app.twin import campaign_twin

    twin = campaign_twin(campaign.experiment, report)
    updated = update(frf, twin, progress=report)
    good = updated.settled
    temperature = updated.temperature[good]
    if temperature.size < 3 or (temperature.max() - temperature.min()) < 1.0:
        return twin, updated, None
    nominal = campaign.experiment.protocol.temperatures
    span = (
        min((t for t in nominal if t > temperature.min() - 0.5), default=float(temperature.min())),
        max((t for t in nominal if t < temperature.max() + 0.5), default=float(temperature.max())),
    )
    laws = fit_laws(temperature, _rows(updated.material, good), _rows(updated.sigma, good), temperature_range=span)
    return twin, updated, laws


def save(
    run: Path,
    campaign: "Campaign",
    frf: "Frf",
    twin: "Twin",
    updated: "Updated",
    laws: "MaterialLaws | None",
    settings: dict[str, Any],
) -> None:
    """Write the measured FRFs, the estimates, the laws and the twin's FRFs."""
    import numpy as np

    from app.files.frf_file import save_frf
    from app.files.laws_file import TwinFrf, save_laws
    from app.files.provenance import provenance

    made_from = provenance(campaign.hashes, {**settings, "campaign": campaign.name})
    answers = [updated.gain * twin.frf(*row, frf.frequency) for row in _constants(updated)]
    plate = campaign.experiment.plate
    save_frf(run / "frf.h5", campaign.experiment, frf, made_from)
    save_laws(
        run / "laws.h5",
        updated,
        laws,
        TwinFrf(frf.frequency, np.array(answers), twin.error, plate.density),
        made_from,
    )


def record(updated: "Updated", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints: SI units, one entry per sweep in the order recorded."""
    rows = []
    for t, (e, nu, eta) in enumerate(_constants(updated)):
        rows.append(
            {
                "temperature_c": float(updated.temperature[t]),
                "youngs_modulus_pa": e,
                "poisson_ratio": nu,
                "loss_factor": eta,
                "sigma": {
                    "youngs_modulus_pa": float(updated.sigma.youngs_modulus[t]),
                    "poisson_ratio": float(updated.sigma.poisson_ratio[t]),
                    "loss_factor": float(updated.sigma.loss_factor[t]),
                },
                "misfit": float(updated.misfit[t]),
                "misfit_start": float(updated.misfit_start[t]),
                "noise_floor": float(updated.noise_floor[t]),
                "chi2_per_dof": float(updated.chi2_per_dof[t]),
                "settled": bool(updated.settled[t]),
            }
        )
    return {
        "temperatures": rows,
        "gain": updated.gain,
        "sigma_gain": updated.sigma_gain,
        "seconds": seconds,
    }


def show(updated: "Updated") -> None:
    """Print the estimates as a table for people."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    table = Table(title="Updated twin", header_style="bold", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for heading in ("T [°C]", "E [GPa]", "σ_E [%]", "ν", "σ_ν", "η [%]", "σ_η [%]", "misfit", "noise", ""):
        table.add_column(heading, justify="right", no_wrap=True)
    sigma = updated.sigma
    for t, (e, nu, eta) in enumerate(_constants(updated)):
        table.add_row(
            f"{updated.temperature[t]:.2f}",
            f"{e / 1e9:.4f}",
            f"{100 * sigma.youngs_modulus[t] / e:.4f}",
            f"{nu:.4f}",
            f"{sigma.poisson_ratio[t]:.5f}",
            f"{100 * eta:.3f}",
            f"{100 * sigma.loss_factor[t]:.4f}",
            f"{100 * updated.misfit[t]:.2f} %",
            f"{100 * updated.noise_floor[t]:.2f} %",
            "" if updated.settled[t] else "not settled",
        )
    Console().print(table)


def summary(updated: "Updated", laws: "MaterialLaws | None", run: Path, seconds: float) -> str:
    """Return one line for people, and what to make of a twin that misses more than the noise."""
    ratio = float((updated.misfit / updated.noise_floor).max())
    line = (
        f"{len(updated.temperature)} sweeps updated in {seconds:.1f} s, gain {updated.gain:.3f} V/V, "
        f"misfit at most {ratio:.2f} times the noise; results in {run}"
    )
    unsettled = int((~updated.settled).sum())
    if unsettled:
        line += (
            f"\n{unsettled} sweeps did not settle inside the twin's certified range: their values are no estimates"
        )
    if ratio > GOOD_MISFIT:
        line += "\nthe twin lacks something the plate has: E, nu and eta above absorb part of it"
    if laws is None:
        line += "\nno laws over temperature: at least 3 different temperatures are needed"
    return line


def _constants(updated: "Updated") -> list[tuple[float, float, float]]:
    """E, nu and eta of every sweep."""
    m = updated.material
    return [
        (float(e), float(nu), float(eta))
        for e, nu, eta in zip(m.youngs_modulus, m.poisson_ratio, m.loss_factor, strict=True)
    ]


def _rows(material: "Material", chosen: "NDArray[np.bool_]") -> "Material":
    """Return the chosen rows of estimates or of their standard deviations."""
    from analysis.material import Material

    return Material(material.youngs_modulus[chosen], material.poisson_ratio[chosen], material.loss_factor[chosen])
