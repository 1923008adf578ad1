"""State of a plate during one sweep: fields over it, attachments to it, and factors on its signals.

Effects turn one state into another. All numbers in it are real, and every operation on it accepts complex numbers,
so that its derivatives with respect to an effect's parameters come from a complex step, exact to rounding (Squire
and Trapp, SIAM Review 40, 1998): no `abs`, no comparison of parameters, complex quantities as two real ones.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.arrays import Mask
from analysis.experiment import Experiment, Plate, Point
from analysis.material import LocalLaws
from analysis.recordings.sweep_point import SweepPoint
from simulation.state.departures import AS_DECLARED, Departures

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
