"""Departures of a plate from its declaration: what a careful workshop leaves open, and a sheet's moduli.

Lengths are changed by mapping the plate onto the declared outline, (X, Y) = (s_x x, s_y y), with w(X, Y) = w(x, y)
and rotations and in-plane displacements divided by the stretch along them. Curvatures and membrane strains along x
are then divided by s_x**2, those along y by s_y**2, shears by s_x s_y, and areas grow by s_x s_y: forms change by
powers of both stretches, and no mesh is needed. Patches are stretched with the plate: one that keeps its size is
as much smaller.

Of an orthotropic sheet the laws give E = (E_x + E_y)/2 and eta, the root of eta_x eta_y, at every temperature. All
else is constant over temperature: r = log of E_y/E_x over the declared ratio, s = log of the shear modulus in the
plane over the declared share of E/2(1 + nu), p = log(eta_y/eta_x), q = log of the loss factor of shear over eta.
With R = E_y/E_x

    E_x = 2 E/(1 + R),   E_y = 2 E R/(1 + R),   eta_x = eta exp(-p/2),   eta_y = eta exp(p/2).
"""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from analysis.declaration.plate_material import Orthotropy


@dataclass(frozen=True)
class Departures:
    """True over declared values; shifts and masses are true less declared ones.

    Numbers, or one for each of P patches, K outputs or S footprints; complex for a complex step.

    Attributes
    ----------
    thickness, mass, stretch_x, stretch_y : float
        Of the plate, which was weighed: its mass does not follow its thickness and its lengths.
    patch_thickness, patch_modulus, strain_constant, permittivity, patch_area : float or (P,) ndarray
        Of each patch; the modulus is a factor on all its stiffness, the strain constant is d31. The area is for
        its capacitance alone, and follows its sides.
    shift_x, shift_y, along, across : float or (P,) ndarray
        Of each patch's centre, and of its first and second side, m.
    resistance, capacitance : float
        Of the inputs.
    log_sensitivity : float or (K,) ndarray
        Natural logarithm of a factor on each output.
    place_x, place_y : float or (S,) ndarray
        Shift of each transducer's footprint, m.
    contact : float or (S,) ndarray
        Share by which the area of each footprint is larger; -1 for a point.
    added_mass : float or (S,) ndarray
        On each footprint, kg.
    attached_x, attached_y : float or (K,) ndarray
        Shift of each point where a string or a cable is attached, m.
    place_compliance : float
        Of the plate where something is attached that nobody declared, see `simulation.state.attached`.
    modulus_x, modulus_y, in_plane_shear, shear_x, shear_y : float
        Of an orthotropic sheet in its own axes: E_x, E_y, the shear modulus in the plane, and those of the planes
        xz and yz.
    loss_x, loss_y, loss_shear : float
        Of such a sheet: loss factors of E_x, of E_y and of all shear, over the laws' own.
    momentum : float
        Share of what elasticity adds to Mindlin's plate: the momentum is that of the mean deflection over the
        thickness, w - c h**2 div theta with c = nu / (60 (1 - nu)), see `simulation.verification.solids`.
    """

    thickness: Any = 1.0
    mass: Any = 1.0
    stretch_x: Any = 1.0
    stretch_y: Any = 1.0
    patch_thickness: Any = 1.0
    patch_modulus: Any = 1.0
    strain_constant: Any = 1.0
    permittivity: Any = 1.0
    patch_area: Any = 1.0
    shift_x: Any = 0.0
    shift_y: Any = 0.0
    along: Any = 0.0
    across: Any = 0.0
    resistance: Any = 1.0
    capacitance: Any = 1.0
    log_sensitivity: Any = 0.0
    place_x: Any = 0.0
    place_y: Any = 0.0
    contact: Any = 0.0
    added_mass: Any = 0.0
    attached_x: Any = 0.0
    attached_y: Any = 0.0
    place_compliance: Any = 1.0
    momentum: Any = 0.0
    modulus_x: Any = 1.0
    modulus_y: Any = 1.0
    in_plane_shear: Any = 1.0
    shear_x: Any = 1.0
    shear_y: Any = 1.0
    loss_x: Any = 1.0
    loss_y: Any = 1.0
    loss_shear: Any = 1.0

    @property
    def in_plane(self) -> tuple[Any, Any, Any, Any]:
        """Factors on Q11, Q22, Q12 and Q66 of the sheet."""
        return self.modulus_x, self.modulus_y, np.sqrt(self.modulus_x * self.modulus_y), self.in_plane_shear

    @property
    def lost(self) -> tuple[Any, Any, Any, Any]:
        """Factors on their loss factors: with the root for Q12 every motion dissipates."""
        return self.loss_x, self.loss_y, np.sqrt(self.loss_x * self.loss_y), self.loss_shear

    @property
    def moves(self) -> bool:
        """Whether a border of a patch moves."""
        return any(bool(np.any(getattr(self, name))) for name in MOVES)

    def along_moves(self, step: complex) -> "Departures":
        """Return the same with a step times its moves in place of them: for a derivative along them."""
        return replace(self, **{name: step * np.real(getattr(self, name)) for name in MOVES})

    def without_steps_of_moves(self) -> "Departures":
        """Return the same with its moves, of which an imaginary step is left out."""
        return replace(self, **{name: np.real(getattr(self, name)) for name in MOVES})

    @property
    def stepped_moves(self) -> bool:
        """Whether a move has an imaginary part."""
        return any(np.iscomplexobj(getattr(self, name)) for name in MOVES)

    @property
    def stepped(self) -> bool:
        """Whether any value has an imaginary part."""
        return any(np.iscomplexobj(getattr(self, entry.name)) for entry in fields(self))

    @property
    def stepped_plate(self) -> bool:
        """Whether a value that the matrices of plate and patches depend on has an imaginary part."""
        return any(np.iscomplexobj(getattr(self, name)) for name in OF_THE_PLATE)


MOVES = ("shift_x", "shift_y", "along", "across")
"""Departures that move borders of patches: the mesh moves with them."""
OF_THE_PLATE = (
    *MOVES,
    "thickness",
    "mass",
    "stretch_x",
    "stretch_y",
    "patch_thickness",
    "patch_modulus",
    "strain_constant",
    "momentum",
    "modulus_x",
    "modulus_y",
    "in_plane_shear",
    "shear_x",
    "shear_y",
    "loss_x",
    "loss_y",
    "loss_shear",
)
AS_DECLARED = Departures()
"""None."""
FARTHEST_MODULI, FARTHEST_SHEAR, FARTHEST_LOSS = 0.9, 3.5, 2.3
"""Largest logarithms: of the ratios of moduli, of transverse shear moduli and of loss factors. The vectors of a
reduced plate follow its moduli so far, see `SHEETS`."""
Sheet = tuple[float, float, float, float]
"""Logarithms r, s and those of the transverse shear moduli of the planes xz and yz."""
SHEETS: tuple[Sheet, ...] = (
    (0.8, 0.0, 0.0, 0.0),
    (-0.8, -0.8, -1.5, -1.5),
    (0.0, 0.8, 1.5, 1.5),
    (0.0, 0.0, -3.0, -3.0),
)
"""States for which vectors are added about the declared moduli: good for a start anywhere in the range."""
ABOUT: tuple[Sheet, ...] = (
    (0.0, 0.0, 0.0, 0.0),
    (0.1, 0.0, -0.3, -0.3),
    (-0.1, 0.0, 0.3, 0.3),
    (0.0, 0.1, 0.0, 0.0),
    (0.0, -0.1, 0.0, 0.0),
)
"""The same about moduli that are known from such a start."""
CERTIFIED: Sheet = (0.35, -0.35, -0.5, -0.5)
CERTIFIED_NEAR: Sheet = (0.05, -0.05, -0.1, -0.1)
"""States in which the error is measured, about the declared and about known moduli."""


def departed_moduli(sheet: Orthotropy, ratio: Any, shear: Any) -> dict[str, Any]:
    """Return factors on the declared moduli, by their names in `Departures`; shear in all planes.

    Parameters
    ----------
    ratio, shear : float
        The logarithms r and s; complex for a complex step.

    Returns
    -------
    dict
        The transverse moduli follow the one in the plane unless they were declared.
    """
    apart = sheet.ratio * np.exp(ratio)
    found = {
        "modulus_x": 2.0 / (1.0 + apart) / (1.0 - sheet.delta_e),
        "modulus_y": 2.0 * apart / (1.0 + apart) / (1.0 + sheet.delta_e),
        "in_plane_shear": np.exp(shear),
    }
    across = 1.0 if sheet.declared_transverse else found["in_plane_shear"]
    return {**found, "shear_x": across, "shear_y": across}


def departed_transverse(xz: Any, yz: Any) -> dict[str, Any]:
    """Return factors on the transverse shear moduli of the planes xz and yz from their logarithms."""
    return {"shear_x": np.exp(xz), "shear_y": np.exp(yz)}


def departed_loss(ratio: Any, shear: Any) -> dict[str, Any]:
    """Return factors on the laws' loss factor from the logarithms p and q."""
    return {"loss_x": np.exp(-0.5 * ratio), "loss_y": np.exp(0.5 * ratio), "loss_shear": np.exp(shear)}
