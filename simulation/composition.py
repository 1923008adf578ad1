"""A plate in one state, composed of reduced matrices."""

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from simulation.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE, EffectOperators
from simulation.field_basis import field_basis
from simulation.plate_state import PlateState

Real = NDArray[np.float64]
Numbers = NDArray[Any]

STEP = 1e-30
"""Imaginary part of a parameter by which derivatives are taken: far below rounding of the real part."""


@dataclass(frozen=True)
class Coefficients:
    """Factors of the stacks of `EffectOperators`; complex where a state was stepped into the complex plane.

    Attributes
    ----------
    bending, bending_loss, membrane, membrane_loss : (4, terms) ndarray
        Pa.
    shear, shear_loss : (terms,) ndarray
        Pa.
    mass, rotary : (terms,) ndarray
    patch : (1 + 2 terms,) ndarray
    coupling : (1 + terms,) ndarray
    offset : (monomials,) ndarray
    offset_moduli : (2,) ndarray
        C1 and C2 at the mean temperature, Pa; `offset_loss` the same times the loss factor.
    """

    bending: Numbers
    bending_loss: Numbers
    membrane: Numbers
    membrane_loss: Numbers
    shear: Numbers
    shear_loss: Numbers
    mass: Numbers
    rotary: Numbers
    patch: Numbers
    coupling: Numbers
    offset: Numbers
    offset_moduli: Numbers
    offset_loss: Numbers

    @classmethod
    def of(cls, state: PlateState, offset_range: float) -> Self:
        """Project the fields of `state`, which stand at the points of `field_basis`."""
        fine, coarse = field_basis(BENDING_DEGREE), field_basis(MEMBRANE_DEGREE)
        nu = state.laws.poisson_ratio(state.temperature)
        c1 = state.laws.youngs_modulus(state.temperature) / (1.0 - nu**2)
        loss = state.laws.loss_factor(state.temperature)
        shear = 0.5 * c1 * (1.0 - nu)
        moduli = [
            c1 * state.modulus_x,
            c1 * state.modulus_y,
            c1 * nu * np.sqrt(state.modulus_x * state.modulus_y),
            shear * state.in_plane_shear,
        ]
        h, tau = state.thickness, state.thickness - 1.0
        mean_nu = state.laws.poisson_ratio(state.mean_temperature)
        mean_c1 = state.laws.youngs_modulus(state.mean_temperature) / (1.0 - mean_nu**2)
        pair = np.array([mean_c1, mean_nu * mean_c1])
        one = np.ones(1)
        return cls(
            bending=np.array([fine.coefficients(m * h**3) for m in moduli]),
            bending_loss=np.array([fine.coefficients(m * loss * h**3) for m in moduli]),
            membrane=np.array([coarse.coefficients(m * h) for m in moduli]),
            membrane_loss=np.array([coarse.coefficients(m * loss * h) for m in moduli]),
            shear=coarse.coefficients(shear * h),
            shear_loss=coarse.coefficients(shear * loss * h),
            mass=coarse.coefficients(h),
            rotary=coarse.coefficients(h**3),
            patch=state.bond * np.concatenate([one, fine.coefficients(tau), fine.coefficients(tau**2)]),
            coupling=state.bond * np.concatenate([one, fine.coefficients(tau)]),
            offset=monomials(state.offset_x / offset_range, state.offset_y / offset_range),
            offset_moduli=pair,
            offset_loss=pair * state.laws.loss_factor(state.mean_temperature),
        )


OFFSET_DEGREE = 5


def monomials(x: Any, y: Any) -> Numbers:
    """Products of powers of x and y with total degree 1 to `OFFSET_DEGREE`."""
    return np.array([x ** (n - j) * y**j for n in range(1, OFFSET_DEGREE + 1) for j in range(n + 1)])


@dataclass(frozen=True)
class Composite:
    """Reduced matrices of one state, or their derivative by a parameter.

    Attributes
    ----------
    plate, plate_loss : (r, r) ndarray
        Real part of the plate's stiffness, and imaginary part, before any factor over frequency.
    fixed : (r, r) ndarray
        Stiffness of the patches.
    mass : (r, r) ndarray
    coupling : (r, P) ndarray
    """

    plate: Real
    plate_loss: Real
    fixed: Real
    mass: Real
    coupling: Real


def composed(ops: EffectOperators, c: Coefficients) -> Composite:
    """Sum the stacks with real coefficients."""
    plate = _summed(c.bending, ops.bending) + _summed(c.membrane, ops.membrane) + _summed(c.shear, ops.shear)
    loss = _summed(c.bending_loss, ops.bending) + _summed(c.membrane_loss, ops.membrane)
    loss += _summed(c.shear_loss, ops.shear)
    fixed = ops.patch_own + _summed(c.patch, ops.patch_membrane)
    mass = ops.patch_mass + _summed(c.mass, ops.mass) + _summed(c.rotary, ops.rotary)
    coupling = np.tensordot(c.coupling, ops.coupling, 1)
    if c.offset.any():
        first, second = _summed(c.offset, ops.offset_1), _summed(c.offset, ops.offset_2)
        plate += c.offset_moduli[0] * first + c.offset_moduli[1] * second
        loss += c.offset_loss[0] * first + c.offset_loss[1] * second
        mass += _summed(c.offset, ops.offset_mass)
    return Composite(plate, loss, fixed, mass, coupling)


def slope(ops: EffectOperators, value: Coefficients, stepped: Coefficients) -> Composite:
    """Differentiate by the parameter whose imaginary step of `STEP` gave `stepped`; `value` is the state itself."""
    d = {name: np.imag(getattr(stepped, name)) / STEP for name in value.__dataclass_fields__}
    plate = _summed(d["bending"], ops.bending) + _summed(d["membrane"], ops.membrane)
    plate += _summed(d["shear"], ops.shear)
    loss = _summed(d["bending_loss"], ops.bending) + _summed(d["membrane_loss"], ops.membrane)
    loss += _summed(d["shear_loss"], ops.shear)
    fixed = _summed(d["patch"], ops.patch_membrane)
    mass = _summed(d["mass"], ops.mass) + _summed(d["rotary"], ops.rotary)
    coupling = np.tensordot(d["coupling"], ops.coupling, 1)
    if value.offset.any() or d["offset"].any():
        for place, moduli, by in (
            (value.offset, d["offset_moduli"], d["offset_loss"]),
            (d["offset"], value.offset_moduli, value.offset_loss),
        ):
            first, second = _summed(place, ops.offset_1), _summed(place, ops.offset_2)
            plate += moduli[0] * first + moduli[1] * second
            loss += by[0] * first + by[1] * second
        mass += _summed(d["offset"], ops.offset_mass)
    return Composite(plate, loss, fixed, mass, coupling)


def _summed(coefficients: Numbers, stack: Real) -> Real:
    """Sum of coefficients times matrices, vanishing ones skipped, (r, r)."""
    flat = np.ravel(coefficients)
    matrices = stack.reshape(-1, *stack.shape[-2:])
    used = np.flatnonzero(flat)
    return np.asarray(np.tensordot(flat[used], matrices[used], 1))
