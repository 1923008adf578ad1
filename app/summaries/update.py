"""Estimates of model updating as JSON, as a table and in one line; notes for the user.

Constants of an orthotropic sheet by direction: as JSON, as tables, in a line, and as a panel declares them.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from analysis.channel import Channel
from analysis.estimates import DeclaredQuantity, SheetConstants, SheetMaterial, budget, doubts
from analysis.gap.data.groups import FEWEST, distinct_temperatures
from analysis.material import MaterialLaws
from analysis.pairing.assignment import Pairing
from analysis.updated import GOOD_MISFIT, Updated
from app.files.results.pairing_json import declared_record
from app.summaries.numbers import span, sweeps, with_sigma
from app.summaries.table import Table


def gains_text(updated: Updated, inputs: Sequence[Channel]) -> str:
    """Say the gain of every input, with its standard deviation: ``14.3000 ± 0.0020 V/V``; names if several."""
    name = "{} " if len(inputs) > 1 else ""
    return ", ".join(
        name.format(one.id) + with_sigma(gain, sigma, one.gain_unit)
        for one, gain, sigma in zip(inputs, updated.gains, updated.sigma_gains, strict=True)
    )


UNLIKELY_GAIN = 2.0
"""Factor either way from 1 by which a measured force is not off: hammers and shakers are calibrated to a few
percent, piezoelectric constants of a patch that answers known to tens of percent."""
MISTAKEN_UNITS = {
    1000.0: "m and mm, or V and mV",
    9.80665: "g and m/s2",
    4.4482: "lbf and N",
    25.4: "inch and mm",
    39.37: "inch and m",
}
"""Factors between units that are taken for each other."""
SAME_FACTOR = 1.1
"""Factor either way by which a gain is one of them: the calibration comes on top."""


DERIVATIVES = (1, 2)
"""Times that one quantity of motion is differentiated to give another: velocity, acceleration."""
MISSED = 0.5
"""Share of the response that the twin misses, from which the FRFs may be of another quantity: in a right fit that
is off by a factor, they are not."""


def gain_notes(updated: Updated, inputs: Sequence[Channel], band: tuple[float, float]) -> list[str]:
    """Say which measured forces are not those that the twin needs for its FRFs: a unit, or a sensitivity.

    Parameters
    ----------
    band : (float, float)
        Of the FRFs, Hz: velocity taken for acceleration is off by the angular frequency.
    """
    said = []
    missed = float(np.median(updated.misfit)) > MISSED
    for one, gain in zip(inputs, np.abs(updated.gains).tolist(), strict=True):
        off = max(gain, 1.0 / gain) if gain > 0.0 else np.inf
        if one.quantity != "force" or off < UNLIKELY_GAIN:
            continue
        known = [
            words for factor, words in MISTAKEN_UNITS.items() if off / SAME_FACTOR < factor < off * SAME_FACTOR
        ]
        if missed and any(band[0] <= off ** (1.0 / n) / (2.0 * np.pi) <= band[1] for n in DERIVATIVES):
            known.append("displacement, velocity and acceleration, one of them declared for another,")
        like = f" ({', or '.join(known)} are that much apart)" if known else ""
        said.append(
            f"{one.id}: gain {gain:.3g} {one.gain_unit}, and a measured force has 1: the FRFs are {off:.3g} times "
            f"too {'large' if gain > 1.0 else 'small'}{like}. Correct units or sensitivity; the frequencies, and "
            "so E, ν and η, do not depend on it"
        )
    return said


def record(updated: Updated, seconds: float, inputs: Sequence[Channel], source: Sequence[int]) -> dict[str, Any]:
    """Return what ``--json`` prints: SI units, one entry per sweep in the order recorded.

    Parameters
    ----------
    seconds : float
        Time that it took, s.
    inputs : sequence of Channel
        All of the experiment. Of several, ``gains`` gives each one's, and every sweep its ``actuator``; ``gain``
        is that of the first.
    source : sequence of int
        Which of them drove each sweep.
    """
    several, sheet = len(inputs) > 1, updated.sheet
    rows = [
        {**_row(updated, t), **({"actuator": inputs[source[t]].id} if several else {})}
        for t in range(len(updated.temperature))
    ]
    gains = zip(inputs, updated.gains, updated.sigma_gains, strict=True)
    by_name = {one.id: {"gain": float(gain), "sigma_gain": float(sigma)} for one, gain, sigma in gains}
    return {
        "temperatures": rows,
        "gain": updated.gain,
        "sigma_gain": updated.sigma_gain,
        **({"gains": by_name} if several else {}),
        **({} if sheet is None else {"sheet": sheet_record(sheet)}),
        "declared": [declared_record(one) for one in updated.declared],
        "budget": budgets(updated),
        "seconds": seconds,
    }


def _row(updated: Updated, t: int) -> dict[str, Any]:
    """Return one sweep's entry."""
    e, nu, eta = updated.constants[t]
    sigma = updated.sigma
    isotropic = {
        "youngs_modulus_pa": e,
        "poisson_ratio": nu,
        "loss_factor": eta,
        "sigma": {
            "youngs_modulus_pa": float(sigma.youngs_modulus[t]),
            "poisson_ratio": float(sigma.poisson_ratio[t]),
            "loss_factor": float(sigma.loss_factor[t]),
        },
    }
    return {
        "temperature_c": float(updated.temperature[t]),
        **(isotropic if updated.sheet is None else sheet_row(updated.sheet, t)),
        "misfit": float(updated.misfit[t]),
        "misfit_start": float(updated.misfit_start[t]),
        "noise_floor": float(updated.noise_floor[t]),
        "chi2_per_dof": float(updated.chi2_per_dof[t]),
        "settled": bool(updated.settled[t]),
    }


def tables_of(updated: Updated, driven_by: Sequence[str] = ()) -> list[Table]:
    """Return the estimates as tables, one row per sweep: one, or of an orthotropic sheet two.

    Parameters
    ----------
    driven_by : sequence of str
        Of every sweep, where there are several inputs: its name stands behind the temperature, because a terminal
        of 80 columns has no room for one more.
    """
    tables = [_table_of(updated)] if updated.sheet is None else sheet_tables(updated, updated.sheet)
    if not driven_by:
        return tables
    return [
        replace(
            table,
            rows=tuple((f"{row[0]} {name}", *row[1:]) for row, name in zip(table.rows, driven_by, strict=True)),
        )
        for table in tables
    ]


def _table_of(updated: Updated) -> Table:
    sigma = updated.sigma
    rows = tuple(
        (
            f"{updated.temperature[t]:.2f}{'' if updated.settled[t] else ' ?'}",
            f"{e / 1e9:.4f}",
            _sigma(100 * sigma.youngs_modulus[t] / e, 4),
            f"{nu:.4f}",
            _sigma(sigma.poisson_ratio[t], 5),
            f"{100 * eta:.3f}",
            _sigma(100 * sigma.loss_factor[t] / eta, 4),
            f"{100 * updated.misfit[t]:.2f} %",
            f"{100 * updated.noise_floor[t]:.2f} %",
        )
        for t, (e, nu, eta) in enumerate(updated.constants)
    )
    headings = ("T [°C]", "E [GPa]", "σ_E/E [%]", "ν", "σ_ν", "η [%]", "σ_η/η [%]", "misfit", "noise")
    return Table("Updated twin", headings, rows, CAPTION, whole=True)


def _sigma(value: float, digits: int) -> str:
    """Write a standard deviation; of what is no estimate it has no digits after the point."""
    return f"{value:.{digits}f}" if value < LARGEST_SIGMA else f"{value:.1g}"


LARGEST_SIGMA = 1000.0
"""Of what is told in per cent: ten times itself. Seven digits before the point cut the columns of a terminal."""


def budgets(updated: Updated) -> dict[str, dict[str, float]]:
    """Return what makes up one standard deviation of E, nu and eta at the middle temperature, as shares of them.

    Of nu absolute; each with its `total`; empty without tolerances. Of an orthotropic sheet of the constants by
    direction.
    """
    if updated.common is None:
        return {}
    if updated.sheet is not None:
        return sheet_budgets(updated, updated.sheet)
    middle = int(np.argsort(updated.temperature)[len(updated.temperature) // 2])
    found, own, total = {}, updated.own_sigma, updated.sigma
    for law, name in enumerate(("youngs_modulus", "poisson_ratio", "loss_factor")):
        scale = 1.0 if name == "poisson_ratio" else float(getattr(updated.material, name)[middle])
        rows = budget(updated.declared, updated.common[middle, law], float(getattr(own, name)[middle]) / scale)
        found[name] = {"total": float(getattr(total, name)[middle]) / scale, **dict(rows)}
    return found


def budget_lines(updated: Updated) -> list[str]:
    """Say for E, nu and eta what one standard deviation is made of, the largest contributions first."""
    symbols = {one.name: (one.symbol, bool(one.unit)) for one in CONSTANTS}
    symbols |= {"youngs_modulus": ("E", True), "poisson_ratio": ("ν", False), "loss_factor": ("η", True)}
    lines = []
    for name, parts in budgets(updated).items():
        symbol, relative = symbols[name]
        sigma, factor, unit = (f"σ_{symbol}/{symbol}", 100.0, " %") if relative else (f"σ_{symbol}", 1.0, "")
        largest = [(kind, share) for kind, share in parts.items() if kind != "total"][:CONTRIBUTIONS_NAMED]
        said = ", ".join(f"{kind} {factor * share:.2g}" for kind, share in largest)
        lines.append(f"{sigma} {factor * parts['total']:.2g}{unit}: {said}")
    return lines


CONTRIBUTIONS_NAMED = 4
"""Contributions named in one line of a budget: what comes after them is too small to be seen in the sum."""


def headline(updated: Updated) -> str:
    """Return sweeps, E, nu, eta and the misfit in one line."""
    m, t = updated.material, updated.temperature
    e, nu, eta = m.youngs_modulus / 1e9, m.poisson_ratio, 100 * m.loss_factor
    ratio = float((updated.misfit / updated.noise_floor).max())
    constants = f"E {span(e, '.3f')} GPa, ν {span(nu, '.3f')}, η {span(eta, '.2f')} %"
    said = constants if updated.sheet is None else sheet_words(updated.sheet)
    return f"{sweeps(len(t))}, {span(t, 'z.1f')} °C: {said}, misfit at most {ratio:.2f} times the noise"


def summary(updated: Updated, run: Path, seconds: float, unit: str, pairing: Pairing | None = None) -> str:
    """Return the closing line of the update verb.

    Parameters
    ----------
    run : Path
        Run folder.
    seconds : float
        Time that it took, s.
    unit : str
        Of the gain.
    """
    ratio = float((updated.misfit / updated.noise_floor).max())
    no_fit = "no fit: " if pairing is not None and not pairing.fits else ""
    return (
        f"{no_fit}{sweeps(len(updated.temperature))} updated in {seconds:.1f} s, gain {updated.gain:.3f} {unit}, "
        f"misfit at most {ratio:.2f} times the noise; results in {run}"
    )


def too_few(updated: Updated) -> str:
    """Say that there are no laws, how many temperatures they need, and how many are there."""
    count = distinct_temperatures(updated.temperature[updated.settled])
    return (
        f"no laws over temperature: settled estimates at {FEWEST} temperatures or more are needed, and there "
        f"{'is' if count == 1 else 'are'} {count}"
    )


def notes(
    updated: Updated, laws: MaterialLaws | None, pairing: Pairing | None = None, campaign: str = ""
) -> list[str]:
    """Say what has to be known before the estimates are trusted; `campaign` as a command names it, if known."""
    if pairing is not None and not pairing.fits:
        return [pairing.said, *filter(None, [pairing.likely])]
    said = [] if pairing is None else list(pairing.wrong_points)
    unsettled = int((~updated.settled).sum())
    if unsettled:
        said.append(
            f"{unsettled} of {len(updated.settled)} sweeps (marked ?) did not settle inside the twin's certified "
            "range: their values are no estimates. Is the declaration right: mass, thickness, positions, which "
            "channel is which?"
        )
    elif (updated.misfit / updated.noise_floor).max() > GOOD_MISFIT:
        said.append(
            "the twin lacks an effect that the plate has: the constants above absorb part of it. "
            f"To find it: flexura gap {campaign}".rstrip()
        )
    said += doubts(updated.declared)
    if updated.sheet is not None:
        said.append(declared_line(updated.sheet))
    if laws is None:
        said.append(too_few(updated))
    return said


class Shown(NamedTuple):
    """One constant as people read it.

    Attributes
    ----------
    name : str
        Of `SheetConstants`.
    symbol, unit : str
    scale : float
        Of the unit, SI.
    title : str
    """

    name: str
    symbol: str
    unit: str
    scale: float
    title: str

    @property
    def key(self) -> str:
        """Return the key in JSON: with Pa for a modulus."""
        return f"{self.name}_pa" if self.unit == "GPa" else self.name

    @property
    def label(self) -> str:
        """Return symbol and unit."""
        return f"{self.symbol} [{self.unit}]" if self.unit else self.symbol


CONSTANTS = (
    Shown("youngs_modulus_x", "Ex", "GPa", 1e9, "Young's modulus along x"),
    Shown("youngs_modulus_y", "Ey", "GPa", 1e9, "Young's modulus along y"),
    Shown("shear_modulus", "Gxy", "GPa", 1e9, "shear modulus"),
    Shown("poisson_ratio_xy", "νxy", "", 1.0, "Poisson's ratio"),
    Shown("loss_factor_x", "ηx", "%", 0.01, "loss factor along x"),
    Shown("loss_factor_y", "ηy", "%", 0.01, "loss factor along y"),
    Shown("loss_factor_shear", "ηG", "%", 0.01, "loss factor of shear"),
)
"""In the order of `SheetConstants`; x and y are the sheet's own axes."""


def sheet_row(sheet: SheetMaterial, row: int) -> dict[str, Any]:
    """Return the constants of one sweep as JSON holds them, with their standard deviations under ``sigma``."""

    def of(constants: SheetConstants) -> dict[str, float]:
        return {one.key: float(getattr(constants, one.name)[row]) for one in CONSTANTS}

    return {**of(sheet.value), "sigma": of(sheet.sigma)}


def sheet_record(sheet: SheetMaterial) -> dict[str, Any]:
    """Return what is constant over temperature: the shares with which the sheet found would be declared."""
    loss = dict(zip(("x", "y", "shear"), loss_shares(sheet), strict=True))
    return {
        "delta_e": sheet.delta_e,
        "delta_g": sheet.delta_g,
        "angle": float(np.rad2deg(sheet.declared.angle)),
        "loss_over_mean": loss,
    }


def loss_shares(sheet: SheetMaterial) -> tuple[float, float, float]:
    """Loss factors along x, along y and of shear over that of the laws."""
    p, q = sheet.ratios[2:]
    return float(np.exp(-0.5 * p)), float(np.exp(0.5 * p)), float(np.exp(q))


CAPTION = "σ: noise of the sweep, tolerances of the declaration, and the twin's own error"
"""Below the table of the estimates."""


def sheet_tables(updated: Updated, sheet: SheetMaterial) -> list[Table]:
    """Return moduli, and loss factors, as tables, one row per sweep."""
    found = []
    for title, chosen, last in (
        ("Updated twin: moduli in GPa, σ in %", CONSTANTS[:4], False),
        ("loss factors in %, σ in % of them", CONSTANTS[4:], True),
    ):
        headings = ["T [°C]"]
        for one in chosen:
            headings += [one.symbol, "σ"]
        rows = []
        for t in range(len(updated.temperature)):
            cells = [f"{updated.temperature[t]:.2f}{'' if updated.settled[t] else ' ?'}"]
            for one in chosen:
                value = float(getattr(sheet.value, one.name)[t])
                sigma = float(getattr(sheet.sigma, one.name)[t])
                cells.append(f"{value / one.scale:.3f}" if one.unit else f"{value:.4f}")
                cells.append(f"{100.0 * sigma / value:.3f}" if one.unit else f"{sigma:.5f}")
            if last:
                cells += [f"{100 * updated.misfit[t]:.2f} %", f"{100 * updated.noise_floor[t]:.2f} %"]
            rows.append(tuple(cells))
        every = (*headings, *(("misfit", "noise") if last else ()))
        found.append(Table(title, every, tuple(rows), CAPTION if last else "", whole=True))
    return found


def sheet_words(sheet: SheetMaterial) -> str:
    """Return the ranges of the constants in one line."""
    parts = []
    for one in CONSTANTS:
        value = getattr(sheet.value, one.name) / one.scale
        digits = 2 if one.unit == "%" else 3
        unit = f" {one.unit}" if one.unit else ""
        parts.append(f"{one.symbol} {value.min():.{digits}f} to {value.max():.{digits}f}{unit}")
    return ", ".join(parts)


def sheet_budgets(updated: Updated, sheet: SheetMaterial) -> dict[str, dict[str, float]]:
    """Return what makes up one standard deviation of each constant at the middle temperature.

    Shares of the constant, of nu_xy absolute; each with its `total`.
    """
    middle = int(np.argsort(updated.temperature)[len(updated.temperature) // 2])
    declared: tuple[DeclaredQuantity, ...] = updated.declared
    found = {}
    for place, one in enumerate(CONSTANTS):
        value = float(getattr(sheet.value, one.name)[middle])
        total = float(getattr(sheet.sigma, one.name)[middle]) / (value if one.unit else 1.0)
        rows = budget(declared, sheet.common[middle, place], float(sheet.noise[middle, place]))
        found[one.name] = {"total": total, **dict(rows)}
    return found


def declared_line(sheet: SheetMaterial) -> str:
    """Say how the sheet found is declared, for panels made of it."""
    angle = float(np.rad2deg(sheet.declared.angle))
    turned = f", angle = {angle:g}" if angle else ""
    return (
        "the laws in laws.h5 are those of the mean of Ex and Ey; declare the sheet of panels made of it as "
        f"orthotropy = {{ delta_e = {sheet.delta_e:.4f}, delta_g = {sheet.delta_g:.4f}{turned} }}"
    )
