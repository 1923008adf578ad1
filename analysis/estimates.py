"""What a fit found, with standard deviations: a parameter, material laws, quantities declared with a tolerance.

Moduli, Poisson's ratio and loss factors of an orthotropic sheet by direction, from laws and constant ratios.

The laws give E = (E_x + E_y)/2, nu (the root of nu_xy nu_yx) and eta (the root of eta_x eta_y) at every
temperature; four logarithms r, s, p, q are constant, see `simulation.state.plate_state`. With the declared
R_0 = E_y/E_x and R = R_0 exp(r)

    E_x = 2 E/(1 + R),  E_y = R E_x,  G_xy = (1 + delta_g) exp(s) E / 2(1 + nu),  nu_xy = nu R**-0.5,
    eta_x = eta exp(-p/2),  eta_y = eta exp(p/2),  eta_G = eta exp(q).
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.checked_fields import check_finite, check_shapes
from analysis.material import Orthotropy

MODULI, TRANSVERSE, LOSS = "sheet_moduli", "sheet_transverse_shear", "sheet_loss"
"""Names of the declared quantities of a sheet."""
RATIOS = ((MODULI, "ratio"), (MODULI, "shear"), (LOSS, "ratio"), (LOSS, "shear"))
"""The logarithms r, s, p and q among them."""
ACROSS = ((TRANSVERSE, "xz"), (TRANSVERSE, "yz"))
"""Those of the transverse shear moduli: no constant that is reported, but wood's is far from any default."""


@dataclass(frozen=True)
class SheetConstants:
    """Constants of an orthotropic sheet in its own axes, or their standard deviations, (T,) arrays.

    Attributes
    ----------
    youngs_modulus_x, youngs_modulus_y, shear_modulus : (T,) ndarray
        Pa; shear in the plane.
    poisson_ratio_xy : (T,) ndarray
        Contraction along y over extension along x, under tension along x.
    loss_factor_x, loss_factor_y, loss_factor_shear : (T,) ndarray
        Of these three moduli.
    """

    youngs_modulus_x: NDArray[np.float64]
    youngs_modulus_y: NDArray[np.float64]
    shear_modulus: NDArray[np.float64]
    poisson_ratio_xy: NDArray[np.float64]
    loss_factor_x: NDArray[np.float64]
    loss_factor_y: NDArray[np.float64]
    loss_factor_shear: NDArray[np.float64]

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not np.isfinite(value).all() or np.any(value < 0.0):
                raise ValueError(f"constants of a sheet: {entry.name} is {value}; finite numbers from 0 wanted")

    @property
    def rows(self) -> NDArray[np.float64]:
        """All of them, (7, T)."""
        return np.array([getattr(self, entry.name) for entry in fields(self)])


@dataclass(frozen=True)
class SheetMaterial:
    """Constants of an orthotropic sheet at T sweeps or temperatures, and the constant ratios behind them.

    Attributes
    ----------
    declared : Orthotropy
    ratios : (4,) ndarray
        The logarithms r, s, p and q; 0 is as declared.
    value, sigma : SheetConstants
        Estimates and their total standard deviations, with the covariance of E, nu, eta and the ratios.
    common : (T, 7, P + 1) ndarray
        What one standard deviation of each declared quantity, and last the twin's own error, moves in the
        logarithm of each constant, with sign; of nu_xy itself.
    """

    declared: Orthotropy
    ratios: NDArray[np.float64]
    value: SheetConstants
    sigma: SheetConstants
    common: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        declared: Orthotropy,
        laws: NDArray[np.float64],
        ratios: NDArray[np.float64],
        covariance: NDArray[np.float64],
        common: NDArray[np.float64],
        own: NDArray[np.float64],
    ) -> Self:
        """Carry laws and ratios, and their covariance, to the constants by direction.

        Parameters
        ----------
        laws : (T, 3) ndarray
            log E [log Pa], nu and log eta.
        ratios : (4,) ndarray
        covariance : (T, 7, 7) ndarray
            Of laws and ratios: the total one.
        common : (T, 7, P) ndarray
            What one standard deviation of each declared quantity moves in laws and ratios.
        own : (T, 3) ndarray
            Variances of the laws by each sweep's noise.

        Returns
        -------
        SheetMaterial
        """
        value = _constants(declared, laws, ratios)
        slopes = _slopes(laws[:, 1], _apart(declared, ratios))
        variance = np.maximum(np.einsum("tij,tjk,tik->ti", slopes, covariance, slopes), 0.0)
        moved = slopes @ common
        noise = np.einsum("tij,tj->ti", slopes[:, :, :3] ** 2, own)
        twin = np.sqrt(np.maximum(variance - noise - (moved**2).sum(axis=2), 0.0))
        sigma = SheetConstants(*(np.sqrt(variance).T * _scale(value)))
        return cls(declared, ratios, value, sigma, np.concatenate([moved, twin[:, :, None]], axis=2))

    @property
    def delta_e(self) -> float:
        """(E_y - E_x)/(E_y + E_x) as found: as it may be declared."""
        apart = _apart(self.declared, self.ratios)
        return (apart - 1.0) / (apart + 1.0)

    @property
    def delta_g(self) -> float:
        """G_xy over E/2(1 + nu) less 1, as found: as it may be declared."""
        return float((1.0 + self.declared.delta_g) * np.exp(self.ratios[1]) - 1.0)

    @property
    def noise(self) -> NDArray[np.float64]:
        """What is left of `sigma` beside `common`, (T, 7), of the same logarithms."""
        total = (self.sigma.rows / _scale(self.value)).T
        left: NDArray[np.float64] = np.sqrt(np.maximum(total**2 - (self.common**2).sum(axis=2), 0.0))
        return left

    def at(self, laws: NDArray[np.float64], rows: NDArray[np.int_]) -> Self:
        """Return the constants for other laws, with the standard deviations of the temperatures `rows`.

        Parameters
        ----------
        laws : (S, 3) ndarray
            log E [log Pa], nu and log eta.
        rows : (S,) ndarray of int

        Returns
        -------
        SheetMaterial
        """
        value = _constants(self.declared, laws, self.ratios)
        relative = (self.sigma.rows / _scale(self.value))[:, rows]
        sigma = SheetConstants(*(relative * _scale(value)))
        return replace(self, value=value, sigma=sigma, common=self.common[rows])


NU_XY = 3
"""Place of nu_xy among the constants: the only one whose logarithm is not used."""


def _apart(declared: Orthotropy, ratios: NDArray[np.float64]) -> float:
    return float(declared.ratio * np.exp(ratios[0]))


def _constants(declared: Orthotropy, laws: NDArray[np.float64], ratios: NDArray[np.float64]) -> SheetConstants:
    apart, (_, s, p, q) = _apart(declared, ratios), ratios
    e, nu, eta = np.exp(laws[:, 0]), laws[:, 1], np.exp(laws[:, 2])
    return SheetConstants(
        youngs_modulus_x=2.0 * e / (1.0 + apart),
        youngs_modulus_y=2.0 * e * apart / (1.0 + apart),
        shear_modulus=(1.0 + declared.delta_g) * np.exp(s) * e / (2.0 * (1.0 + nu)),
        poisson_ratio_xy=nu / np.sqrt(apart),
        loss_factor_x=eta * np.exp(-0.5 * p),
        loss_factor_y=eta * np.exp(0.5 * p),
        loss_factor_shear=eta * np.exp(q),
    )


def _scale(value: SheetConstants) -> NDArray[np.float64]:
    """Of each constant (7, T) per unit of its logarithm; 1 of nu_xy."""
    scale = value.rows
    scale[NU_XY] = 1.0
    return scale


def _slopes(nu: NDArray[np.float64], apart: float) -> NDArray[np.float64]:
    """Differentiate the logarithms of the constants, and nu_xy itself, by log E, nu, log eta and the ratios."""
    found = np.zeros((nu.size, 7, 7))
    found[:, :3, 0] = 1.0  # both moduli and shear follow E
    found[:, 0, 3], found[:, 1, 3] = -apart / (1.0 + apart), 1.0 / (1.0 + apart)
    found[:, 2, 1], found[:, 2, 4] = -1.0 / (1.0 + nu), 1.0
    found[:, NU_XY, 1], found[:, NU_XY, 3] = apart**-0.5, -0.5 * nu * apart**-0.5
    found[:, 4:, 2] = 1.0
    found[:, 4, 5], found[:, 5, 5], found[:, 6, 6] = -0.5, 0.5, 1.0
    return found


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
        said = f"{self.words}{along}: {_short(value, 2, '+')} ± {_short(sigma, 1)} {unit} from its declaration"
        return f"{said} (tolerance {_short(tolerance, 2)})"


def _short(value: float, digits: int, sign: str = "") -> str:
    """Return a number with few digits, never as a power of ten."""
    return f"{value:{sign}.0f}" if abs(value) >= 10**digits else f"{value:{sign}.{digits}g}"


def doubts(quantities: Sequence[DeclaredQuantity]) -> list[str]:
    """Say which declarations the data push beyond `TOLERANCES`, and what else looks like one."""
    return [
        f"the declaration is doubtful: {one.sentence}{LOOKS_LIKE.get(one.name, '')}"
        for one in quantities
        if one.beyond
    ]


LOOKS_LIKE = {"plate_shear": "; a thickness declared some per cent wrong looks like this: measure it"}
"""What is added to a doubt. E h^3 follows from the resonances; what is left of an error of h is a wrong share of
shear and rotary inertia, which goes with h^2."""


TOLD = 0.5
"""Share of a tolerance up to which data have to narrow a quantity to tell it."""


def untold(quantities: Sequence[DeclaredQuantity]) -> tuple[str, ...]:
    """Names, for people, of the plate's declared quantities that E follows from and the data do not tell."""
    missing = [one for one in quantities if one.name in OF_E and one.sigma > TOLD * one.tolerance]
    return tuple(dict.fromkeys(KINDS[one.name] for one in missing))


OF_E = ("plate_thickness", "plate_mass", "plate_length_x", "plate_length_y")
"""What E follows from, besides the resonances."""


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
    "plate_lag": "lag of the plate",
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
