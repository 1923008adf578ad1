"""Result of model updating."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_finite, check_shapes
from analysis.estimates import DeclaredQuantity, SheetMaterial
from analysis.labelled import Labelled, LabelledArrays
from analysis.material import Material, MaterialSigma

GOOD_MISFIT = 1.3
"""Misfit over the noise floor up to which a twin explains the data."""


@dataclass(frozen=True)
class Updated(Labelled):
    """Result of model updating, one row per sweep in the order of the FRFs.

    Attributes
    ----------
    temperature : (T,) ndarray
        Mean oven reading, degrees Celsius.
    material, sigma : Material, MaterialSigma
        Estimates and their standard deviations, (T,) arrays: that of the noise, inflated by sqrt(chi2_per_dof)
        where the twin misses more than the noise, and those of all that is declared with a tolerance.
    correlation : (T, 4, 4) ndarray
        Of log E, nu, log eta and log gain, as one sweep alone would see them.
    gain, sigma_gain : float
        Amplifier gain common to all sweeps, V/V; of those of the first input where there are several.
    misfit_start, misfit : (T,) ndarray
        rms|H - gV| / rms|H| where a sweep's fit began, and at the end.
    noise_floor : (T,) ndarray
        What the misfit would be were the twin perfect.
    chi2_per_dof : (T,) ndarray
    settled : (T,) bool ndarray
        False where the fit ran into the model's box or did not converge.
    further : (I - 1, 2) ndarray or None
        Gain and its standard deviation of every other input; None where there is but one.
    declared : tuple of DeclaredQuantity
        Those with a tolerance, as fitted.
    common : (T, 3, P + 1) ndarray or None
        What one standard deviation of each of the P moves in log E, nu and log eta, with sign, and last what the
        twin's own error does: errors that all sweeps share. None without tolerances.
    sheet : SheetMaterial or None
        Constants by direction of an orthotropic sheet, whose E and eta in `material` are means of two; None for an
        isotropic sheet.
    """

    temperature: NDArray[np.float64]
    material: Material
    sigma: MaterialSigma
    correlation: NDArray[np.float64]
    gain: float
    sigma_gain: float
    misfit_start: NDArray[np.float64]
    misfit: NDArray[np.float64]
    noise_floor: NDArray[np.float64]
    chi2_per_dof: NDArray[np.float64]
    settled: NDArray[np.bool_]
    further: NDArray[np.float64] | None = None
    declared: tuple[DeclaredQuantity, ...] = ()
    common: NDArray[np.float64] | None = None
    sheet: SheetMaterial | None = None

    def __post_init__(self) -> None:
        materials = ("material.youngs_modulus", "sigma.youngs_modulus")
        rows = (*materials, "misfit_start", "misfit", "noise_floor", "chi2_per_dof", "settled")
        check_shapes(self, temperature="T", correlation="T 4 4", common="T 3 P", **dict.fromkeys(rows, "T"))
        check_finite(self, "temperature", "gain")

    def labelled(self) -> LabelledArrays:
        """E, nu and eta with their standard deviations, misfit and noise, over sweep."""
        constants = {name: getattr(self.material, name) for name in vars(self.material)}
        sigmas = {f"sigma_{name}": getattr(self.sigma, name) for name in vars(self.sigma)}
        judged = {name: getattr(self, name) for name in ("misfit", "noise_floor", "chi2_per_dof", "settled")}
        return LabelledArrays(
            {name: (("sweep",), values) for name, values in (constants | sigmas | judged).items()},
            {"temperature": (("sweep",), self.temperature)},
            {"youngs_modulus": "Pa", "sigma_youngs_modulus": "Pa", "temperature": "degC"},
        )

    @property
    def sharpest(self) -> Material:
        """`material` with the least loss factor of all directions."""
        if self.sheet is None:
            return self.material
        return replace(self.material, loss_factor=self.sheet.value.rows[4:].min(axis=0))

    @property
    def shared(self) -> NDArray[np.float64]:
        """Return `common`, without columns where there are no tolerances, (T, 3, P)."""
        return np.zeros((self.temperature.size, 3, 0)) if self.common is None else self.common

    @property
    def departures(self) -> dict[str, dict[str, float]]:
        """Values of `declared` as the twin takes them, by name and parameter."""
        found: dict[str, dict[str, float]] = {}
        for one in self.declared:
            found.setdefault(one.name, {})[one.parameter] = one.value
        return found

    @property
    def own_sigma(self) -> MaterialSigma:
        """Standard deviations by each sweep's own noise, (T,) arrays."""
        m, total, common = self.material, self.sigma, (self.shared**2).sum(-1).T
        scales = (m.youngs_modulus, np.ones_like(m.poisson_ratio), m.loss_factor)
        rows = zip((total.youngs_modulus, total.poisson_ratio, total.loss_factor), scales, common, strict=True)
        return MaterialSigma(*(np.sqrt(np.maximum(t**2 - s**2 * c, (1e-6 * t) ** 2)) for t, s, c in rows))

    @property
    def gains(self) -> NDArray[np.float64]:
        """Gain of every input, (I,)."""
        return np.array([self.gain, *([] if self.further is None else self.further[:, 0])])

    @property
    def sigma_gains(self) -> NDArray[np.float64]:
        """Standard deviations of `gains`, (I,)."""
        return np.array([self.sigma_gain, *([] if self.further is None else self.further[:, 1])])

    @property
    def constants(self) -> list[tuple[float, float, float]]:
        """E [Pa], nu and eta of every sweep."""
        m = self.material
        return [
            (float(e), float(nu), float(eta))
            for e, nu, eta in zip(m.youngs_modulus, m.poisson_ratio, m.loss_factor, strict=True)
        ]
