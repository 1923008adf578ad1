"""Our figures beside the paper's, with the reason for every difference."""

from dataclasses import dataclass

import numpy as np

from analysis.arrays import Real
from analysis.compensation.outcome import NETWORK, Compensation
from analysis.declaration.plate import Plate
from analysis.focusing.methods import MethodComparison
from analysis.focusing.over_temperature import Focusing
from analysis.identification.over_temperature.tracked_modes import TrackedModes
from analysis.material import MaterialLaws
from app.report.page import PageTable
from app.summaries.numbers import with_sigma


@dataclass(frozen=True)
class PaperRow:
    """One quantity: what the paper reports, what this run found, and why they differ."""

    quantity: str
    paper: str
    ours: str
    why: str


PLATE = {"length_x": 0.24, "length_y": 0.19, "thickness": 0.003, "mass": 0.130}
"""Of the paper's section 3: m and kg."""
LIKE_PLATE_DIFFERENCE = 0.03
"""Relative differences within which a plate counts as one like it."""

SPECIMEN = "the plate of this campaign is its own specimen; the law follows the measurement, not the paper"
CLOSE = "agrees with the paper"
AGREEING_SIGMA = 2.0
"""Standard deviations up to which a number agrees with the paper's; those of its rounding count, too."""

CONSTANTS = (
    ("E at {t:g} °C [GPa]", "youngs_modulus", 1e9, "{v:.2f}", {0.0: 3.25, 20.0: 2.26, 60.0: 1.0}),
    ("ν at {t:g} °C", "poisson_ratio", 1.0, "{v:.3f}", {0.0: 0.34, 20.0: 0.37, 60.0: 0.475}),
    ("η at {t:g} °C [%]", "loss_factor", 0.01, "{v:.1f}", {0.0: 4.8, 20.0: 8.2, 60.0: 3.5}),
)
"""The paper's section 4.4 and Table 1."""

COLD, WARM, REFERENCE = 0.0, 60.0, 25.4
"""Of section 4.2 and Fig. 10, degrees Celsius: ends of the oven's cycle, and what frequencies are relative to."""
FILTERS_OF = 20.0
"""Temperature of the filters that section 5.1 keeps everywhere, degrees Celsius."""
DAMPING_PEAK = (10.0, 20.0)
"""Where the largest loss factor of the paper lies, degrees Celsius."""
SAME_TEMPERATURE = 1.5
"""K from a temperature of the paper up to which a number is set beside the paper's: E of the paper's plate changes
by 1.8 % a kelvin, its frequencies by half of that."""


def is_the_papers(plate: Plate) -> bool:
    """Whether a plate has the paper's size and mass; nothing is gained by comparing any other with it."""
    return all(abs(getattr(plate, name) / value - 1.0) < LIKE_PLATE_DIFFERENCE for name, value in PLATE.items())


def figure(plate: Plate, number: int) -> str:
    """Words of a caption that name the figure of the paper; none for a plate that is not the paper's."""
    return f" (paper Fig. {number})" if is_the_papers(plate) else ""


def material_rows(laws: MaterialLaws) -> list[PaperRow]:
    """Constants at the paper's temperatures, where the laws reach, and the damping peak."""
    rows = []
    low, high = laws.temperature_range
    for heading, name, unit, form, published in CONSTANTS:
        for t, paper in published.items():
            if not low <= t <= high:
                continue
            ours, sigma = (float(getattr(found, name)[0]) / unit for found in (laws.at(t), laws.sigma(t)))
            printed = form.format(v=paper)
            why = _beside(ours, sigma, paper, 10.0 ** -len(printed.partition(".")[2]))
            rows.append(PaperRow(heading.format(t=t), printed, with_sigma(ours, sigma), why))
    fine = np.linspace(low, high, 601)
    eta = laws.at(fine).loss_factor
    if not reach(fine, *DAMPING_PEAK):
        return rows
    peak = f"{100 * eta.max():.1f} at {fine[int(eta.argmax())]:.0f} °C"
    why = (
        "the paper takes η as twice the mean modal damping; here η is that of the plate's material alone, "
        "fitted to the whole FRF with lossless patches"
    )
    return [*rows, PaperRow("largest η [%]", "8.5 between 10 and 20 °C", peak, why)]


def _beside(ours: float, sigma: float, paper: float, step: float) -> str:
    """Say whether a number agrees with the paper's, which is rounded to `step`, and by how much it differs."""
    away = abs(ours - paper) / float(np.hypot(sigma, step / np.sqrt(12.0)))
    if away <= AGREEING_SIGMA:
        return CLOSE
    return f"differs by {away:.0f} σ, {100.0 * (ours / paper - 1.0):+.1f} %, its rounding counted: {SPECIMEN}"


def _nearest(temperature: Real, wanted: float) -> int | None:
    """Return which of some temperatures (T,), °C, is one of the paper; None where none is near enough."""
    place = int(np.argmin(np.abs(temperature - wanted)))
    return place if abs(temperature[place] - wanted) < SAME_TEMPERATURE else None


def reach(temperature: Real, low: float = COLD, high: float = WARM) -> bool:
    """Whether temperatures (T,), °C, reach over a range of the paper, by default all of it."""
    return bool(temperature.min() < low + SAME_TEMPERATURE and temperature.max() > high - SAME_TEMPERATURE)


def mode_rows(tracked: TrackedModes) -> list[PaperRow]:
    """Say how frequencies and damping ratios move over temperature (the paper's section 4.2 and Fig. 10).

    Only of sweeps at the temperatures for which the paper gives numbers.
    """
    reading, temperature = tracked.reading(), tracked.temperature
    cold, hot = _nearest(temperature, COLD), _nearest(temperature, WARM)
    reference = _nearest(temperature, REFERENCE)
    known = reading.sigma_damping_ratio < 0.1 * reading.damping_ratio
    rows = []
    for t, paper, implied in ((cold, 0.30, "about +27 %"), (hot, -0.20, "about -29 %")):
        if t is None or reference is None:
            continue
        ours = float(np.nanmedian(reading.frequency_hz[t] / reading.frequency_hz[reference] - 1.0))
        heading = f"frequencies at {temperature[t]:.0f} against {temperature[reference]:.0f} °C [%]"
        why = f"median of the tracked modes; it follows √E, and the paper's own E(T) implies {implied} by √E"
        rows.append(PaperRow(heading, f"about {100 * paper:+.0f}", f"{100 * ours:+.0f}", why))
    for t, nominal, (low, high) in ((cold, COLD, (307.0, 715.0)), (hot, WARM, (182.0, 416.0))):
        if t is not None:
            f = reading.frequency_hz[t][~np.isnan(reading.frequency_hz[t])]
            ends = [float(f[np.argmin(np.abs(f - 0.945 * end))]) for end in (low, high)]
            rows.append(
                PaperRow(
                    f"span of the paper's eight modes at {nominal:g} °C [Hz]",
                    f"{low:.0f} to {high:.0f}",
                    f"{ends[0]:.0f} to {ends[1]:.0f}",
                    "the modes found there; the paper's own E, ν and dimensions put its ends 5 to 7 % lower",
                )
            )
    for t, paper_range in ((cold, "2 to 2.5"), (hot, "below 2")):
        if t is None:
            continue
        found = 100 * reading.damping_ratio[t][known[t]]
        if found.size:
            heading = f"damping ratios at {temperature[t]:.0f} °C [%]"
            why = "modes whose damping is known to 10 %; lossless patches hold a share of the strain energy"
            rows.append(PaperRow(heading, paper_range, f"{found.min():.1f} to {found.max():.1f}", why))
    return rows


def method_rows(comparison: MethodComparison) -> list[PaperRow]:
    """STIF on the panel at hand, of the paper's section 2 or another, as far as its band goes."""
    stif = comparison.methods.index("stif")
    f = comparison.frequency
    why = (
        "the paper gives neither dimensions, supports nor actuator positions of this plate: ours are those of "
        "the panel's file; eq. (9) is taken literally"
    )
    ends = [min(end, f.max()) for end in (220.0, 540.0)]
    contrast, spot = comparison.contrast[stif], 100 * comparison.spot_error[stif]
    see, of = "share of Lx; see above", f", {material_of(comparison)}"
    rows = (
        (f"contrast of STIF to {ends[1]:.0f} Hz", "about 0.9", contrast, ".2f", (f >= 100.0) & (f <= 540.0), why),
        ("contrast of STIF above 540 Hz", "falling", contrast, ".2f", f > 540.0, "as many actuators, more modes"),
        (f"spot error 100 to {ends[0]:.0f} Hz [%]", "about 12", spot, ".0f", (f >= 100.0) & (f <= 220.0), see),
        (f"spot error 220 to {ends[1]:.0f} Hz [%]", "below 10", spot, ".0f", (f > 220.0) & (f <= 540.0), see),
    )
    return [
        PaperRow(f"{question}{of}", theirs, f"{values[at].mean():{form}} mean", note)
        for question, theirs, values, form, at, note in rows
        if at.any()
    ]


def material_of(comparison: MethodComparison) -> str:
    """Say which material the methods are compared on."""
    modulus, _, loss = comparison.constants
    if modulus == 0.0:
        return "with the measured transfers"
    return f"plate of E {modulus / 1e9:.3g} GPa, η {100 * loss:.3g} %, not of this run's laws"


def temperature_rows(focusing: Focusing) -> list[PaperRow]:
    """Say what one filter for every temperature costs, from and at the temperatures of the paper."""
    here = int(np.argmin(np.abs(focusing.temperature - focusing.reference_temperature)))
    mean = focusing.fixed.contrast.mean(1)
    worst = int(mean.argmin())
    every_fifth = np.arange(COLD, WARM + 1.0, 5.0)  # at which section 5.1 keeps the filters of 20 °C
    if (
        abs(focusing.reference_temperature - FILTERS_OF) > SAME_TEMPERATURE
        or _nearest(every_fifth, float(focusing.temperature[worst])) is None
    ):
        return []
    return [
        PaperRow(
            f"mean contrast, {focusing.reference_temperature:g} °C filters, at {focusing.temperature[worst]:g} °C",
            "highly degraded",
            f"{mean[worst]:.2f} (at {focusing.temperature[here]:g} °C {mean[here]:.2f})",
            "the paper shows curves only",
        )
    ]


def compensation_rows(compensation: Compensation) -> list[PaperRow]:
    """Compare the networks: relative error and contrast regained, over the range of the paper, and time."""
    place = compensation.methods.index(NETWORK)
    error = compensation.relative_error[place].max()
    best = compensation.best
    best_loss = compensation.largest_loss[compensation.methods.index(best)]
    judged = [
        PaperRow(
            "largest relative error of the networks, eq. (13) [% of energy]",
            "0.9",
            f"{error:.2g}",
            "the paper leaves some temperatures out of each training and scales every tap on its own; "
            "here all train, with one scale an actuator, on filters regularised smoothly (Tikhonov)",
        ),
        PaperRow(
            "contrast lost against direct filters",
            "none visible",
            f"{compensation.contrast_loss[place].max():.2g} at most",
            "",
        ),
    ]
    return [
        *(judged if reach(compensation.temperature) else []),
        PaperRow(
            "training of the networks, one an actuator",
            "six: 1 h (10 nodes) to 7-9 h (16)",
            f"{len(compensation.trained.networks.slope)}: {compensation.seconds[place]:.1f} s",
            "the same algorithm, its linear output layer eliminated exactly",
        ),
        PaperRow("best method on these filters", "not compared", f"{best}, contrast loss {best_loss:.2g}", ""),
    ]


def beside_paper(rows: list[PaperRow]) -> PageTable:
    """Set rows as a table."""
    cells = [(row.quantity, row.paper, row.ours, row.why) for row in rows]
    return PageTable(("quantity", "paper", "this run", "why they differ"), cells)
