"""Reduced matrices whose weighted sums describe a plate in any state."""

from dataclasses import dataclass, field, fields
from functools import cached_property
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Real
from analysis.material import MaterialBox

BENDING_DEGREE, MEMBRANE_DEGREE = 3, 2
"""Largest total degrees of the fields that multiply bending energy, and membrane, shear and inertia.

With tapers of 5 % and differences of 7 K together, the truncation error is 1e-4 of a transfer's peak; with one
degree less, 2e-3.
"""

DISCRETIZATION_FACTOR = 2.0
"""Factor from `dropped` over the loss factor to the error against a finer mesh: 0.3 to 1.1 measured."""

OFFSET_DEGREE = 6
"""Total degree of the effect of a sensor offset, as a polynomial of the offset."""
ZONE_DEGREES = {"bending": 1, "membrane": 0, "shear": 1, "mass": 1}
"""Total degrees of the fields over the elements that stretch when the sensor moves."""
OFFSETS_KEPT = 8
"""Number of offsets, derivatives included, whose energies are kept."""
KEEPING = Lock()
"""Held while they are looked up or stored: sweeps are linearised in several threads."""


def truncation_error(dropped: float, loss_factor: float) -> float:
    """Estimate the error of a transfer by functions left out, as a share of its rms.

    If they hold a share `dropped` of a response's energy, a natural frequency is too high by half of it, relative,
    and a response near resonance changes by `dropped` over the loss factor.
    """
    return DISCRETIZATION_FACTOR * dropped / loss_factor


def monomials(x: Any, y: Any) -> NDArray[Any]:
    """Products of powers of x and y with total degree 1 to `OFFSET_DEGREE`."""
    return np.array([x ** (n - j) * y**j for n in range(1, OFFSET_DEGREE + 1) for j in range(n + 1)])


@dataclass(frozen=True)
class EffectOperators:
    """Real symmetric (r, r) matrices, one stack for each kind of field.

    The first coordinates are those of the plain reduction; the mass of the plate as declared is the identity.

    Attributes
    ----------
    bending, membrane : (4, terms, r, r) ndarray
        Energies of Q11, Q22, Q12, Q66 with every polynomial, for a modulus of 1 Pa and the nominal thickness.
    shear : (S, terms, r, r) ndarray
        Transverse shear energy for E/2(1 + nu) = 1 Pa, shear factor included: S is 1, or of orthotropic sheets 2,
        of the planes xz and yz.
    mass, rotary : (terms, r, r) ndarray
        Inertia of the plate as declared, per unit field: of displacements, of rotations.
    normal : (r, r) ndarray
        Integral of w times w, m2.
    damping : (r, r) ndarray
        Of the supports' dashpots, N s/m.
    patch_own : (r, r) ndarray
        Bending about their own mid-height and shear of all patches, N/m.
    patch_membrane : (1 + 2 terms, r, r) ndarray
        Membrane stiffness of all patches at their mid-height: as declared, then the factors of tau (plate
        thickness over nominal less 1) and of tau squared, polynomial by polynomial.
    patch_mass : (r, r) ndarray
    patch_alone, patch_thicker, patch_mass_alone : (P, r, r) ndarray
        Stiffness of each patch as declared, N/m, its derivative by the patch's relative thickness, and its mass. A
        ceramic is thirty times stiffer than a plastic plate, what changes with its moduli is a small difference of
        large forces: the motions of `patch_zone` do not tell it.
    thicker_coupling : (P, r) ndarray
        Derivative of each patch's coupling by its relative thickness.
    coupling : (1 + terms, r, P) ndarray
        Of every patch: as declared, and the factors of tau.
    capacitance : (P,) ndarray
    zone : (q, r) ndarray
        Coordinates -> the q motions that the elements around the first sensor can make.
    offset_bending, offset_membrane : (4, powers, monomials, q, q) ndarray
        Change of these motions' energies with the sensor's offset, for moduli that are powers of xi and zeta
        counted from the middle of the zone that stretches; ``offset_shear`` and ``offset_mass``
        (powers, monomials, q, q) likewise.
    zone_fit : (powers, terms) ndarray
        Fields as polynomials over the plate -> as those powers, least squares over the zone.
    strain : (8, N, r) ndarray
        Strains of every coordinate at points over the plate: membrane x, y, xy; curvature x, y, xy; transverse
        shear x, y, times the roots of the sheet's moduli over E/2(1 + nu); all in the sheet's own axes. They give
        the effect of local changes smaller than any polynomial resolves. In a thickness zone they are scaled so
        that with the plate's own thickness they have the zone's energies.
    sheet : (3,) ndarray
        Declared factors of E_x, E_y and the in-plane shear modulus in these axes.
    strain_points : (N, 2) ndarray
        m; the middles of equal cells that cover the plate.
    cell : float
        Area of a cell, m2.
    thickness : float
        Of the plate, m.
    points : (K, 2) ndarray
        Points for point loads, m.
    deflection : (K, r) ndarray
        w there.
    box : MaterialBox
    band : (float, float)
        Hz.
    offset_range : float
        Largest offset along x or y, m.
    error : float
        Largest error of any transfer between patches and the first footprints, over its peak along the band,
        against the full model as declared and with all effects at half of their certified ranges at once.
    places : (G, 2) ndarray
        Places all over the plate at which something undeclared may be attached, m, `place_spacing` m apart.
    place_deflection : (G, r) ndarray
        w there, the mean over an attachment's disc.
    place_compliance : (G,) ndarray
        Static compliance there that the coordinates lack, times Young's modulus, 1/m.
    footprints : (S, r) ndarray
        Mean deflection over the footprints of transducers, in the order of `Experiment.footprints`.
    movable : (P,) ndarray
        1 for patches with room around them, else 0.
    patch_zone : (P, q, r) ndarray
        Coordinates -> the motions that the cells under and around each patch can make, for its moves.
    moved_plane : (P, 4, 4, q, q) ndarray
        Derivative of the in-plane energies of Q11, Q22, Q12 and Q66, for a modulus of 1 Pa and the nominal
        thickness, by a patch's shift along x and y, and by its first and second side, 1/m; ``moved_shear``,
        ``moved_mass`` with the patch's own mass, and ``moved_fixed``, its stiffness, (P, 4, q, q) likewise.
    moved_coupling : (P, 4, q) ndarray
        Likewise, of its own coupling.
    footprint_slopes : (3, S, r) ndarray
        Derivatives of `footprints` by shifts along x and y, 1/m, and by the share by which their area is larger;
        ``deflection_slopes`` (2, K, r) of `deflection`, by shifts.
    momentum : (r, r) ndarray
        Change of the mass by the momentum of the mean deflection, see docs/theory/twin.md, for a
        share c of 1.
    angle : float
        Of the sheet's x axis against the plate's, rad.
    plain_error : float
        Of the plain reduction, see `ReducedModel.error`.
    dropped : float
        See `ShellModel.dropped`.
    """

    bending: Real
    membrane: Real
    shear: Real
    mass: Real
    rotary: Real
    normal: Real
    damping: Real
    patch_own: Real
    patch_membrane: Real
    patch_mass: Real
    coupling: Real
    capacitance: Real
    zone: Real
    offset_bending: Real
    offset_membrane: Real
    offset_shear: Real
    offset_mass: Real
    zone_fit: Real
    strain: Real
    sheet: Real
    strain_points: Real
    cell: float
    thickness: float
    points: Real
    deflection: Real
    box: MaterialBox
    band: tuple[float, float]
    offset_range: float
    error: float
    places: Real = field(default_factory=lambda: np.zeros((0, 2)))
    place_deflection: Real = field(default_factory=lambda: np.zeros((0, 0)))
    place_compliance: Real = field(default_factory=lambda: np.zeros(0))
    place_spacing: float = 1.0
    footprints: Real = field(default_factory=lambda: np.zeros((0, 0)))
    patch_alone: Real = field(default_factory=lambda: np.zeros((0, 0, 0)))
    patch_thicker: Real = field(default_factory=lambda: np.zeros((0, 0, 0)))
    patch_mass_alone: Real = field(default_factory=lambda: np.zeros((0, 0, 0)))
    thicker_coupling: Real = field(default_factory=lambda: np.zeros((0, 0)))
    movable: Real = field(default_factory=lambda: np.zeros(0))
    patch_zone: Real = field(default_factory=lambda: np.zeros((0, 0, 0)))
    moved_plane: Real = field(default_factory=lambda: np.zeros((0, 4, 4, 0, 0)))
    moved_shear: Real = field(default_factory=lambda: np.zeros((0, 4, 0, 0)))
    moved_mass: Real = field(default_factory=lambda: np.zeros((0, 4, 0, 0)))
    moved_fixed: Real = field(default_factory=lambda: np.zeros((0, 4, 0, 0)))
    moved_coupling: Real = field(default_factory=lambda: np.zeros((0, 4, 0)))
    footprint_slopes: Real = field(default_factory=lambda: np.zeros((3, 0, 0)))
    deflection_slopes: Real = field(default_factory=lambda: np.zeros((2, 0, 0)))
    momentum: Real = field(default_factory=lambda: np.zeros((0, 0)))
    angle: float = 0.0
    plain_error: float = 0.0
    dropped: float = 0.0

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray) and not np.isfinite(value).all():
                raise ValueError(f"effect operators: {entry.name} holds values that are not finite")

    @property
    def size(self) -> int:
        """Number of coordinates r."""
        return len(self.normal)

    def numerical_error(self, loss_factor: float) -> float:
        """Estimate the error of a transfer without effects by truncation and reduction, as a share of its rms."""
        return self.plain_error + truncation_error(self.dropped, loss_factor)

    def offset_energies(self, place: Real) -> dict[str, Real]:
        """Return changes of energies around the first sensor by monomials of its offset, or their derivatives.

        The last few are kept: all sweeps of a fit share an offset, and the whole stacks take 27 times as long.

        Parameters
        ----------
        place : (monomials,) ndarray

        Returns
        -------
        dict of str to ndarray
            ``bending`` and ``membrane`` (4, powers, q, q), ``shear`` and ``mass`` (powers, q, q).
        """
        key = place.tobytes()
        with KEEPING:
            found = self._offsets.get(key)
        if found is None:
            found = {}
            for name in ZONE_DEGREES:
                stack: Real = getattr(self, f"offset_{name}")
                flat = stack.reshape(-1, stack.shape[-3], stack.shape[-1] ** 2)
                found[name] = (place @ flat).reshape(*stack.shape[:-3], *stack.shape[-2:])
            with KEEPING:
                self._offsets[key] = found
                if len(self._offsets) > OFFSETS_KEPT:
                    del self._offsets[next(iter(self._offsets))]
        return found

    @cached_property
    def _offsets(self) -> dict[bytes, dict[str, Real]]:
        return {}

    @property
    def forces(self) -> Real:
        """Forces at points and footprints, one a column, (r, K + S)."""
        return np.vstack([self.deflection, self.footprints]).T if len(self.footprints) else self.deflection.T
