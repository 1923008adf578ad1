"""Constants of an orthotropic sheet by direction: as JSON, as tables, in a line, and as a panel declares them."""

from typing import Any, NamedTuple

import numpy as np

from analysis.estimates import DeclaredQuantity, budget
from analysis.sheet_material import SheetConstants, SheetMaterial
from analysis.updated import Updated
from app.summaries.table import Table


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
