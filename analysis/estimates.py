"""What a fit found, with standard deviations: a parameter, material laws, quantities declared with a tolerance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_finite, check_shapes
from analysis.sheet_material import SheetMaterial


@dataclass(frozen=True)
class Estimate:
    """A parameter's value and one standard deviation, inflated as those of `FittedLaws`, SI."""

    name: str
    value: float
    sigma: float
    unit: str


@dataclass(frozen=True)
class FittedLaws:
    """Laws at the groups' temperatures.

    Attributes
    ----------
    temperature : (G,) ndarray
        Degrees Celsius.
    value, sigma : (G, 3) ndarray
        log E [log Pa], nu and log eta, with standard deviations inflated where more than noise is left, and by the
        twin's own error.
    common : (G, 3, P + 1) ndarray or None
        What one standard deviation of each of P declared quantities moves in them, with sign, and last that of all
        else that the temperatures share, the twin's own error included. None without tolerances.
    sheet : SheetMaterial or None
        Constants by direction of an orthotropic sheet; None for an isotropic one.
    """

    temperature: NDArray[np.float64]
    value: NDArray[np.float64]
    sigma: NDArray[np.float64]
    common: NDArray[np.float64] | None = None
    sheet: SheetMaterial | None = None

    def __post_init__(self) -> None:
        check_shapes(self, temperature="G", value="G 3", sigma="G 3", common="G 3 P")
        check_finite(self, "temperature", "value")

    @property
    def shared(self) -> NDArray[np.float64]:
        """Return `common`, without columns where there are no tolerances, (G, 3, P)."""
        return np.zeros((self.temperature.size, 3, 0)) if self.common is None else self.common

    @property
    def own_sigma(self) -> NDArray[np.float64]:
        """Return the part of `sigma` that each temperature has for itself, (G, 3)."""
        own: NDArray[np.float64] = np.maximum(self.sigma**2 - (self.shared**2).sum(-1), (1e-6 * self.sigma) ** 2)
        return np.asarray(np.sqrt(own))


TOLERANCES = 3.0
"""Departure, in tolerances, from which a declaration is called wrong: one careful declaration in 400 is."""
WAYS = {"dx": " along x", "dy": " along y", "along": " (first side)", "across": " (second side)"}
"""How the parameters of a quantity that has two are told apart."""


@dataclass(frozen=True)
class DeclaredQuantity:
    """One quantity that is not exactly as declared.

    Attributes
    ----------
    name : str
        As in the twin.
    parameter, unit : str
    words : str
        What it is, for people.
    tolerance : float
        Standard deviation as declared, SI.
    value, sigma : float
        True less declared, or share of the declared one: estimate and its standard deviation.
    """

    name: str
    parameter: str
    unit: str
    words: str
    tolerance: float
    value: float
    sigma: float

    def __post_init__(self) -> None:
        if not self.tolerance > 0.0 or not np.isfinite([self.value, self.sigma]).all():
            raise ValueError(
                f"{self.name} {self.parameter}: {self.value:g} ± {self.sigma:g}, tolerance {self.tolerance:g}; "
                "finite numbers and a tolerance above 0 wanted"
            )

    @property
    def beyond(self) -> bool:
        """Whether the data push it beyond `TOLERANCES`."""
        return abs(self.value) > TOLERANCES * self.tolerance

    @property
    def sentence(self) -> str:
        """What was found, in words and in people's units."""
        factor, unit = {"m": (1e3, "mm"), "kg": (1e3, "g"), "K": (1.0, "K")}.get(self.unit, (100.0, "%"))
        along = WAYS.get(self.parameter, "")
        if self.unit == "log":
            factors = (float(np.exp(one)) for one in (self.value, self.tolerance))
            times, factor_of = (f"{one:.3g}" for one in factors)
            said = f"{self.words} ({self.parameter}): {times} times its declaration"
            return f"{said} (tolerance: a factor of {factor_of})"
        value, sigma, tolerance = (factor * one for one in (self.value, self.sigma, self.tolerance))
        said = f"{self.words}{along}: {value:+.2g} ± {sigma:.1g} {unit} from its declaration"
        return f"{said} (tolerance {tolerance:.2g})"


def doubts(quantities: Sequence[DeclaredQuantity]) -> list[str]:
    """Say which declarations the data push beyond `TOLERANCES`."""
    return [f"the declaration is doubtful: {one.sentence}" for one in quantities if one.beyond]


def budget(
    quantities: Sequence[DeclaredQuantity], common: NDArray[np.float64], noise: float
) -> list[tuple[str, float]]:
    """Contributions to one standard deviation, largest first; their squares add up to its square.

    Parameters
    ----------
    quantities : sequence of P DeclaredQuantity
    common : (P + 1,) ndarray
        What one standard deviation of each moves, and last the twin's own error.
    noise : float
        Standard deviation by noise.

    Returns
    -------
    list of (str, float)
        Kind of quantity, for all patches, axes and transducers together, and its share.
    """
    squares: dict[str, float] = {"noise": noise**2, "twin": float(common[-1]) ** 2}
    for quantity, share in zip(quantities, common[:-1], strict=True):
        kind = KINDS.get(quantity.name.split()[0], quantity.name.split()[0])
        squares[kind] = squares.get(kind, 0.0) + float(share) ** 2
    return sorted(((kind, float(np.sqrt(square))) for kind, square in squares.items()), key=lambda row: -row[1])


KINDS = {
    "plate_thickness": "thickness",
    "plate_mass": "mass",
    "plate_length_x": "lengths",
    "plate_length_y": "lengths",
    "oven_reading": "oven",
    "patch_place": "places of patches",
    "patch_size": "sizes of patches",
    "patch_thickness": "thickness of patches",
    "patch_modulus": "stiffness of patches",
    "strain_constant": "d31",
    "permittivity": "permittivity",
    "input_resistance": "inputs",
    "input_capacitance": "inputs",
    "sensitivity": "sensitivities",
    "transducer_place": "places of transducers",
    "transducer_mass": "masses of transducers",
    "transducer_contact": "contact areas of transducers",
    "attachment_place": "places of attachments",
    "place_contact": "contact of undeclared attachments",
    "plate_shear": "transverse shear",
    "plate_theory": "plate theory",
    "sheet_moduli": "ratios of moduli",
    "sheet_transverse_shear": "transverse shear",
    "sheet_loss": "ratios of losses",
}
"""How a budget names the quantities of a twin, by the first word of their names."""
