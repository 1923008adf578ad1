"""How the actuator positions of ``section2-panel.toml`` were found.

    python examples/place_actuators.py [PANEL.toml] [--starts 6] [--pitch 0.0125]

Exchanges positions on a lattice until no single move raises the mean STIF contrast, at the panel's illustration
material (the paper's section 2) and over its band, lines below 540 Hz counting twice as densely as those above.
The plate is a thin one (Kirchhoff), clamped, in products of polynomials (Ritz), with the bending stiffness and the
mass of every glued patch: light enough for thousands of layouts, and independent of the finite-element twin, with
which the result is then to be judged (``flexura focus``).
"""

import argparse
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from analysis.focusing.energy import EnergyForms
from analysis.focusing.grid import Grid
from analysis.focusing.inversion import invert
from analysis.focusing.panel import Panel
from analysis.focusing.performance import contrast
from analysis.focusing.placement import clearance, exchange
from app.files.panel_file import SECTION_2, read_panel
from simulation.shell.piezo_material import PIEZO_MATERIALS

ORDERS, MODES, GAP = 14, 80, 0.0049


def polynomials(points: np.ndarray, length: float, derivative: int) -> np.ndarray:
    """Clamped polynomials (1 - s²)² P_i(s) along one side, or a derivative of them, (points, orders)."""
    s = 2.0 * points / length - 1.0
    clamp = legendre.poly2leg([1.0, 0.0, -2.0, 0.0, 1.0])
    columns = []
    for order in range(ORDERS):
        series = legendre.legmul(clamp, np.eye(order + 1)[order])
        nodes, weights = legendre.leggauss(order + 6)
        norm = np.sqrt(np.sum(weights * legendre.legval(nodes, series) ** 2))
        columns.append(
            legendre.legval(s, legendre.legder(series, derivative)) / norm * (2.0 / length) ** derivative
        )
    return np.array(columns).T


@dataclass(frozen=True)
class Integrals:
    """Mass, the two curvature forms (multiplied by 1 and by nu) and the mean curvature over one rectangle."""

    mass: np.ndarray
    bending: np.ndarray
    poisson: np.ndarray
    load: np.ndarray


def integrals(plate_lengths: tuple[float, float], spans: list[tuple[float, float]]) -> Integrals:
    """Gauss integrals of the Ritz functions over a rectangle."""
    nodes, weights = legendre.leggauss(ORDERS + 8)
    form, moment = [], []
    for length, (low, high) in zip(plate_lengths, spans, strict=True):
        points, w = 0.5 * (low + high) + 0.5 * (high - low) * nodes, 0.5 * (high - low) * weights
        values = [polynomials(points, length, d) for d in range(3)]
        form.append({(i, j): values[i].T * w @ values[j] for i in range(3) for j in range(3)})
        moment.append([w @ v for v in values])
    (x, y), (mx, my) = form, moment
    twist = np.kron(x[1, 1], y[1, 1])
    return Integrals(
        np.kron(x[0, 0], y[0, 0]),
        np.kron(x[2, 2], y[0, 0]) + np.kron(x[0, 0], y[2, 2]) + 2.0 * twist,
        np.kron(x[2, 0], y[0, 2]) + np.kron(x[0, 2], y[2, 0]) - 2.0 * twist,
        np.kron(mx[2], my[0]) + np.kron(mx[0], my[2]),
    )


class Layouts:
    """Scores layouts of a panel's patches on a lattice of centres (C, 2), m."""

    def __init__(self, panel: Panel, centers: np.ndarray) -> None:
        plate, patch, material = panel.plate, panel.patch[0], panel.illustration
        lengths = (plate.length_x, plate.length_y)
        e, nu, self.loss = material.youngs_modulus, material.poisson_ratio, material.loss_factor
        h, hp, ceramic = plate.thickness, patch.thickness, PIEZO_MATERIALS[patch.material]
        whole = integrals(lengths, [(0.0, lengths[0]), (0.0, lengths[1])])
        rigidity = e * h**3 / 12.0 / (1.0 - nu**2)
        values, shapes = eigh(
            rigidity * (whole.bending + nu * whole.poisson),
            plate.density * h * whole.mass,
            subset_by_index=(0, MODES - 1),
        )
        self.bare = np.diag(values)
        # Plate and patch bend about a common neutral axis: in-plane stiffnesses in series over their distance.
        ep, nup = ceramic.stiffness
        plate_plane, patch_plane = e * h / (1.0 - nu**2), ep * hp / (1.0 - nup**2)
        arm = 0.5 * (h + hp)
        added = ep * hp**3 / 12.0 / (1.0 - nup**2) + arm**2 / (1.0 / plate_plane + 1.0 / patch_plane)
        half = [0.5 * s for s in patch.size]
        stiffness, mass, load = [], [], []
        for center in centers:
            here = integrals(lengths, [(c - s, c + s) for c, s in zip(center, half, strict=True)])
            stiffness.append(added * shapes.T @ (here.bending + nup * here.poisson) @ shapes)
            mass.append(ceramic.density * hp * shapes.T @ here.mass @ shapes)
            load.append(shapes.T @ here.load)
        self.stiffness, self.mass, self.load = np.array(stiffness), np.array(mass), np.array(load)
        grid = Grid.of(panel)
        along = [polynomials(np.unique(grid.points[:, axis]), lengths[axis], 0) for axis in (0, 1)]
        field = np.kron(along[0], along[1]) @ shapes
        self.plate = field.T * grid.area @ field
        self.target = field.T * (grid.area * grid.target) @ field
        self.aim = field.T @ (grid.area * grid.target)
        low, high = panel.filters.band
        self.lines = np.concatenate([np.arange(low, 540.0, 20.0), np.arange(540.0, high + 1.0, 40.0)])
        self.tolerance = panel.filters.tolerance

    def contrast(self, layout: np.ndarray) -> np.ndarray:
        """STIF contrast (F,) of one layout (N,)."""
        stiffness = self.bare + self.stiffness[layout].sum(axis=0)
        values, modes = eigh(stiffness, np.eye(MODES) + self.mass[layout].sum(axis=0))
        force = modes.T @ self.load[layout].T
        dynamic = values * (1.0 + 1j * self.loss) - (2.0 * np.pi * self.lines[:, None]) ** 2
        response = force / dynamic[:, :, None]
        adjoint = response.conj().transpose(0, 2, 1)
        forms = EnergyForms(
            (adjoint @ (modes.T @ self.plate @ modes) @ response)[None],
            (adjoint @ (modes.T @ self.target @ modes) @ response)[None],
            (adjoint @ (modes.T @ self.aim))[None],
        )
        return contrast(forms, invert(forms, self.tolerance).filters)[0]

    def score(self, layouts: np.ndarray) -> np.ndarray:
        """Mean contrast (S,) of layouts (S, N)."""
        return np.array([self.contrast(layout).mean() for layout in layouts])


def main() -> None:
    """Search and print the positions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("panel", type=Path, nargs="?", default=SECTION_2)
    parser.add_argument("--starts", type=int, default=6)
    parser.add_argument("--pitch", type=float, default=0.0125, help="of the lattice, m")
    parser.add_argument("--first", type=float, default=0.02, help="first centre along x and y, m")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    panel = read_panel(options.panel)
    if panel.plate.outline is not None or panel.plate.hole or panel.plate.boundary != "clamped":
        sys.exit(f"{options.panel}: the polynomials are those of a clamped rectangle without holes")
    size = panel.patch[0].size
    axes = [
        np.arange(options.first, length - 0.5 * side - 0.003, options.pitch)
        for length, side in zip((panel.plate.length_x, panel.plate.length_y), size, strict=True)
    ]
    centers = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    layouts = Layouts(panel, centers)
    free = clearance(centers, max(size) + GAP)
    rng = np.random.default_rng(options.seed)
    best = None
    for start in range(options.starts):
        found = exchange(layouts.score, free, len(panel.patch), rng, starts=1)
        print(f"start {start + 1}: {found.score:.4f}", file=sys.stderr, flush=True)
        best = found if best is None or found.score > best.score else best
    if best is None:
        sys.exit("--starts must be at least 1")
    reached = layouts.contrast(best.chosen)
    below = layouts.lines < 540.0
    print(f"mean contrast {reached[below].mean():.3f} below 540 Hz, {reached[~below].mean():.3f} above")
    for number, center in enumerate(centers[best.chosen], start=1):
        print(f"A{number}: center = [{center[0]:.4f}, {center[1]:.4f}]")


if __name__ == "__main__":
    main()
