"""Pictures of meshes and mode shapes from plain arrays, for docs/make_verification.py."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from analysis.arrays import Real

INK = "#33415c"
PAPER = "white"
mpl.use("Agg")


def draw_mesh(polygons: Sequence[Real], path: Path) -> None:
    """Draw the cells of a mesh, each by its own corner or edge points (K, 2), m, to a PNG file."""
    points = np.vstack(polygons)
    figure = Figure(figsize=(4.0, 4.0 * _tallness(points)), dpi=110, facecolor=PAPER, layout="tight")
    axes = figure.add_subplot()
    axes.add_collection(PolyCollection(list(polygons), facecolors="#eef2f7", edgecolors=INK, linewidths=0.5))
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()
    _save(figure, path)


def draw_modes(
    points: Real, triangles: NDArray[np.int_], values: Real, titles: Sequence[str], path: Path, columns: int = 4
) -> None:
    """Draw deflections of modes side by side to a PNG file, red up and blue down, nodal lines and outline black.

    Parameters
    ----------
    points : (N, 2) ndarray
        m.
    triangles : (T, 3) ndarray of int
    values : (K, N) ndarray
        Deflection of each mode at the points, in any scale.
    titles : sequence of str
        One for each mode.
    """
    if len(values) != len(titles):
        raise ValueError(f"{len(values)} modes with {len(titles)} titles")
    columns = min(columns, len(values))
    rows = -(-len(values) // columns)
    figure = Figure(
        figsize=(2.0 * columns, rows * (0.35 + 2.0 * _tallness(points))), dpi=110, facecolor=PAPER, layout="tight"
    )
    mesh = Triangulation(points[:, 0], points[:, 1], triangles)
    # Edges of triangles without a neighbour, from corner k to the next one.
    triangle, k = np.nonzero(mesh.neighbors < 0)
    border = points[np.stack([mesh.triangles[triangle, k], mesh.triangles[triangle, (k + 1) % 3]], axis=1)]
    for number, (mode, title) in enumerate(zip(values, titles, strict=True), start=1):
        axes = figure.add_subplot(rows, columns, number)
        scaled = mode / np.abs(mode).max()
        axes.tricontourf(mesh, scaled, levels=np.linspace(-1.0, 1.0, 21), cmap="RdBu_r", extend="both")
        axes.tricontour(mesh, scaled, levels=[0.0], colors="black", linewidths=0.6)
        # over the axes' own edge, where half of it would be cut off, and over nodal lines that follow a support
        outline = LineCollection(border, colors="black", linewidths=0.9, capstyle="round", zorder=3, clip_on=False)
        axes.add_collection(outline)
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_title(title, fontsize=8, color=INK)
    _save(figure, path)


def _tallness(points: Real) -> float:
    width, height = points.max(axis=0) - points.min(axis=0)
    return float(height / width)


def _save(figure: Figure, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    # No software version inside: the same picture is the same file.
    figure.savefig(path, metadata={"Software": None})
