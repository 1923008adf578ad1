"""How the actuator positions of a clamped rectangular panel are found.

    python examples/place_actuators.py [PANEL.toml] [--starts 6] [--out placed.toml]
    python examples/place_actuators.py --laws plate-run --outside-weight 10 --patches 8 --keep-out 0.18 0 0.24 0.06
    python examples/place_actuators.py --laws plate-run --refine --patches 8

Exchanges positions on a lattice until no single move raises the mean STIF contrast, then moves patches in ever
smaller steps. The mean is over lines of the panel's band, every 20 Hz below 540 Hz and every 40 Hz above, at
the panel's illustration material (the paper's section 2), or at several temperatures at once of a run's laws. No
patch is put into a zone to keep out of; turned patches keep their angle, round ones stay round. What is printed is
judged on lines half-way between those that took part; the bound beside it is what any filters reach on these
patches at the price of level.
The plate is a thin one (Kirchhoff), clamped, in products of polynomials (Ritz), with the bending stiffness and the
mass of every glued patch: light enough for thousands of layouts, and independent of the finite-element twin, with
which the result is then to be judged (``flexura focus RUN --panel placed.toml``).
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

from analysis.declaration.transducers import Patch
from analysis.focusing.energy import EnergyForms, Grid
from analysis.focusing.methods import invert
from analysis.focusing.panel import Panel
from analysis.focusing.performance import best_contrast, contrast
from analysis.focusing.placement import clearance, exchange, refined
from app.files.bad_file import ResultFileError
from app.files.declarations.panel import SECTION_2, read_panel
from app.files.settings_toml import toml_text
from app.stages.panel.laws import laws_for
from simulation.shell.piezo_material import PIEZO_MATERIALS

ORDERS, MODES, NODES = 14, 80, 12
GAP, MARGIN = 0.0049, 0.005  # between patches, and from the edge, m
STEPS = (0.01, 0.005, 0.0025)  # of the search off the lattice, m
COARSE = 540.0  # from here on the lines of the search are twice as far apart, Hz
SHOWN = (0.0, 20.0, 40.0, 60.0)
Constants = tuple[float, float, float]


@cache
def clamped(derivative: int) -> np.ndarray:
    """Legendre coefficients (ORDERS + 4, ORDERS) of (1 - s²)² P_i(s), of unit norm, or of a derivative of them."""
    clamp = legendre.poly2leg([1.0, 0.0, -2.0, 0.0, 1.0])
    nodes, weights = legendre.leggauss(ORDERS + 6)
    series = np.zeros((ORDERS + 4, ORDERS))
    for order in range(ORDERS):
        one = legendre.legmul(clamp, np.eye(order + 1)[order])
        one = legendre.legder(one / np.sqrt(np.sum(weights * legendre.legval(nodes, one) ** 2)), derivative)
        series[: len(one), order] = one
    return series


def polynomials(points: np.ndarray, length: float, derivative: int) -> np.ndarray:
    """Clamped polynomials along one side, or a derivative of them, (points, ORDERS)."""
    values: np.ndarray = legendre.legvander(2.0 * points / length - 1.0, ORDERS + 3) @ clamped(derivative)
    return values * (2.0 / length) ** derivative


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


def footprint(patch: Patch) -> tuple[np.ndarray, np.ndarray]:
    """Gauss points (Q, 2) of a patch about its centre, m, and their weights (Q,), m2."""
    nodes, weights = legendre.leggauss(NODES)
    if patch.diameter is not None:
        radius, turn = 0.25 * patch.diameter * (nodes + 1.0), np.pi * np.arange(2 * NODES) / NODES
        points = radius[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        shares = 0.25 * patch.diameter * weights * radius * np.pi / NODES
        return points.reshape(-1, 2), np.repeat(shares, 2 * NODES)
    (c, s), half = (f(np.deg2rad(patch.angle)) for f in (np.cos, np.sin)), 0.5 * np.array(patch.size)
    along = np.stack(np.meshgrid(*np.outer(half, nodes), indexing="ij"), axis=-1).reshape(-1, 2)
    return along @ np.array([[c, s], [-s, c]]), half.prod() * np.outer(weights, weights).ravel()


def extent(patch: Patch) -> tuple[float, float]:
    """Lengths along x and y of the box around a patch, m."""
    (x0, x1), (y0, y1) = (patch.span(axis) for axis in (0, 1))
    return x1 - x0, y1 - y0


class Layouts:
    """Scores layouts of a panel's patches, centres (N, 2) in m, at T materials.

    The shapes of a clamped plate do not depend on its material: all materials share the matrices of a patch.
    """

    def __init__(self, panel: Panel, constants: list[Constants], lines: np.ndarray) -> None:
        plate, patch = panel.plate, panel.patch[0]
        self.lengths, self.size = (plate.length_x, plate.length_y), extent(patch)
        self.points, self.areas = footprint(patch)
        h, hp, ceramic = plate.thickness, patch.thickness, PIEZO_MATERIALS[patch.material]
        e, nu, self.loss = np.array(constants).T
        whole = integrals(self.lengths, [(0.0, length) for length in self.lengths])
        values, self.shapes = eigh(whole.bending, plate.density * h * whole.mass, subset_by_index=(0, MODES - 1))
        self.bare = (e * h**3 / 12.0 / (1.0 - nu**2))[:, None, None] * np.diag(values)
        # Plate and patch bend about a common neutral axis: in-plane stiffnesses in series over their distance.
        q11, q12 = ceramic.stiffness
        self.nup, patch_plane, plate_plane = q12 / q11, q11 * hp, e * h / (1.0 - nu**2)
        arm = 0.5 * (h + hp)
        self.added = q11 * hp**3 / 12.0 + arm**2 / (1.0 / plate_plane + 1.0 / patch_plane)
        self.weight = ceramic.density * hp
        grid = Grid.of(panel)
        along = [polynomials(np.unique(grid.points[:, axis]), self.lengths[axis], 0) for axis in (0, 1)]
        field = np.kron(along[0], along[1]) @ self.shapes
        self.plate = field.T * grid.area @ field
        self.target = field.T * (grid.area * grid.target) @ field
        self.aim = field.T @ (grid.area * grid.target)
        self.lines, self.tolerance, self.kappa = lines, panel.filters.tolerance, panel.filters.kappa
        self.known: dict[tuple[float, float], tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def patch(self, x: float, y: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stiffness per rigidity, mass and load of a patch in the plate's modes, kept for the next layout."""
        key = (round(x, 6), round(y, 6))
        if key not in self.known:
            places = (self.points + key).T
            along, across = (
                [polynomials(at, length, d) for d in range(3)]
                for at, length in zip(places, self.lengths, strict=True)
            )

            def over(i: int, j: int) -> np.ndarray:
                """Modes, or i-th and j-th derivatives along x and y, at the patch's points (Q, MODES)."""
                both = along[i][:, :, None] * across[j][:, None]
                return np.asarray(both.reshape(len(both), -1) @ self.shapes)

            here, xx, yy, xy = over(0, 0), over(2, 0), over(0, 2), over(1, 1)

            def product(one: np.ndarray, other: np.ndarray) -> np.ndarray:
                return (one.T * self.areas) @ other

            crossed, twist = product(xx, yy), product(xy, xy)
            bending = product(xx, xx) + product(yy, yy) + 2.0 * twist
            poisson = crossed + crossed.T - 2.0 * twist
            load = self.areas @ (xx + yy)
            self.known[key] = (bending + self.nup * poisson, self.weight * product(here, here), load)
        return self.known[key]

    def forms(self, layout: np.ndarray, lines: np.ndarray | None = None) -> EnergyForms:
        """Energy forms of one layout (N, 2), at the lines of the search unless others are given."""
        omega2 = (2.0 * np.pi * (self.lines if lines is None else lines)) ** 2
        stiffness, mass, load = zip(*(self.patch(x, y) for x, y in layout), strict=True)
        root = np.linalg.inv(np.linalg.cholesky(np.eye(MODES) + np.sum(mass, axis=0)))
        values, modes = np.linalg.eigh(
            root @ (self.bare + self.added[:, None, None] * np.sum(stiffness, axis=0)) @ root.T
        )
        modes = root.T @ modes
        force = modes.transpose(0, 2, 1) @ np.transpose(load)
        dynamic = (values * (1.0 + 1j * self.loss[:, None]))[:, None] - omega2[:, None]
        moved = 1.0 / dynamic  # (T, F, m)
        plate, target = (modes.transpose(0, 2, 1) @ form @ modes for form in (self.plate, self.target))
        response = moved[..., None] * force[:, None]
        adjoint = response.conj().swapaxes(2, 3)
        aim = adjoint @ (modes.transpose(0, 2, 1) @ self.aim)[:, None, :, None]
        return EnergyForms(
            adjoint @ (plate[:, None] @ response), adjoint @ (target[:, None] @ response), aim[..., 0]
        )

    def score(self, several: np.ndarray) -> np.ndarray:
        """Mean contrast (S,) of layouts (S, N, 2)."""
        return np.array([self.contrast(layout).mean() for layout in several])

    def contrast(self, layout: np.ndarray, lines: np.ndarray | None = None) -> np.ndarray:
        """STIF contrast (T, F) of one layout."""
        forms = self.forms(layout, lines)
        return contrast(forms, invert(forms.weighted(self.kappa), self.tolerance).filters)


def materials(panel: Panel, run: Path | None, temperatures: list[float]) -> list[Constants]:
    """E, nu and eta at each temperature, °C, of a run's laws; without a run those of the illustration."""
    if run is None:
        plate = panel.illustration
        return [(plate.youngs_modulus, plate.poisson_ratio, plate.loss_factor)]
    law = panel.plate.grown(laws_for(run, None, "focus").laws).at(np.array(temperatures or list(SHOWN)))
    rows = zip(law.youngs_modulus, law.poisson_ratio, law.loss_factor, strict=True)
    return [(float(e), float(nu), float(eta)) for e, nu, eta in rows]


def kept_out(centers: np.ndarray, size: tuple[float, float], zones: list[list[float]]) -> np.ndarray:
    """Which centres (C, 2) of patches in boxes of a `size` reach into a zone x0, y0, x1, y1, all m."""
    half, out = 0.5 * np.array(size), np.zeros(len(centers), dtype=bool)
    for x0, y0, x1, y1 in zones:
        out |= ((centers + half > (x0, y0)) & (centers - half < (x1, y1))).all(axis=1)
    return out


def lattice(panel: Panel, pitch: float, zones: list[list[float]]) -> np.ndarray:
    """Centres (C, 2), m, at most `pitch` apart, from edge to edge of where a patch may be."""
    plate, size = panel.plate, extent(panel.patch[0])
    half = 0.5 * np.array(size) + MARGIN
    axes = [
        np.linspace(side, length - side, int(np.ceil((length - 2.0 * side) / pitch)) + 1)
        for length, side in zip((plate.length_x, plate.length_y), half, strict=True)
    ]
    centers = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    return centers[~kept_out(centers, size, zones)]


def search(
    layouts: Layouts, centers: np.ndarray, buildable: Callable[[np.ndarray], bool], options: argparse.Namespace
) -> tuple[np.ndarray, float]:
    """Best layout (N, 2) of several searches, each by exchange on the lattice and then in small steps."""
    score = layouts.score
    free, rng = clearance(centers, max(layouts.size) + GAP), np.random.default_rng(options.seed)
    best, value = centers[:0], -np.inf
    for start in range(options.starts):
        found = exchange(lambda chosen: score(centers[chosen]), free, options.patches, rng, starts=1)
        moved, reached = refined(score, centers[found.chosen], buildable, STEPS)
        print(f"start {start + 1}: {found.score:.4f}, moved {reached:.4f}", file=sys.stderr, flush=True)
        if reached > value:
            best, value = moved, reached
    return best, value


def continued(
    layouts: Layouts,
    start: np.ndarray,
    centers: np.ndarray,
    buildable: Callable[[np.ndarray], bool],
    count: int,
) -> np.ndarray:
    """Layout (N, 2) that begins at `start`: patches wanting are added one by one on the lattice, then all move."""
    layout = start
    while len(layout) < count:
        added = [one for one in (np.vstack([layout, center]) for center in centers) if buildable(one)]
        if not added:
            sys.exit(f"no room for patch {len(layout) + 1}: take fewer --patches or a smaller --pitch")
        layout = added[int(np.argmax(layouts.score(np.array(added))))]
    return refined(layouts.score, layout, buildable, STEPS if len(layout) > len(start) else STEPS[1:])[0]


def placed(panel: Panel, centers: np.ndarray) -> str:
    """Panel file with patches at `centers` (N, 2), m, like the first one declared."""
    table = panel.model_dump(mode="json", exclude_none=True)
    first = table["patch"][0]
    table["patch"] = [
        first | {"id": f"A{n}", "center": [round(float(x), 5) for x in center]}
        for n, center in enumerate(centers, 1)
    ]
    return toml_text(table, f"Placed by examples/place_actuators.py {' '.join(sys.argv[1:])}")


def main() -> None:
    """Search and print the positions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("panel", type=Path, nargs="?", default=SECTION_2)
    parser.add_argument("--starts", type=int, default=6)
    parser.add_argument("--pitch", type=float, default=0.0125, help="of the lattice, m")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--laws", type=Path, help="run folder with laws.h5; default: the illustration's material")
    parser.add_argument("--temperature", type=float, action="append", default=[], help="°C, with --laws; repeat")
    parser.add_argument("--patches", type=int, help="how many; default: the panel's")
    parser.add_argument("--outside-weight", type=float, help="of the aim; default: the panel's")
    parser.add_argument(
        "--keep-out", type=float, nargs=4, action="append", default=[], metavar=("X0", "Y0", "X1", "Y1"), help="m"
    )
    parser.add_argument("--refine", action="store_true", help="begin at the panel's own patches, not at random")
    parser.add_argument("--out", type=Path, help="panel file to write, with the patches found")
    options = parser.parse_args()
    for name in ("starts", "patches"):
        if getattr(options, name) is not None and getattr(options, name) < 1:
            parser.error(f"--{name} {getattr(options, name)}: at least 1")
    if options.temperature and options.laws is None:
        parser.error("--temperature needs --laws: the illustration's material has none")
    try:
        place(parser, options)
    except (ResultFileError, ValueError) as error:
        sys.exit(f"{error}")


def checked_panel(options: argparse.Namespace) -> Panel:
    """Read the panel; exit where the script cannot compute its plate or its patches."""
    panel = read_panel(options.panel)
    if panel.plate.outline is not None or panel.plate.hole or panel.plate.boundary != "clamped":
        sys.exit(f"{options.panel}: the polynomials are those of a clamped rectangle without holes")
    if not panel.patch:
        sys.exit(f"{options.panel}: patches are placed, not forces; declare [[patch]] in place of [[drive]]")
    kinds = {(p.size, p.diameter, p.angle, p.thickness, p.material) for p in panel.patch}
    if len(kinds) > 1:
        sys.exit(
            f"{options.panel}: {len(kinds)} kinds of patches; all are placed like the first: declare them with "
            "one size or diameter, angle, thickness and material"
        )
    return panel


def place(parser: argparse.ArgumentParser, options: argparse.Namespace) -> None:
    """Search as the options say, print and write."""
    panel = checked_panel(options)
    options.patches = options.patches or len(panel.patch)
    if options.refine and options.patches < len(panel.patch):
        parser.error(f"--patches {options.patches}: --refine begins at the panel's {len(panel.patch)}")
    if options.outside_weight is not None:
        settings = panel.filters.model_copy(update={"outside_weight": options.outside_weight})
        panel = panel.model_copy(update={"filters": settings})
    lines = search_lines(*panel.filters.band)
    layouts = Layouts(panel, materials(panel, options.laws, options.temperature), lines)
    edge = 0.5 * np.array(layouts.size) + MARGIN - 1e-9

    def buildable(layout: np.ndarray) -> bool:
        inside = (layout >= edge).all() and (layout <= np.array(layouts.lengths) - edge).all()
        apart = clearance(layout, max(layouts.size) + GAP)[~np.eye(len(layout), dtype=bool)].all()
        return bool(inside and apart and not kept_out(layout, layouts.size, options.keep_out).any())

    centers = lattice(panel, options.pitch, options.keep_out)
    if options.refine:
        if not buildable(np.array(panel.centers)):
            sys.exit(
                f"{options.panel}: its own patches, where --refine begins, are too near to each other, to an edge "
                "or to a zone to keep out of: move them, or leave out --refine"
            )
        found = continued(layouts, np.array(panel.centers), centers, buildable, options.patches)
    else:
        found, _ = search(layouts, centers, buildable, options)
    report(layouts, found, (options.temperature or list(SHOWN)) if options.laws else [])
    if options.out is not None:
        options.out.write_text(placed(panel, found), encoding="utf-8")


def search_lines(low: float, high: float) -> np.ndarray:
    """Lines (F,) of a band, Hz: every 20 Hz below `COARSE`, every 40 Hz above."""
    middle = min(max(COARSE, low), high)
    return np.concatenate([np.arange(low, middle, 20.0), np.arange(middle, high + 1.0, 40.0)])


def report(layouts: Layouts, found: np.ndarray, temperatures: list[float]) -> None:
    """Print the contrast of a layout (N, 2), m, at lines that took no part, and where its patches are."""
    lines = layouts.lines[:-1] + 0.5 * np.diff(layouts.lines)
    reached, bound = layouts.contrast(found, lines), best_contrast(layouts.forms(found, lines))
    for number, (here, most) in enumerate(zip(reached, bound, strict=True)):
        where = f"{temperatures[number]:g} °C: " if temperatures else ""
        parts = [("below", lines < COARSE), ("above", lines >= COARSE)]
        told = [
            f"{here[part].mean():.3f} {side} {COARSE:g} Hz (bound {most[part].mean():.3f})"
            for side, part in parts
            if part.any()
        ]
        print(f"{where}contrast {', '.join(told)}")
    for number, center in enumerate(found, start=1):
        print(f"A{number}: center = [{center[0]:.5f}, {center[1]:.5f}]")


if __name__ == "__main__":
    main()
