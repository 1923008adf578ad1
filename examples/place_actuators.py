"""How the actuator positions of ``section2-panel.toml`` were found.

    python examples/place_actuators.py [PANEL.toml] [--starts 6] [--pitch 0.0125]
    python examples/place_actuators.py --laws plate-run --outside-weight 10 --patches 8 --keep-out 0.18 0 0.24 0.06

Exchanges positions on a lattice until no single move raises the mean STIF contrast over the panel's band, lines
below 540 Hz counting twice as densely as those above: at the panel's illustration material (the paper's section
2), or at several temperatures at once of a run's laws. No patch is put into a zone to keep out of. The contrast
printed is that of lines half-way between those that took part.
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
from app.files.laws_file import load_laws
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

    def __init__(self, panel: Panel, centers: np.ndarray, constants: tuple[float, float, float]) -> None:
        plate, patch = panel.plate, panel.patch[0]
        lengths = (plate.length_x, plate.length_y)
        e, nu, self.loss = constants
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
        self.tolerance, self.kappa = panel.filters.tolerance, panel.filters.kappa

    def contrast(self, layout: np.ndarray, lines: np.ndarray | None = None) -> np.ndarray:
        """STIF contrast (F,) of one layout (N,), at the lines of the search unless others are given."""
        lines = self.lines if lines is None else lines
        stiffness = self.bare + self.stiffness[layout].sum(axis=0)
        values, modes = eigh(stiffness, np.eye(MODES) + self.mass[layout].sum(axis=0))
        force = modes.T @ self.load[layout].T
        dynamic = values * (1.0 + 1j * self.loss) - (2.0 * np.pi * lines[:, None]) ** 2
        response = force / dynamic[:, :, None]
        adjoint = response.conj().transpose(0, 2, 1)
        forms = EnergyForms(
            (adjoint @ (modes.T @ self.plate @ modes) @ response)[None],
            (adjoint @ (modes.T @ self.target @ modes) @ response)[None],
            (adjoint @ (modes.T @ self.aim))[None],
        )
        return contrast(forms, invert(forms.weighted(self.kappa), self.tolerance).filters)[0]


def materials(panel: Panel, run: Path | None, temperatures: list[float]) -> list[tuple[float, float, float]]:
    """E, nu and eta at each temperature, °C, of a run's laws; without a run those of the illustration."""
    if run is None:
        plate = panel.illustration
        return [(plate.youngs_modulus, plate.poisson_ratio, plate.loss_factor)]
    law = load_laws(run / "laws.h5").at(np.array(temperatures or [0.0, 20.0, 40.0, 60.0]))
    rows = zip(law.youngs_modulus, law.poisson_ratio, law.loss_factor, strict=True)
    return [(float(e), float(nu), float(eta)) for e, nu, eta in rows]


def kept_out(centers: np.ndarray, size: tuple[float, float], zones: list[list[float]]) -> np.ndarray:
    """Which centres (C, 2) of patches of a `size` reach into a zone x0, y0, x1, y1, all m."""
    half, out = 0.5 * np.array(size), np.zeros(len(centers), dtype=bool)
    for x0, y0, x1, y1 in zones:
        out |= ((centers + half > (x0, y0)) & (centers - half < (x1, y1))).all(axis=1)
    return out


def main() -> None:
    """Search and print the positions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("panel", type=Path, nargs="?", default=SECTION_2)
    parser.add_argument("--starts", type=int, default=6)
    parser.add_argument("--pitch", type=float, default=0.0125, help="of the lattice, m")
    parser.add_argument("--first", type=float, default=0.02, help="first centre along x and y, m")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--laws", type=Path, help="run folder with laws.h5; default: the illustration's material")
    parser.add_argument("--temperature", type=float, action="append", default=[], help="°C, with --laws; repeat")
    parser.add_argument("--patches", type=int, help="how many; default: the panel's")
    parser.add_argument("--outside-weight", type=float, help="of the aim; default: the panel's")
    parser.add_argument(
        "--keep-out", type=float, nargs=4, action="append", default=[], metavar=("X0", "Y0", "X1", "Y1"), help="m"
    )
    options = parser.parse_args()
    panel = read_panel(options.panel)
    if options.outside_weight is not None:
        settings = panel.filters.model_copy(update={"outside_weight": options.outside_weight})
        panel = panel.model_copy(update={"filters": settings})
    if panel.plate.outline is not None or panel.plate.hole or panel.plate.boundary != "clamped":
        sys.exit(f"{options.panel}: the polynomials are those of a clamped rectangle without holes")
    size = panel.patch[0].size
    axes = [
        np.arange(options.first, length - 0.5 * side - 0.003, options.pitch)
        for length, side in zip((panel.plate.length_x, panel.plate.length_y), size, strict=True)
    ]
    centers = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    centers = centers[~kept_out(centers, size, options.keep_out)]
    plates = [Layouts(panel, centers, one) for one in materials(panel, options.laws, options.temperature)]

    def score(layouts: np.ndarray) -> np.ndarray:
        return np.array([np.mean([plate.contrast(layout) for plate in plates]) for layout in layouts])

    free = clearance(centers, max(size) + GAP)
    rng = np.random.default_rng(options.seed)
    best = None
    for start in range(options.starts):
        found = exchange(score, free, options.patches or len(panel.patch), rng, starts=1)
        print(f"start {start + 1}: {found.score:.4f}", file=sys.stderr, flush=True)
        best = found if best is None or found.score > best.score else best
    if best is None:
        sys.exit("--starts must be at least 1")
    lines = plates[0].lines[:-1] + 0.5 * np.diff(plates[0].lines)
    below = lines < 540.0
    for number, plate in enumerate(plates):
        reached = plate.contrast(best.chosen, lines)
        where = f"{(options.temperature or [0.0, 20.0, 40.0, 60.0])[number]:g} °C: " if options.laws else ""
        print(f"{where}contrast {reached[below].mean():.3f} below 540 Hz, {reached[~below].mean():.3f} above")
    for number, center in enumerate(centers[best.chosen], start=1):
        print(f"A{number}: center = [{center[0]:.4f}, {center[1]:.4f}]")


if __name__ == "__main__":
    main()
