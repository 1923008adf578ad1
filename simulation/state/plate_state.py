"""State of a plate during one sweep: fields over it, attachments to it, and factors on its signals.

Effects turn one state into another. All numbers in it are real, and every operation on it accepts complex numbers,
so that its derivatives with respect to an effect's parameters come from a complex step, exact to rounding (Squire
and Trapp, SIAM Review 40, 1998): no `abs`, no comparison of parameters, complex quantities as two real ones.

Departures of a plate from its declaration: what a careful workshop leaves open, and a sheet's moduli.

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

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Mask
from analysis.experiment import Experiment, Plate, Point
from analysis.material import LocalLaws, Orthotropy
from analysis.recordings.sweep_point import SweepPoint


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
        thickness, w - c h**2 div theta with c = nu / (60 (1 - nu)), see docs/theory/twin.md.
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


Field = NDArray[Any]
"""Values at the sampling points, (Q,)."""
Spectrum = NDArray[Any]
"""Values at the frequencies, (F,)."""
SPECTRA = ("storage", "loss", "area_mass", "area_resistance")
"""Attributes of a state by which its impedance differs from line to line."""


@dataclass(frozen=True)
class Circumstances:
    """Quantities on which an effect may depend in addition to the plate's state.

    Attributes
    ----------
    frequency : (F,) ndarray
        Hz.
    point : SweepPoint
    room_temperature : float
        Degrees Celsius.
    plate : Plate
    strings, cables : tuple of points
        Points of strings and of cables, m.
    band : (float, float)
        Of the campaign, Hz.
    patches : tuple of str
        Names of the P patches, in their order.
    unweighed : (S,) bool ndarray
        Footprints of accelerometers that are declared without a mass.
    strain_energy : (F,) ndarray
        Relative strain energy: of the plate with all effects at this sweep's level, over its maximum without
        effects from 100 to 1500 Hz at 25 degrees Celsius and level 1 V; complex where derivatives are taken; ones
        if not computed.
    """

    frequency: NDArray[np.float64]
    point: SweepPoint
    room_temperature: float
    plate: Plate
    strings: tuple[Point, ...]
    cables: tuple[Point, ...]
    band: tuple[float, float]
    strain_energy: Spectrum
    patches: tuple[str, ...] = ()
    unweighed: Mask = field(default_factory=lambda: np.zeros(0, dtype=bool))

    @classmethod
    def of(cls, experiment: Experiment, point: SweepPoint, frequency: NDArray[np.float64]) -> "Circumstances":
        """Take the declared quantities of an experiment; the strain energy is set to ones.

        Parameters
        ----------
        frequency : (F,) ndarray, Hz
        """
        return cls(
            frequency=frequency,
            point=point,
            room_temperature=experiment.oven.room_temperature,
            plate=experiment.plate,
            strings=tuple(a.point for a in experiment.string),
            cables=tuple(a.point for a in experiment.cable),
            band=experiment.protocol.band,
            strain_energy=np.ones(frequency.size),
            patches=tuple(patch.id for patch in experiment.patch),
            unweighed=unweighed(experiment),
        )


def unweighed(experiment: Experiment) -> Mask:
    """Footprints (S,) of accelerometers that are declared without a mass, each at one point.

    One that is moved from point to point loads one of them at a time, which no single plate does.
    """
    still = {one.id for one in experiment.sensor if one.kind == "acceleration" and one.point is not None}
    still |= {one.id for one in experiment.drive if one.accelerometer}
    channels = (*experiment.inputs, *experiment.outputs)
    feet = [(channel.id, channel.footprint) for channel in channels if channel.footprint is not None]
    return np.array([name in still and not foot.mass for name, foot in feet], dtype=bool)


@dataclass(frozen=True)
class PointLoad:
    """A spring, a dashpot and a mass on the normal motion of one point.

    Attributes
    ----------
    point : (float, float)
        m.
    stiffness, damping, mass : float
        N/m, N s/m, kg.
    """

    point: Point
    stiffness: Any = 0.0
    damping: Any = 0.0
    mass: Any = 0.0


@dataclass(frozen=True)
class Attached:
    """Something on the normal motion of any place.

    Attributes
    ----------
    x, y : float
        m.
    stiffness, loss : (F,) ndarray
        Real and imaginary part of its dynamic stiffness, N/m: -w**2 m of a mass, k of a spring, j w c of a
        dashpot.
    """

    x: Any
    y: Any
    stiffness: Spectrum
    loss: Spectrum

    @property
    def acts(self) -> bool:
        """Whether it is more than a derivative at zero."""
        return bool(np.any(np.real(self.stiffness)) or np.any(np.real(self.loss)))


@dataclass(frozen=True)
class Disc:
    """A round spot whose plate modulus is multiplied by 1 - loss.

    Attributes
    ----------
    x, y, radius : float
        m.
    loss : float
    """

    x: Any
    y: Any
    radius: Any
    loss: Any


@dataclass(frozen=True)
class PlateState:
    """A plate during one sweep.

    Attributes
    ----------
    xi, zeta : (Q,) ndarray
        Sampling points of the fields: -1 to 1 over the box around the plate, see `Plate.normalised`.
    laws : LocalLaws
        The material, by local temperature.
    temperature : (Q,) ndarray
        Of the plate, degrees Celsius.
    thickness : (Q,) ndarray
        Over the nominal one.
    modulus, density : (Q,) ndarray
        Over those of the material: of all moduli at a place, and of the mass per volume.
    modulus_x, modulus_y, in_plane_shear, transverse_shear : float
        E_x/E, E_y/E, and the in-plane and the transverse shear modulus over E/2(1 + nu).
    loss_x, loss_y, loss_cross, loss_shear : float
        Loss factors of Q11, Q22 and Q12, and of both shear moduli, over the material's.
    storage, loss : (F,) ndarray
        Factors over frequency on the real and on the imaginary part of the plate's modulus.
    area_mass, area_resistance : (F,) ndarray
        On normal motion, kg/m2 and N s/m3.
    area_stiffness : float
        Likewise, N/m3.
    point_loads : tuple of PointLoad
    attached : tuple of Attached
    discs : tuple of Disc
    bond : float
        Factor on the membrane stiffness of every patch at its mid-height, and on its coupling.
    offset_x, offset_y : float
        Offset of the first sensor patch from its declared place, m.
    log_gain, phase : (F,) ndarray
        Natural log of the magnitude, and phase [rad], of a factor on every response.
    feedthrough, crosstalk : float or (F,) ndarray
        Real and imaginary part of what is added to every response after that factor, V/V.
    patch_loss : float
        Loss factor of the patches' membrane stiffness at their mid-height.
    debonded : float or (P,) ndarray
        Share of each patch that does not hold to the plate.
    departures : Departures
        Of the plate as it is from the plate as declared. The rest of the state is relative to the plate as it is.
    """

    xi: Field
    zeta: Field
    laws: LocalLaws
    temperature: Field
    thickness: Field
    modulus: Field
    density: Field
    storage: Spectrum
    loss: Spectrum
    area_mass: Spectrum
    area_resistance: Spectrum
    log_gain: Spectrum
    phase: Spectrum
    modulus_x: Any = 1.0
    modulus_y: Any = 1.0
    in_plane_shear: Any = 1.0
    transverse_shear: Any = 1.0
    loss_x: Any = 1.0
    loss_y: Any = 1.0
    loss_cross: Any = 1.0
    loss_shear: Any = 1.0
    area_stiffness: Any = 0.0
    point_loads: tuple[PointLoad, ...] = ()
    attached: tuple[Attached, ...] = ()
    discs: tuple[Disc, ...] = ()
    bond: Any = 1.0
    offset_x: Any = 0.0
    offset_y: Any = 0.0
    feedthrough: Any = 0.0
    crosstalk: Any = 0.0
    patch_loss: Any = 0.0
    debonded: Any = 0.0
    departures: Departures = AS_DECLARED

    @classmethod
    def baseline(
        cls, xi: Field, zeta: Field, laws: LocalLaws, temperature: float, frequency: NDArray[np.float64]
    ) -> "PlateState":
        """Return the plate as declared, at a uniform temperature, without effects.

        Parameters
        ----------
        xi, zeta : (Q,) ndarray
            Sampling points of the fields, -1 to 1.
        temperature : float
            °C.
        frequency : (F,) ndarray, Hz
        """
        ones, zeros = np.ones(frequency.size), np.zeros(frequency.size)
        return cls(
            xi=xi,
            zeta=zeta,
            laws=laws,
            temperature=np.full(xi.size, temperature),
            thickness=np.ones(xi.size),
            modulus=np.ones(xi.size),
            density=np.ones(xi.size),
            storage=ones,
            loss=ones,
            area_mass=zeros,
            area_resistance=zeros,
            log_gain=zeros,
            phase=zeros,
        )

    @property
    def mean_temperature(self) -> Any:
        """Mean over the sampling points, degrees Celsius."""
        return np.mean(self.temperature)

    def with_(self, **changes: Any) -> "PlateState":
        """Return a copy with some attributes replaced."""
        return replace(self, **changes)
