"""``flexura focus``: filters that move the target of a panel alone, over temperature."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import FOCUSING_METHODS, PATH, filter_options, laws_of_twin, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from analysis.focusing.methods import MethodComparison
    from analysis.focusing.over_temperature import Aim, Focusing
    from analysis.focusing.panel import Panel

WORST_LINE = 0.03
"""Contrast that taps may lose on the worst line before it is said."""

EXAMPLES = """\b
Examples:
  flexura focus plate-run
  flexura focus plate-run --panel door.toml --temperature 20 --temperature 45
  flexura focus plate-run --taps 128 --outside-weight 10
  flexura focus plate-run --design inverse-fft
  flexura focus plate-run --twin plate-run/twin.toml
  flexura focus --transfers scan.uff --panel scanned.toml --temperature 21.5 --out scan-run
"""


@click.command(name="focus", epilog=EXAMPLES, short_help="Design focusing filters over temperature.")
@click.argument("run", type=PATH, required=False)
@click.option("--panel", type=PATH, help="Panel file (default: the paper's section 2).")
@click.option(
    "--temperature", "temperatures", type=float, multiple=True, help="°C; repeat for more (default: every 5 °C)."
)
@click.option(
    "--method",
    type=click.Choice(FOCUSING_METHODS),
    default="stif",
    show_default=True,
    help="How filters are designed.",
)
@click.option("--regularisation", type=click.Choice(("tikhonov", "truncation")), help="Default: the panel's.")
@click.option(
    "--tolerance", type=float, help="Share of the largest singular value, 1e-6 to 0.9 (default: the panel's)."
)
@filter_options
@click.option(
    "--transfers",
    type=PATH,
    help="Measured transfers (UFF58 with nodes, or HDF5) in place of RUN's laws and the panel's twin.",
)
@laws_of_twin
@out_folder("Folder for filters.h5 (default: beside the laws).")
@output_options("the figures")
@bad_input
def command(
    run: Path | None,
    panel: Path | None,
    temperatures: tuple[float, ...],
    method: str,
    regularisation: str | None,
    tolerance: float | None,
    filters: dict[str, Any],
    transfers: Path | None,
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Design focusing filters for a panel whose plate obeys the laws of RUN.

    RUN is a run folder with laws.h5, or a laws file (default: the current folder). Actuators, taps and target
    stand in the panel's TOML file. The taps are those whose field comes nearest to the one wanted, errors outside
    the target counting more. Judged by contrast (the energy over the target's share of the energy over the plate,
    eq. 9, mean and worst line), the same normalised by area, level and phase over the band, latency and peak
    drive, with the filters of each temperature and with those of 20 °C everywhere. Writes filters.h5.
    """
    changes = {"regularisation": regularisation, "tolerance": tolerance} | filters
    if transfers is not None:
        if run is not None or twin is not None:
            raise click.UsageError(
                "--transfers takes the place of RUN and of --twin; name results' folder by --out"
            )
        _focus_measured(transfers, panel, temperatures, method, changes, out, output)
        return
    import numpy as np

    from analysis.focusing.over_temperature import spaced
    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.stages import focus
    from app.stages.panel_inputs import effects_left_out, laws_for, panel_of, range_of, within
    from app.stages.uncorrected_filters import uncorrected_laws

    started = time.perf_counter()
    declared, panel_path = panel_of(panel, changes)
    laws_path, laws, beside = laws_for(run, twin, "focus")
    low, high = range_of(declared, laws, laws_path)
    wanted = (
        within(np.array(sorted(set(temperatures))), laws, laws_path)
        if temperatures
        else spaced(low, high, focus.SPACING)
    )
    folder = run_folder(beside, out or beside)
    without = None if twin is None else uncorrected_laws(beside, wanted)
    with output.progress() as report:
        found = focus.compute(
            declared,
            laws,
            report,
            temperature=wanted,
            method=method,  # type: ignore[arg-type]
            uncorrected=without,
        )
    focusing, lost = found.focusing, found.uncorrected
    gone = replaced(folder / focus.FILTERS, wanted)
    target = focus.save(folder, found, {path.name: sha256(path) for path in (laws_path, panel_path)})
    seconds = time.perf_counter() - started
    regained = {} if lost is None else {"with_uncorrected_laws": _means(lost, focusing.target_share)}
    output.result(
        lambda: record(declared, focusing, found.comparison, seconds) | regained,
        lambda: show(declared, focusing),
    )
    left_out = effects_left_out(twin) if twin is not None else []
    for note in (*notes(declared, focusing), *left_out, *correction(focusing, lost), *gone):
        output.note(note)
    output.summary(summary(focusing, target, seconds))


def _focus_measured(
    transfers: Path,
    panel: Path | None,
    temperatures: tuple[float, ...],
    method: str,
    changes: dict[str, Any],
    out: Path | None,
    output: Output,
) -> None:
    """Design filters from measured transfers alone."""
    from app.files.provenance import sha256
    from app.files.run_folder import run_folder
    from app.stages import focus
    from app.stages.panel_inputs import measured_panel, panel_of

    started = time.perf_counter()
    declared, panel_path = panel_of(panel, changes)
    if method == "modal-control":
        raise click.UsageError("--method modal-control needs the modes of a model; --transfers has none")
    measured = measured_panel(declared, transfers, temperatures)
    folder = run_folder(transfers.parent, out or transfers.parent)
    with output.progress() as report:
        found = focus.compute_measured(measured, report, method=method)  # type: ignore[arg-type]
    focusing = found.focusing
    gone = replaced(folder / focus.FILTERS, focusing.temperature)
    target = focus.save(folder, found, {path.name: sha256(path) for path in (transfers, panel_path)})
    seconds = time.perf_counter() - started
    output.result(lambda: record(declared, focusing, found.comparison, seconds), lambda: show(declared, focusing))
    for note in (*notes(declared, focusing), *gone):
        output.note(note)
    output.summary(summary(focusing, target, seconds))


def record(panel: "Panel", focusing: "Focusing", comparison: "MethodComparison", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints: figures over the band at every temperature.

    Parameters
    ----------
    panel : Panel
    focusing : Focusing
    comparison : MethodComparison
    seconds : float
        It took, s.

    Returns
    -------
    dict
        Of values that JSON holds; temperatures in degrees Celsius.
    """
    from analysis.focusing.design import peak_drive

    energy, share = focusing.energy, focusing.target_share
    return {
        "method": focusing.method,
        "regularisation": focusing.regularisation,
        "tolerance": focusing.tolerance,
        "reference_temperature_c": focusing.reference_temperature,
        "design": panel.filters.design,
        "outside_weight": panel.filters.kappa,
        "latency_ms": 1e3 * focusing.bank.delay / focusing.bank.sample_rate,
        "contrast_definition": "eq. (9), literal; area-normalised: d/(d + o) of mean energy densities",
        "spot_error_definition": "share of the plate's length Lx",
        "temperatures_c": focusing.temperature.tolist(),
        "without_compensation": _means(focusing.fixed, share),
        "direct": _means(focusing.direct, share),
        "uncut": _means(focusing.uncut, share),
        "fir": {
            "taps": focusing.bank.taps.shape[-1],
            "delay_samples": focusing.bank.delay,
            "energy_before_first_tap": float(energy.before.max()),
            "energy_inside_min": float(energy.inside.min()),
            "energy_after_last_tap": float(energy.after.max()),
            "pre_ringing": float(energy.pre_ringing.max()),
            "peak_drive": peak_drive(focusing.bank.taps).max(axis=1).tolist(),
            "drive_limit": [float(x) if x < float("inf") else None for x in panel.limits],
        },
        "rank_changes": focusing.rank_changes.tolist(),
        "comparison": {
            method: {"contrast": float(c.mean()), "spot_error": float(s.mean())}
            for method, c, s in zip(comparison.methods, comparison.contrast, comparison.spot_error, strict=True)
        },
        "seconds": seconds,
    }


def notes(panel: "Panel", focusing: "Focusing") -> list[str]:
    """Return what a user has to know before trusting the filters."""
    from analysis.focusing.design import peak_drive

    found = []
    wanted = panel.filters.reference_temperature
    if focusing.reference_temperature != wanted:
        found.append(
            f"the laws do not reach {wanted:g} °C: the filter kept without compensation is that of "
            f"{focusing.reference_temperature:g} °C"
        )
    changes = focusing.rank_changes
    if focusing.regularisation == "truncation" and changes.any():
        worst = int(changes.argmax())
        found.append(
            f"truncation at {focusing.tolerance:g}: the rank changes on {int(changes.max())} lines between "
            f"{focusing.temperature[worst]:g} and {focusing.temperature[worst + 1]:g} °C; the filters jump there "
            "and cannot be interpolated well (tikhonov does not jump)"
        )
    drop = focusing.uncut.contrast.min(axis=1) - focusing.direct.contrast.min(axis=1)
    if drop.max() > WORST_LINE:
        worst = int(drop.argmax())
        found.append(
            f"the taps lose {drop[worst]:.2f} of contrast on the worst line at "
            f"{focusing.temperature[worst]:g} °C; more taps, another delay, or --design field keep more"
        )
    limits, peak = panel.limits, peak_drive(focusing.bank.taps)
    if (peak >= 0.999 * limits).any():
        actuator = int((peak / limits).max(axis=0).argmax())
        found.append(
            f"actuator {actuator + 1} is held at its limit of {limits[actuator]:g} V (rated field times "
            "thickness): level or contrast is lost; ask for less displacement, or declare the patch's rated_field"
        )
    return found


def replaced(target: Path, temperature: "NDArray[np.float64]") -> list[str]:
    """Say which filters the new ones, of `temperature` (T,), °C, take the place of, where that is a loss."""
    from app.files.bad_file import ResultFileError
    from app.files.filter_files import load_focusing

    if not target.is_file():
        return []
    try:
        before = load_focusing(target)[1].temperature
    except ResultFileError:  # of no use to anybody
        return []
    if before.tolist() == temperature.tolist():
        return []
    return [f"{target} held filters of {_temperatures(before)}: replaced. To keep both, name --out FOLDER"]


def correction(focusing: "Focusing", lost: "Aim | None") -> list[str]:
    """Say what the twin's effects are worth for the filters, where that was tried."""
    if lost is None:
        return []
    own, without = focusing.direct.contrast.mean(axis=1), lost.contrast.mean(axis=1)
    worst = int((own - without).argmax())
    return [
        f"filters from the uncorrected laws.h5 reach contrast {without.min():.3f} to {without.max():.3f} here; "
        f"the correction is worth up to {own[worst] - without[worst]:.3f}, at {focusing.temperature[worst]:g} °C"
    ]


def show(panel: "Panel", focusing: "Focusing") -> None:
    """Print a table of the temperatures for people."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    from analysis.focusing.design import peak_drive
    from analysis.focusing.performance import area_normalised

    latency = 1e3 * focusing.bank.delay / focusing.bank.sample_rate
    unit = "V" if panel.patch else "N"
    table = Table(
        title=f"{focusing.method}, {panel.filters.design}: {focusing.bank.taps.shape[2]} taps, {latency:.1f} ms",
        caption="contrast: mean and worst line, with taps and uncut; area: normalised by area\n"
        "dB of the displacement asked for, ripple in dB, phase in degrees; peak: any audio within ±1",
        header_style="bold",
        box=SIMPLE_HEAD,
        padding=(0, 1, 0, 0),
    )
    headings = ("°C", "mean", "worst", "uncut", "worst", "area", "dB", "ripple", "phase", f"peak {unit}")
    for heading in (*headings, f"{focusing.reference_temperature:g} °C's", "worst"):
        table.add_column(heading, justify="right")
    direct, drive = focusing.direct, peak_drive(focusing.bank.taps)
    normalised = area_normalised(direct.contrast, focusing.target_share)
    for t, temperature in enumerate(focusing.temperature):
        table.add_row(
            f"{temperature:g}",
            *_both(direct.contrast[t]),
            *_both(focusing.uncut.contrast[t]),
            _both(normalised[t])[0],
            f"{direct.level[t].mean():.1f}",
            f"{direct.level_ripple[t]:.1f}",
            f"{direct.phase_error[t]:.1f}",
            f"{drive[t].max():.3g}",
            *_both(focusing.fixed.contrast[t]),
        )
    Console().print(table)


def summary(focusing: "Focusing", target: Path, seconds: float) -> str:
    """Return one line for people.

    Parameters
    ----------
    focusing : Focusing
    target : Path
        File it was written to.
    seconds : float
        It took, s.

    Returns
    -------
    str
    """
    t = focusing.temperature
    direct, fixed = focusing.direct.contrast.mean(axis=1), focusing.fixed.contrast.mean(axis=1)
    return (
        f"{_temperatures(t)}: contrast {direct.min():.2f} to {direct.max():.2f} with "
        f"their own filters, worst line {focusing.direct.contrast.min():.2f}; down to {fixed.min():.2f} with "
        f"those of {focusing.reference_temperature:g} °C ({focusing.regularisation}, tolerance "
        f"{focusing.tolerance:g}); {seconds:.1f} s; {target}"
    )


def _both(line: "NDArray[np.float64]") -> tuple[str, str]:
    """Mean and worst of a figure over the band."""
    return f"{line.mean():.3f}", f"{line.min():.3f}"


def _temperatures(t: "NDArray[np.float64]") -> str:
    return f"{t[0]:g} °C" if len(t) == 1 else f"{len(t)} temperatures, {t[0]:g} to {t[-1]:g} °C"


def _means(aim: "Aim", target_share: float) -> dict[str, list[float]]:
    from analysis.focusing.performance import area_normalised

    normalised = area_normalised(aim.contrast, target_share)
    return {
        "contrast": aim.contrast.mean(axis=1).tolist(),
        "contrast_worst_line": aim.contrast.min(axis=1).tolist(),
        "contrast_area_normalised": normalised.mean(axis=1).tolist(),
        "level_db": aim.level.mean(axis=1).tolist(),
        "level_ripple_db": aim.level_ripple.tolist(),
        "phase_error_deg": aim.phase_error.tolist(),
        "spot_error": aim.spot_error.mean(axis=1).tolist(),
    }
