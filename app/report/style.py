"""How the figures look: one palette for temperature, quiet axes, nothing that needs a screen."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.rcsetup import cycler

from app.files.atomic import atomic_path

SETTINGS: Any = {
    "font.size": 10.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "lines.linewidth": 1.3,
    "axes.prop_cycle": cycler(
        color=["#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#7f7f7f", "#222222"]
    ),  # Okabe and Ito: distinguishable with any colour vision
    "figure.constrained_layout.use": True,
}
MEASURED, MODEL, BAND = "0.15", "#d1495b", "#00798c"


def drawing() -> AbstractContextManager[None]:
    """Context in which figures take this style; the process's own settings stay as they are."""
    return mpl.rc_context(SETTINGS)


def lay_out(figure: Figure) -> None:
    """Place axes and texts of a finished figure once: with a layout engine, every `savefig` draws it twice."""
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        with mpl.rc_context({"figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)


def saved(target: Path, draw: Callable[[], Figure]) -> None:
    """Write what `draw` makes in this style as PNG, whole or not at all; the same figure gives the same bytes."""
    with drawing(), atomic_path(target) as path:
        figure = draw()
        lay_out(figure)
        figure.savefig(path, format="png", dpi=100, metadata={"Software": None})


class DrawnFigure(Figure):
    """A figure that a notebook shows by itself, without the window system of matplotlib."""

    def _repr_png_(self) -> bytes:
        picture = BytesIO()
        self.savefig(picture, format="png", dpi=100)
        return picture.getvalue()


def panels(
    rows: int, columns: int, width: float = 10.0, height: float = 4.0, **options: Any
) -> tuple[Figure, Any]:
    """Return a figure without a window, and its axes.

    Parameters
    ----------
    width, height : float
        Inches.
    **options
        Of `Figure.subplots`.

    Returns
    -------
    figure : Figure
    axes : Axes or ndarray of Axes
        As `Figure.subplots` returns them.
    """
    figure = DrawnFigure(figsize=(width, height))
    return figure, figure.subplots(rows, columns, **options)


def legend_below(figure: Figure, *axes: Axes, columns: int = 5, **options: Any) -> None:
    """Name curves below the figure, where the names cover none.

    Parameters
    ----------
    *axes : Axes
        Whose curves are named, each name once; those of the first axes if none are given.
    columns : int
        At most.
    **options
        Of `Figure.legend`.
    """
    named: dict[str, Any] = {}
    for each in axes or figure.axes[:1]:
        for handle, label in zip(*each.get_legend_handles_labels(), strict=True):
            named.setdefault(label, handle)
    if named:
        count = min(columns, len(named))
        figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=count, **options)


def temperature_color(temperature: float, span: Sequence[float]) -> tuple[float, ...]:
    """Blue for the coldest, yellow for the hottest of `span` (low, high), evenly to the eye."""
    low, high = span
    share = 0.5 if high <= low else (temperature - low) / (high - low)
    color: tuple[float, ...] = mpl.colormaps["plasma"](0.88 * share)
    return color


def frequency_axis(axes: Axes) -> None:
    """Label a frequency axis."""
    axes.set_xlabel("frequency [Hz]")
