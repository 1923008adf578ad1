"""Reduced matrices of a plate in one state, summed from the operators."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from analysis.arrays import Numbers, Real
from simulation.reduction.effect_operators import BENDING_DEGREE, MEMBRANE_DEGREE, EffectOperators, monomials
from simulation.state.field_basis import field_basis
from simulation.state.plate_state import PlateState

STEP = 1e-30
"""Complex step of a parameter for derivatives: far below rounding of the real part."""


@dataclass(frozen=True)
class Coefficients:
    """Factors of the stacks of `EffectOperators`; complex for a state with a complex step.

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

    @classmethod
    def of(cls, state: PlateState, offset_range: float) -> Self:
        """Project the fields of `state`, given at the points of `field_basis`."""
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
        )


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


def proportion(a: Real, b: Real) -> float | None:
    """Return c if a = c b, as for a loss proportional to a stiffness, which saves a product; else None."""
    place = np.unravel_index(np.argmax(np.abs(b)), b.shape)
    c = float(a[place] / b[place]) if b[place] else 0.0
    return c if np.abs(a - c * b).max() <= 1e-13 * abs(float(a[place])) else None


def composed(ops: EffectOperators, c: Coefficients) -> Composite:
    """Sum the stacks with real coefficients."""
    whole = _plain(ops, c)
    fixed = ops.patch_own + whole.fixed
    mass = ops.patch_mass + whole.mass
    if not c.offset.any():
        return replace(whole, fixed=fixed, mass=mass)
    moved = OffsetPart.of(ops, c, c.offset).on(ops.zone)
    return Composite(
        whole.plate + moved.plate, whole.plate_loss + moved.plate_loss, fixed, mass + moved.mass, whole.coupling
    )


def _plain(ops: EffectOperators, c: Coefficients) -> Composite:
    """Sum the stacks with the sensor at its declared place."""
    return Composite(
        plate=_summed(c.bending, ops.bending) + _summed(c.membrane, ops.membrane) + _summed(c.shear, ops.shear),
        plate_loss=_summed(c.bending_loss, ops.bending)
        + _summed(c.membrane_loss, ops.membrane)
        + _summed(c.shear_loss, ops.shear),
        fixed=_summed(c.patch, ops.patch_membrane),
        mass=_summed(c.mass, ops.mass) + _summed(c.rotary, ops.rotary),
        coupling=np.tensordot(c.coupling, ops.coupling, 1),
    )


@dataclass(frozen=True)
class OffsetPart:
    """Changes of a plate's matrices by the sensor's offset, over the motions around the sensor or coordinates.

    Attributes
    ----------
    plate, plate_loss, mass : (q, q) or (r, r) ndarray
        As in `Composite`; patches and coupling do not change.
    """

    plate: Real
    plate_loss: Real
    mass: Real

    @classmethod
    def of(cls, ops: EffectOperators, c: Coefficients, place: Real) -> Self:
        """Sum the changes with moduli, thickness and inertia around the sensor, over the q motions there.

        Parameters
        ----------
        ops : EffectOperators
        c : Coefficients
            Of the state, or their derivative; real.
        place : (monomials,) ndarray
            Monomials of the offset, or their derivative.

        Returns
        -------
        OffsetPart
        """
        energies = ops.offset_energies(place)

        def summed(name: str, coefficients: Numbers) -> Real:
            stack = energies[name]
            return _summed(coefficients @ ops.zone_fit[: stack.shape[-3], : coefficients.shape[-1]].T, stack)

        return cls(
            summed("bending", c.bending) + summed("membrane", c.membrane) + summed("shear", c.shear),
            summed("bending", c.bending_loss)
            + summed("membrane", c.membrane_loss)
            + summed("shear", c.shear_loss),
            summed("mass", c.mass),
        )

    def on(self, zone: Real) -> Self:
        """Return the part over coordinates whose motions around the sensor are `zone` (q, r)."""
        plate, plate_loss, mass = (zone.T @ one @ zone for one in (self.plate, self.plate_loss, self.mass))
        return type(self)(plate, plate_loss, mass)


def _summed(coefficients: Numbers, stack: Real) -> Real:
    """Sum of coefficients times matrices, vanishing ones skipped, (r, r)."""
    flat = np.ravel(coefficients)
    matrices = stack.reshape(-1, *stack.shape[-2:])
    used = np.flatnonzero(flat)
    return np.asarray(np.tensordot(flat[used], matrices[used], 1))
