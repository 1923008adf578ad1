"""What a run found, one line a stage, what its twin is worth, and from what its results were made."""

import json
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from analysis.compensation.outcome import NETWORK
from analysis.recordings.campaign import CampaignExtent
from analysis.updated import Updated
from app.files.campaigns.inputs import OF_CAMPAIGN, has_other_sweeps, said_of_more_sweeps, stored_extent, sweeps_of
from app.files.campaigns.of_run import made_by
from app.files.hdf5_file import result_file
from app.files.provenance import read_stamp, sha256
from app.files.results.best_twin import BY_UPDATE, best_twin, load_gap_record
from app.files.results.modes_file import load_frf, load_modes
from app.files.results.panel_files import load_compensation, load_focusing, load_uncorrected
from app.files.results.run_folder import MADE_BY
from app.report.page import Folded, Item, Listing, PageTable
from app.summaries.briefing import Worth
from app.summaries.gap import chi2_before_and_after, concluded, found_words, titles_of
from app.summaries.numbers import span, sweeps
from app.summaries.update import sheet_words


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
        said += f"; {BY_UPDATE}: {_constants(best.uncorrected.updated)}"
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
    line = f"mean contrast {span(own, '.2f')}"
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


Stamps = Mapping[str, Mapping[str, Any]]
"""Provenance of every result, by file."""
FOUND_HERE = (*MADE_BY, "twin.toml")
"""Inputs that lie in the run itself; a file from others may name any path as its input."""


def stamps(run: Path, names: Sequence[str]) -> Stamps:
    """Read the provenance of those of `names` that the run holds; ResultFileError for a file without one."""
    found = {}
    for name in names:
        if (run / name).is_file():
            with result_file(run / name, MADE_BY[name]) as file:
                found[name] = _whole(read_stamp(file))
    return found


def _whole(stamp: object) -> Mapping[str, Any]:
    tables = ("inputs", "settings", "packages")
    if not isinstance(stamp, dict) or not all(isinstance(stamp.get(name), dict) for name in tables):
        raise ValueError(f"its provenance: a table with {', '.join(tables)} is wanted")
    stored_extent(stamp)
    return {"flexura": "?", "python": "?", "seed": None, **stamp}


def outdated(run: Path, found: Stamps) -> list[str]:
    """Say which results do not belong to what lies beside them: a sentence each."""
    inputs = {made_from for stamp in found.values() for made_from in stamp["inputs"]}
    here = {name: sha256(run / name) for name in inputs.intersection(FOUND_HERE) if (run / name).is_file()}
    first: dict[str, tuple[str, str]] = {}
    said = []
    for name, stamp in found.items():
        apart = []
        for made_from, digest in stamp["inputs"].items():
            if here.get(made_from, digest) != digest:
                said.append(
                    f"{name} was made from another {made_from} than the one that is here now; "
                    f"make it again: flexura {made_by(run, name)}"
                )
                continue
            other, theirs = first.setdefault(made_from, (name, digest))
            if theirs != digest:
                apart.append(f"{name} and {other} were made from different files called {made_from}")
        if apart:
            said.append(f"{apart[0]}; make both again from one recording")
    return [*said, *_of_fewer_sweeps(run, found, {one.split(" ", 1)[0] for one in said})]


def _of_fewer_sweeps(run: Path, found: Stamps, told: Collection[str]) -> list[str]:
    """Say which results were made when their campaign had other sweeps than later ones, or than it has now."""
    own = {name: stamp["inputs"] for name, stamp in found.items() if name in OF_CAMPAIGN and name not in told}
    said = {name: said_of_more_sweeps(run, inputs, MADE_BY[name].split()[0]) for name, inputs in own.items()}
    for name, inputs in own.items():
        most = max(own, key=lambda other: len(sweeps_of(own[other])))
        if said[name] is None and has_other_sweeps(inputs, own[most]):
            said[name] = (
                f"made from {len(sweeps_of(inputs))} sweeps of a campaign, and {most} from "
                f"{len(sweeps_of(own[most]))}; make it again: flexura {made_by(run, name)}"
            )
    return [f"{name} was {sentence}" for name, sentence in said.items() if sentence is not None]


def extent_of(found: Stamps) -> CampaignExtent | None:
    """Return how complete the campaign was when frf.h5 was made; None where it was."""
    return stored_extent(found["frf.h5"]) if "frf.h5" in found else None


def origin(found: Stamps) -> list[Item]:
    """Versions, inputs and settings of every result; what two results share is given once."""
    versions = [
        (
            name,
            f"Flexura {s['flexura']}, Python {s['python']}",
            ", ".join(f"{package} {version}" for package, version in s["packages"].items()),
            "" if s["seed"] is None else str(s["seed"]),
        )
        for name, s in found.items()
    ]
    into: dict[tuple[str, str], list[str]] = {}
    for name, stamp in found.items():
        for made_from, digest in stamp["inputs"].items():
            into.setdefault((made_from, digest), []).append(name)
    inputs = [(made_from, digest, ", ".join(names)) for (made_from, digest), names in into.items()]
    line = f"Versions, settings and the SHA-256 of {len(inputs)} inputs of {', '.join(found)}"
    parts = (
        PageTable(("result", "made with", "libraries", "seed"), versions),
        PageTable(("input", "SHA-256", "went into"), inputs, codes=(1,)),
        Listing("\n".join(_settings(found))),
    )
    return [Folded(line, parts)]


def _settings(found: Stamps) -> Iterator[str]:
    """List the settings of each result, a value to a line; a table that an earlier result has too by its name."""
    for place, (name, stamp) in enumerate(found.items()):
        for key, value in stamp["settings"].items():
            earlier = [n for n in list(found)[:place] if found[n]["settings"].get(key) == value]
            if earlier and isinstance(value, dict):
                yield f"{name}: {key} as in {earlier[0]}"
            else:
                yield from (f"{name}: {line}" for line in _lines(key, value))


def _lines(key: str, value: object) -> Iterator[str]:
    if isinstance(value, dict):
        for inner, held in value.items():
            yield from _lines(f"{key}.{inner}", held)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for number, held in enumerate(value, 1):
            yield f"{key} {number} = {json.dumps(held, ensure_ascii=False)}"
    else:
        yield f"{key} = {json.dumps(value, ensure_ascii=False)}"
