"""``flexura focus``: filters that move one rectangle of a panel alone, over temperature."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from app.commands.bad_input import bad_input
from app.commands.options import PATH, laws_of_twin, out_folder
from app.commands.output import Output, output_options

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from analysis.focusing.methods import MethodComparison
    from analysis.focusing.over_temperature import Aim, Focusing
    from analysis.focusing.panel import Panel

METHODS = ("stif", "time-reversal", "modal-control", "none")


EXAMPLES = """\b
Examples:
  flexura focus plate-run
  flexura focus plate-run --panel door.toml --temperature 20 --temperature 45
  flexura focus plate-run --twin plate-run/twin.toml
"""


@click.command(name="focus", epilog=EXAMPLES, short_help="Design focusing filters over temperature.")
@click.argument("run", type=PATH, required=False)
@click.option("--panel", type=PATH, help="Panel file (default: the paper's section 2).")
@click.option(
    "--temperature", "temperatures", type=float, multiple=True, help="°C; repeat for more (default: every 5 °C)."
)
@click.option(
    "--method", type=click.Choice(METHODS), default="stif", show_default=True, help="How filters are designed."
)
@click.option("--regularisation", type=click.Choice(("tikhonov", "truncation")), help="Default: the panel's.")
@click.option(
    "--tolerance", type=float, help="Share of the largest singular value, 1e-6 to 0.9 (default: the panel's)."
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
    twin: Path | None,
    out: Path | None,
    output: Output,
) -> None:
    """Design focusing filters for a panel whose plate obeys the laws of RUN.

    RUN is a run folder with laws.h5, or a laws file (default: the current folder). Six actuators, 512 taps each
    and the target rectangle stand in the panel's TOML file. Contrast (the energy over the target's share of the
    energy over the plate, eq. 9) and spot error (share of the plate's length) are judged with the FIR filters of
    each temperature and with those of 20 °C everywhere. Writes filters.h5.
    """
    import numpy as np

    from analysis.focusing.methods import compare
    from analysis.focusing.over_temperature import focus, spaced
    from app.files.filter_files import save_focusing
    from app.files.provenance import provenance, sha256
    from app.files.run_folder import run_folder
    from app.stages.panel_inputs import effects_left_out, laws_for, panel_of, range_of, within
    from app.stages.uncorrected_filters import uncorrected_aim, uncorrected_laws
    from app.twins.panel_twin import panel_twin

    started = time.perf_counter()
    declared, panel_path = panel_of(panel, {"regularisation": regularisation, "tolerance": tolerance})
    laws_path, laws, beside = laws_for(run, twin, "focus")
    laws = declared.plate.grown(laws)
    low, high = range_of(declared, laws, laws_path)
    wanted = (
        within(np.array(sorted(set(temperatures))), laws, laws_path) if temperatures else spaced(low, high, 5.0)
    )
    folder = run_folder(beside, out or beside)
    with output.progress() as report:
        model = panel_twin(declared, laws, report)
        focusing = focus(model, declared, laws, wanted, method, report)  # type: ignore[arg-type]
        without = None if twin is None else uncorrected_laws(beside, wanted, declared.plate)
        lost = uncorrected_aim(model, declared, laws, without, wanted, method)  # type: ignore[arg-type]
        plate = declared.illustration
        comparison = compare(model, declared, (plate.youngs_modulus, plate.poisson_ratio, plate.loss_factor))
    inputs = {laws_path.name: sha256(laws_path), panel_path.name: sha256(panel_path)}
    settings = {"method": method, "panel": declared.model_dump(mode="json"), "temperatures": wanted.tolist()}
    gone = replaced(folder / "filters.h5", wanted)
    save_focusing(folder / "filters.h5", declared, focusing, comparison, provenance(inputs, settings), lost)
    seconds = time.perf_counter() - started
    regained = {} if lost is None else {"with_uncorrected_laws": _means(lost)}
    output.result(lambda: record(focusing, comparison, seconds) | regained)
    left_out = effects_left_out(twin) if twin is not None else []
    for note in (*notes(declared, focusing), *left_out, *correction(focusing, lost), *gone):
        output.note(note)
    output.summary(summary(focusing, folder / "filters.h5", seconds))


def record(focusing: "Focusing", comparison: "MethodComparison", seconds: float) -> dict[str, Any]:
    """Return what ``--json`` prints: means over the band at every temperature."""
    energy = focusing.energy
    return {
        "method": focusing.method,
        "regularisation": focusing.regularisation,
        "tolerance": focusing.tolerance,
        "reference_temperature_c": focusing.reference_temperature,
        "contrast_definition": "eq. (9), literal",
        "spot_error_definition": "share of the plate's length Lx",
        "temperatures_c": focusing.temperature.tolist(),
        "without_compensation": _means(focusing.fixed),
        "direct": _means(focusing.direct),
        "uncut": _means(focusing.uncut),
        "fir": {
            "taps": focusing.bank.taps.shape[-1],
            "delay_samples": focusing.bank.delay,
            "energy_before_first_tap": float(energy.before.max()),
            "energy_inside_min": float(energy.inside.min()),
            "energy_after_last_tap": float(energy.after.max()),
            "pre_ringing": float(energy.pre_ringing.max()),
            "largest_tap_v": float(abs(focusing.bank.taps).max()),
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
    lost = 1.0 - float(focusing.energy.inside.min())
    if lost > 0.05:
        found.append(
            f"the taps lose up to {100 * lost:.1f} % of a filter's energy; more taps, another delay or a larger "
            "tolerance keep more"
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


def summary(focusing: "Focusing", target: Path, seconds: float) -> str:
    """Return one line for people."""
    t = focusing.temperature
    direct, fixed = focusing.direct.contrast.mean(axis=1), focusing.fixed.contrast.mean(axis=1)
    return (
        f"{_temperatures(t)}: contrast {direct.min():.2f} to {direct.max():.2f} with "
        f"their own filters, down to {fixed.min():.2f} with those of {focusing.reference_temperature:g} °C "
        f"({focusing.regularisation}, tolerance {focusing.tolerance:g}); {seconds:.1f} s; {target}"
    )


def _temperatures(t: "NDArray[np.float64]") -> str:
    return f"{t[0]:g} °C" if len(t) == 1 else f"{len(t)} temperatures, {t[0]:g} to {t[-1]:g} °C"


def _means(aim: "Aim") -> dict[str, list[float]]:
    return {
        "contrast": aim.contrast.mean(axis=1).tolist(),
        "spot_error": aim.spot_error.mean(axis=1).tolist(),
    }
