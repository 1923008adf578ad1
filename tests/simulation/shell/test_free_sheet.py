"""A free sheet with a ratio of moduli of 12 against Ritz's solution of the thin plate."""

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from analysis.experiment import Plate
from simulation.meshing.plate_mesh import MeshRecipe
from simulation.shell.assembly import assemble

A, B, DENSITY = 0.40, 0.18, 430.0
EX, EY, G, NU_XY = 12e9, 1e9, 0.8e9, 0.45
NU = float(NU_XY * np.sqrt(EY / EX))
MODES = 12


def ritz(h: float, functions: int) -> np.ndarray:
    """Natural frequencies, Hz, of the thin plate, with products of Legendre polynomials as its deflections."""
    points, weights = legendre.leggauss(2 * functions)
    tables = [
        np.array([legendre.legval(points, legendre.legder(row, order)) for row in np.eye(functions)])
        for order in range(3)
    ]

    def gram(side: float, first: int, second: int) -> np.ndarray:
        scale = (2.0 / side) ** (first + second) * 0.5 * side
        return scale * (tables[first] * weights) @ tables[second].T

    x, y = ({(i, j): gram(side, i, j) for i in range(3) for j in range(3)} for side in (A, B))
    d = h**3 / 12.0
    d11, d22, d12 = (one / (1.0 - NU**2) * d for one in (EX, EY, NU * np.sqrt(EX * EY)))
    stiffness = d11 * np.kron(x[2, 2], y[0, 0]) + d22 * np.kron(x[0, 0], y[2, 2])
    stiffness += d12 * (np.kron(x[2, 0], y[0, 2]) + np.kron(x[0, 2], y[2, 0]))
    stiffness += 4.0 * G * d * np.kron(x[1, 1], y[1, 1])
    mass = DENSITY * h * np.kron(x[0, 0], y[0, 0])
    squares = eigh(stiffness, mass, eigvals_only=True)
    return np.sqrt(np.maximum(squares[3 : 3 + MODES], 0.0)) / (2.0 * np.pi)


def shell(h: float) -> np.ndarray:
    """Natural frequencies, Hz, of the twin's bending."""
    mean = 0.5 * (EX + EY)
    shares = {"delta_e": (EY - EX) / (EY + EX), "delta_g": 2.0 * G * (1.0 + NU) / mean - 1.0}
    material = {"youngs_modulus": (5e9, 8e9), "poisson_ratio": (0.1, 0.2), "loss_factor": (0.005, 0.05)}
    plate = Plate.model_validate(
        {
            **{"length_x": A, "length_y": B, "thickness": h, "mass": DENSITY * A * B * h},
            "material": {**material, "orthotropy": shares},
        }
    )
    recipe = MeshRecipe(spacing=0.06 * (0.003 / h) ** 0.5, grading=0.0)
    return assemble(plate, recipe=recipe, degree=7).eigenfrequencies(mean, NU, 6 + MODES)[6:]


def test_a_free_sheet_goes_to_ritzs_thin_plate_with_its_thickness() -> None:
    """Transverse shear and rotary inertia lower bending by order h**2, and torsion by order h at free edges.

    A strip's torsional stiffness is less by 0.63 h over its width (St. Venant), which a thin plate leaves out.
    """
    errors = []
    for h in (0.004, 0.002):
        exact = ritz(h, 16)
        assert np.abs(ritz(h, 14) / exact - 1.0).max() < 1e-5
        errors.append(1.0 - shell(h) / exact)
    thick, thin = errors
    assert (thin > 0.0).all()
    assert thin.max() < 0.005
    falls = thick / thin
    assert (np.abs(falls[[1, 2, 5, 8]] / 4.0 - 1.0) < 0.05).all()  # bending along and across the grain
    assert ((falls > 1.9) & (falls < 4.2)).all()
