"""One line a stage: what a run found, and what its corrected twin is worth."""

from collections.abc import Callable
from pathlib import Path

from analysis.compensation.outcome import NETWORK
from analysis.updated import Updated
from app.files.results.best_twin import best_twin, load_gap_record
from app.files.results.compensation_file import load_compensation
from app.files.results.filter_files import load_focusing, load_uncorrected
from app.files.results.frf_file import load_frf
from app.files.results.modes_file import load_modes
from app.summaries.briefing import Worth
from app.summaries.gap import chi2_before_and_after, concluded, found_words, titles_of
from app.summaries.numbers import span, sweeps
from app.summaries.sheet import sheet_words


def summary(run: Path) -> dict[str, str]:
    """Return a line for each verb whose result is in `run`; E, ν and η are those of its best twin."""
    makers: dict[str, tuple[str, Callable[[Path], str]]] = {
        "import": ("frf.h5", _measured),
        "identify": ("modes.h5", _identified),
        "update": ("laws.h5", _updated),
        "gap": ("gap.h5", _compared),
        "focus": ("filters.h5", _focused),
        "compensate": ("compensation.h5", _compensated),
    }
    return {verb: make(run / name) for verb, (name, make) in makers.items() if (run / name).is_file()}


def _measured(path: Path) -> str:
    experiment, frf = load_frf(path)
    t = frf.temperature
    return f"{experiment.title}: {sweeps(len(t))}, {span(t, 'z.0f')} °C, {len(frf.channels)} sensor(s)"


def _identified(path: Path) -> str:
    tracked = load_modes(path)
    counts = [int(modes.real.sum()) for modes in tracked.modes]
    return f"{span(counts, '.0f')} modes a temperature, misfit at most {100 * tracked.misfit.max():.2f} %"


def _updated(path: Path) -> str:
    best = best_twin(path.parent, "report")
    said = _constants(best.twin.updated)
    if best.effects:
        said += f"; corrected ({best.names})"
    if best.uncorrected is not None:
        said += f"; uncorrected {_constants(best.uncorrected.updated)}"
    return said


def _constants(found: Updated) -> str:
    e, nu, eta = (
        found.material.youngs_modulus / 1e9,
        found.material.poisson_ratio,
        100 * found.material.loss_factor,
    )
    ratio = float((found.misfit / found.noise_floor).max())
    if found.sheet is not None:
        return f"{sheet_words(found.sheet)}, misfit at most {ratio:.2f} times the noise"
    return (
        f"E {_span(e.max(), e.min(), '.2f')} GPa, ν {_span(nu.min(), nu.max(), '.3f')}, "
        f"η {_span(eta.min(), eta.max(), '.1f')} %, misfit at most {ratio:.2f} times the noise"
    )


def _span(first: float, last: float, digits: str) -> str:
    """Return both ends, or one value where they do not differ in these digits."""
    ends = (format(first, digits), format(last, digits))
    return " to ".join(dict.fromkeys(ends))


def _compared(path: Path) -> str:
    record = load_gap_record(path)
    words = concluded(record)
    if record["effects"] and record["verdict"] != "unknown":
        titles = titles_of(record)
        words += ": " + "; ".join(found_words(effect, titles) for effect in record["effects"])
    return f"{words}; chi2 per degree of freedom {' to '.join(chi2_before_and_after(record))}"


def _focused(path: Path) -> str:
    _, found, _ = load_focusing(path)
    own, fixed = found.direct.contrast.mean(1), found.fixed.contrast.mean(1)
    line = f"mean contrast {own.min():.2f} to {own.max():.2f}"
    return f"{line}; with the filters of {found.reference_temperature:g} °C down to {fixed.min():.2f}"


def _compensated(path: Path) -> str:
    _, found = load_compensation(path)
    place = found.methods.index(NETWORK)
    error, loss = found.relative_error[place].max(), found.largest_loss[place]
    return (
        f"the networks lose at most {loss:.2g} of contrast, relative error at most {error:.1g} % of energy; "
        f"loses least: {found.best}, recommended: {found.recommendation}"
    )


def worth_of(run: Path) -> Worth | None:
    """Return what the corrected twin is worth for the filters of a run; None where that was not computed."""
    path = run / "filters.h5"
    lost = load_uncorrected(path) if path.is_file() else None
    if lost is None:
        return None
    _, focused, _ = load_focusing(path)
    gained = focused.direct.contrast.mean(axis=1) - lost.contrast.mean(axis=1)
    most = int(gained.argmax())
    return Worth(float(gained[most]), float(focused.temperature[most]))
