"""``flexura update``: E, nu and eta of the plate at every temperature, and the laws through them."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, effects_of_twin, mains, own_effects, run_out
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    from analysis.material import MaterialLaws
    from analysis.updated import Updated


EXAMPLES = """\b
Examples:
  flexura update plate --out plate-run
  flexura update plate --twin plate-run/twin.toml --out plate-run
"""


@click.command(name="update", epilog=EXAMPLES, short_help="Find E, nu and eta at every temperature.")
@click.argument("campaign", type=PATH)
@effects_of_twin
@own_effects
@run_out
@mains
@output_options("the estimates")
@bad_input
def command(
    campaign: Path, twin: Path | None, effects: Path | None, out: Path | None, mains: float, output: Output
) -> None:
    """Update the twin of CAMPAIGN: E, nu and eta per temperature, one gain, and smooth laws.

    Fits the finite-element twin of the declared plate, patches and electronics to the measured FRFs, each line
    weighted by its variance. With --twin the effects in that file are on with the values they have there, and the
    laws are those of the plate under them. Writes frf.h5 and laws.h5 into the run folder. Exit status 1 where a
    temperature's fit did not settle inside the twin's certified range.
    """
    from app.files.campaign import load_campaign
    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.stages.update import save_updating, updated_twin, updated_under_effects
    from app.twins.campaign_model import start_of

    started = time.perf_counter()
    loaded = load_campaign(campaign)
    start = start_of(twin, loaded.experiment, effects)
    run = run_folder(campaign, out)
    settings: dict[str, Any] = {"mains": mains}
    with output.progress() as report:
        if start is None:
            found = updated_twin(loaded, mains, report)
        else:
            found = updated_under_effects(loaded, mains, start, effects, report)
            settings |= {"twin": sha256(start.path), "effects": start.twin.effects}
    replaced = other_effects(run / "laws.h5", settings.get("effects", {}))
    save_updating(run, loaded, found, settings)
    updated, seconds = found.updated, time.perf_counter() - started
    output.result(lambda: record(updated, seconds), lambda: show(updated))
    for note in (*found.frf.notes, *notes(updated, found.laws)):
        output.note(note)
    if start is not None:
        on = ", ".join(start.twin.effects) or "no effect"
        output.note(f"{start.path}: {on} switched on; the laws in {run / 'laws.h5'} are those under it")
    if replaced is not None:
        output.note(
            f"{run / 'laws.h5'} held the laws {replaced}; they are replaced. To keep both: --out ANOTHER-FOLDER"
        )
    output.summary(summary(updated, run, seconds, loaded.experiment.inputs[0].gain_unit))
    if not updated.settled.all():
        raise click.exceptions.Exit(1)


def other_effects(laws: Path, effects: dict[str, Any]) -> str | None:
    """Under which effects the laws in a file stand that are about to be replaced; None if under these, or none."""
    from app.files.bad_file import ResultFileError
    from app.files.laws_file import effects_in_laws

    try:
        before = effects_in_laws(laws) if laws.is_file() else effects
    except ResultFileError:
        return None
    if before == effects:
        return None
    return f"under {', '.join(before)}" if before else "without effects"


def record(updated: "Updated", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints: SI units, one entry per sweep in the order recorded."""
    from app.stages.update import constants

    rows = []
    for t, (e, nu, eta) in enumerate(constants(updated)):
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

    from app.stages.update import constants

    caption = "σ: what a sweep's own noise leaves open; scatter between sweeps is in the laws' σ (report, laws.h5)"
    table = Table(
        title="Updated twin", caption=caption, header_style="bold", box=SIMPLE_HEAD, padding=(0, 1, 0, 0)
    )
    for heading in ("T [°C]", "E [GPa]", "σ_E [%]", "ν", "σ_ν", "η [%]", "σ_η [%]", "misfit", "noise"):
        table.add_column(heading, justify="right", no_wrap=True)
    sigma = updated.sigma
    for t, (e, nu, eta) in enumerate(constants(updated)):
        table.add_row(
            f"{updated.temperature[t]:.2f}{'' if updated.settled[t] else ' ?'}",
            f"{e / 1e9:.4f}",
            f"{100 * sigma.youngs_modulus[t] / e:.4f}",
            f"{nu:.4f}",
            f"{sigma.poisson_ratio[t]:.5f}",
            f"{100 * eta:.3f}",
            f"{100 * sigma.loss_factor[t]:.4f}",
            f"{100 * updated.misfit[t]:.2f} %",
            f"{100 * updated.noise_floor[t]:.2f} %",
        )
    Console().print(table)


def summary(updated: "Updated", run: Path, seconds: float, unit: str) -> str:
    """Return one line for people."""
    ratio = float((updated.misfit / updated.noise_floor).max())
    return (
        f"{len(updated.temperature)} sweeps updated in {seconds:.1f} s, gain {updated.gain:.3f} {unit}, "
        f"misfit at most {ratio:.2f} times the noise; results in {run}"
    )


def notes(updated: "Updated", laws: "MaterialLaws | None") -> list[str]:
    """Say what has to be known before the estimates are trusted."""
    from app.stages.update import GOOD_MISFIT

    said = []
    unsettled = int((~updated.settled).sum())
    if unsettled:
        said.append(
            f"{unsettled} of {len(updated.settled)} sweeps (marked ?) did not settle inside the twin's certified "
            "range: their values are no estimates. Is the declaration right: mass, thickness, positions, which "
            "channel is which?"
        )
    elif (updated.misfit / updated.noise_floor).max() > GOOD_MISFIT:
        said.append(
            "the twin lacks something the plate has: E, nu and eta above absorb part of it. What: flexura gap"
        )
    if laws is None:
        said.append("no laws over temperature: at least 3 temperatures with settled estimates are needed")
    return said
