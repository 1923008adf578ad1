"""What is written of a fleet: ``fleet.json``, and ``fleet.html``, one page that loads nothing from anywhere."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from analysis.arrays import Real
from analysis.fleet import predict_piece
from app.files.provenance import provenance
from app.files.results.run_record import hashed
from app.fleet.fleet_run import RunMember
from app.fleet.laws_beside import CONSTANTS, FILTERS, MISFIT, USABLE_LOSS, Exchange, FleetLaws
from app.report.page import Absent, Item, PageTable, Paragraph, Picture, Section, VerdictBox, page
from app.report.style import drawing, panels

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA = "flexura-fleet/1"
NAME = "fleet.json"
BAND_SHARE = 0.9
"""Share of further pieces that the band about the mean of the fleet is to hold."""
LINEAR = "poisson_ratio"
"""The constant whose law is compared as it is; of the others the logarithm is."""
TITLES = {"youngs_modulus": "E", "poisson_ratio": "ν", "loss_factor": "η"}


def fleet_record(
    members: Sequence[RunMember], laws: FleetLaws, exchange: Exchange | None, settings: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what ``fleet.json`` holds.

    Parameters
    ----------
    settings : mapping
        Stages and options of the run.
    """
    files = ("laws.h5", "laws-corrected.h5", "gap.json", FILTERS)
    inputs = {f"{one.name}/{name}": digest for one in members for name, digest in hashed(one.run, files).items()}
    return {
        "schema": SCHEMA,
        "provenance": provenance(inputs, settings),
        "pieces": [
            {
                "name": one.name,
                "campaign": str(one.campaign),
                "run": str(one.run),
                "good": one.good,
                "said": one.said,
                "stages": {stage: state.state for stage, state in one.stages.items()},
                "unread": laws.unread.get(one.name, ""),
            }
            for one in members
        ],
        "temperature": laws.temperature.tolist(),
        "laws": {name: _constant(name, laws) for name in laws.scatter},
        "outliers": [
            {
                "name": name,
                "quantity": one.quantity,
                "deviation": one.deviation,
                "probability": one.probability,
                "said": said_of(name, laws),
            }
            for name, one in laws.outliers.items()
        ],
        "lacking": {one.name: one.lacks for one in laws.pieces if one.lacks},
        "predicted": [
            {
                "name": one.name,
                "measured_at": one.measured_at,
                "band": BAND_SHARE,
                "temperature": one.temperature.tolist(),
                **{
                    name: {key: _natural(name, getattr(law, key)) for key in ("value", "low", "high")}
                    for name, law in one.laws.items()
                },
            }
            for one in laws.predicted
        ],
        "exchange": None
        if exchange is None
        else {
            "names": list(exchange.names),
            "loss": [[None if np.isnan(x) else round(float(x), 5) for x in row] for row in exchange.loss],
            "usable_for": {name: list(exchange.users_of(row)) for row, name in enumerate(exchange.names)},
            "notes": list(exchange.notes),
        },
    }


def said_of(name: str, laws: FleetLaws) -> str:
    """Say why a piece does not belong to the others, and what that may be, in one sentence."""
    one = laws.outliers[name]
    lacks = next((piece.lacks for piece in laws.pieces if piece.name == name), "")
    if one.quantity == MISFIT:
        seen = f"its twin misses the measurement {np.exp(one.deviation):.1f} times as far as those of the others"
        return f"{seen}: {lacks or 'something is on it, or missing, that the others have not (flexura gap)'}"
    size = f"{one.deviation:+.3f}" if one.quantity == LINEAR else f"{100 * np.expm1(one.deviation):+.1f} %"
    seen = f"{TITLES[one.quantity]} is {size} from the others' mean"
    return f"{seen}: {lacks or 'of another batch?'}"


def summary_of(members: Sequence[RunMember], laws: FleetLaws) -> str:
    """Return the fleet in one line."""
    failed = sum(not one.good for one in members)
    said = [f"{len(members)} campaigns"]
    said += [f"{failed} with something amiss"] if failed else []
    if "youngs_modulus" in laws.scatter:
        said.append(f"E scatters by {100 * laws.scatter['youngs_modulus'].between:.2g} % between pieces")
    said += [f"not like the others: {', '.join(laws.outliers)}"] if laws.outliers else []
    return ", ".join(said)


def _constant(name: str, laws: FleetLaws) -> dict[str, Any]:
    scatter = laws.scatter[name]
    band = predict_piece(scatter, share=BAND_SHARE)
    return {
        "mean": _natural(name, scatter.mean),
        "band": {"share": BAND_SHARE, "low": _natural(name, band.low), "high": _natural(name, band.high)},
        "between": scatter.between,
        "within": scatter.within,
        "scale": "linear" if name == LINEAR else "logarithm",
        "pieces": scatter.pieces,
    }


def _natural(name: str, values: Real) -> list[float]:
    """Return values in the constant's own unit."""
    return (values if name == LINEAR else np.exp(values)).tolist()  # type: ignore[no-any-return]


LAWS = {"youngs_modulus": ("E [GPa]", 1e9), "poisson_ratio": ("ν", 1.0), "loss_factor": ("η [%]", 0.01)}
SHADE, OFF, NEW = "#00798c", "#d1495b", "#e69f00"
PAGE = "fleet.html"


def fleet_page(members: Sequence[RunMember], laws: FleetLaws, exchange: Exchange | None) -> str:
    """Return the page as HTML."""
    with drawing():
        sections = [
            Section("What was found", _found(members, laws)),
            Section("Laws of all pieces", _laws(laws)),
            Section("Which filters can be used for which panel?", _exchange(exchange)),
            Section("Every piece", [_members(members, laws)]),
        ]
        return page("A fleet of panels", summary_of(members, laws), sections, lead=1)


def scatter_rows(laws: FleetLaws) -> list[list[str]]:
    """Return a row for each constant: mean at the middle temperature, scatter between pieces and within."""
    rows = []
    for name, scatter in laws.scatter.items():
        middle = laws.temperature.size // 2
        mean = scatter.mean[middle] if name == LINEAR else np.exp(scatter.mean[middle])
        unit = LAWS[name][1]
        between, within = (
            f"{one:.4f}" if name == LINEAR else f"{100 * one:.2f} %" for one in (scatter.between, scatter.within)
        )
        at = f"{laws.temperature[middle]:.0f} °C"
        rows.append([LAWS[name][0], f"{mean / unit:.4g}", at, between, within, str(scatter.pieces)])
    return rows


HEADINGS = ("constant", "mean", "at", "between pieces", "within a piece", "pieces")


def _found(members: Sequence[RunMember], laws: FleetLaws) -> list[Item]:
    told = [f"{name}: {said_of(name, laws)}" for name in laws.outliers]
    told += [
        f"{one.name}: its twin lacks {one.lacks}"
        for one in laws.pieces
        if one.lacks and one.name not in laws.outliers
    ]
    told += [f"{one.name}: {one.said}" for one in members if one.failure]
    headline = "Pieces that are not like the others" if laws.outliers else "No piece differs from the others"
    if not laws.scatter:
        headline = "The pieces cannot be compared"
        told.append("laws of three pieces or more over a common range of temperatures are needed")
    found: list[Item] = [VerdictBox(headline, told, not told)]
    if laws.scatter:
        found.append(PageTable(HEADINGS, scatter_rows(laws), numbers=(1, 2, 3, 4, 5)))
        found.append(
            Paragraph(
                "Standard deviations, without the pieces named above, the noise of the estimates taken off. "
                "Between pieces: of a piece's level, the same at all temperatures; what its declaration leaves "
                "open (thickness, mass) is in it. Within a piece: what is left at each temperature."
            )
        )
    return found


def _laws(laws: FleetLaws) -> list[Item]:
    if not laws.scatter:
        return [Absent("Nothing is compared: see above.")]
    figure = law_figure(laws)
    caption = (
        "Every line is a piece, the noise of its estimates in it. Shaded: where the true law of "
        f"{100 * BAND_SHARE:.0f} % of further pieces lies, of which nothing is measured. Red: pieces not like the "
        "others. With bars: pieces measured at the marked temperature only, as the fleet predicts them, with "
        f"{100 * BAND_SHARE:.0f} % bands."
    )
    return [Picture("fleet-laws", "How far do the laws of the pieces differ?", figure, caption)]


def law_figure(laws: FleetLaws) -> "Figure":
    """Draw E, nu and eta of all pieces over temperature, and below how far each is from the fleet's mean."""
    figure, axes = panels(2, 3, height=6.4, sharex=True)
    for column, name in enumerate(CONSTANTS):
        above, below = axes[:, column]
        label, unit = LAWS[name]
        linear, mean = name == LINEAR, laws.scatter[name].mean
        band = predict_piece(laws.scatter[name], share=BAND_SHARE)

        def natural(values: Real, linear: bool = linear, unit: float = unit) -> Real:
            return (values if linear else np.exp(values)) / unit

        def apart(values: Real, mean: Real, linear: bool = linear) -> Real:
            return values - mean if linear else 100.0 * np.expm1(values - mean)

        above.fill_between(laws.temperature, natural(band.low), natural(band.high), color=SHADE, alpha=0.15)
        below.fill_between(
            laws.temperature, apart(band.low, mean), apart(band.high, mean), color=SHADE, alpha=0.15
        )
        for values, piece in zip(laws.values[column], laws.with_laws, strict=True):
            off = piece.name in laws.outliers
            look = {"color": OFF, "lw": 1.6} if off else {"color": "0.4", "lw": 0.8}
            above.plot(laws.temperature, natural(values), **look)
            below.plot(laws.temperature, apart(values, mean), **look)
            if off:
                at = (laws.temperature[-1], apart(values, mean)[-1])
                below.annotate(piece.name, at, color=OFF, fontsize=8.5, ha="right", va="bottom")
        above.plot(laws.temperature, natural(mean), color=SHADE, lw=2.0)
        below.axhline(0.0, color=SHADE, lw=2.0)
        for one in laws.predicted:
            law = one.laws[name]
            there = np.interp(one.temperature, laws.temperature, mean)
            middle = apart(law.value, there)
            bars = np.abs(np.array([apart(law.low, there), apart(law.high, there)]) - middle)
            below.errorbar(one.temperature, middle, bars, color=NEW, lw=1.2, capsize=2)
            place = int(np.argmin(np.abs(one.temperature - one.measured_at)))
            below.plot(one.temperature[place], middle[place], "o", color=NEW, ms=5)
        above.set_title(label)
        below.set_title(f"{TITLES[name]} from the mean" + ("" if linear else " [%]"))
        below.set_xlabel("temperature [°C]")
    return figure


def _exchange(exchange: Exchange | None) -> list[Item]:
    if exchange is None:
        return [Absent("No two panels have filters; make them: the same flexura run with --until focus")]
    rows = [
        [name, *("" if np.isnan(lost) else f"{lost:.3f}" for lost in exchange.loss[row])]
        for row, name in enumerate(exchange.names)
    ]
    lines = [
        Paragraph(f"{name}: its filters also suit {', '.join(exchange.users_of(row)) or 'no other panel'}.")
        for row, name in enumerate(exchange.names)
    ]
    said = (
        "Contrast that the filters of the panel in the row lose on the panel in the column, against that panel's "
        f"own (mean over the band and up to three temperatures). Up to {USABLE_LOSS:g} they can be used."
    )
    table = PageTable(("filters of", *exchange.names), rows, numbers=range(1, len(exchange.names) + 1))
    return [Paragraph(said), table, *lines, *(Absent(note) for note in exchange.notes)]


def _members(members: Sequence[RunMember], laws: FleetLaws) -> PageTable:
    known = {one.name: one for one in laws.pieces}
    rows = []
    for one in members:
        piece = known.get(one.name)
        misfit = "" if piece is None else f"{piece.misfit:.2f}"
        lacks = "" if piece is None else piece.lacks
        rows.append([one.name, one.said, misfit, lacks, laws.unread.get(one.name, ""), str(one.run)])
    return PageTable(("piece", "stages", "misfit / noise", "lacks", "not read", "results"), rows, numbers=(2,))


def show(members: Sequence[RunMember], laws: FleetLaws) -> None:
    """Print scatter, outliers and predicted pieces."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console()
    if laws.scatter:
        table = Table(title="Scatter of the fleet", header_style="bold")
        for heading in HEADINGS:
            table.add_column(heading, justify="left" if heading == "constant" else "right")
        for row in scatter_rows(laws):
            table.add_row(*map(Text, row))
        console.print(table)
    said = Table(title="Pieces", show_header=False, show_lines=True)
    said.add_column(style="bold", no_wrap=True)
    said.add_column(overflow="fold")
    for name in laws.outliers:
        said.add_row(Text(name), Text(said_of(name, laws)))
    for one in laws.pieces:
        if one.lacks and one.name not in laws.outliers:
            said.add_row(Text(one.name), Text(f"its twin lacks {one.lacks}"))
    for new in laws.predicted:
        law = new.laws["youngs_modulus"]
        low, high = np.exp([law.low, law.high]) / 1e9
        ends = ", ".join(
            f"{low[place]:.3g} to {high[place]:.3g} GPa at {new.temperature[place]:.0f} °C" for place in (0, -1)
        )
        said.add_row(
            Text(new.name),
            Text(f"measured at {new.measured_at:.1f} °C; predicted {TITLES['youngs_modulus']}: {ends} (90 %)"),
        )
    for member in members:
        if member.failure:
            said.add_row(Text(member.name), Text(member.failure))
    if said.row_count:
        console.print(said)
