"""Arrays with named axes, as xarray and pandas take them.

Both are imported when they are asked for: they take a second, and are not installed with Flexura.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
from numpy.typing import NDArray

NEEDS = "needs the package {package}, of the extra tables: pip install 'flexura[tables]'"


@dataclass(frozen=True)
class LabelledArrays:
    """Arrays over named axes.

    Attributes
    ----------
    fields : mapping of str to (tuple of str, ndarray)
        By name: the axes, and the values.
    coordinates : mapping of str to (tuple of str, ndarray)
        Values along the axes, likewise; of an axis itself under the name of the axis.
    units : mapping of str to str
        Of fields and coordinates.
    notes : tuple of str
        For people, kept as an attribute.
    """

    fields: Mapping[str, tuple[tuple[str, ...], NDArray[Any]]]
    coordinates: Mapping[str, tuple[tuple[str, ...], NDArray[Any]]]
    units: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def dataset(self) -> Any:
        """Return them as an ``xarray.Dataset``; ImportError where xarray is not installed."""
        xarray = _package("xarray")
        made = xarray.Dataset(dict(self.fields), coords=dict(self.coordinates))
        for name, unit in self.units.items():
            made[name].attrs["units"] = unit
        if self.notes:
            made.attrs["notes"] = "\n".join(self.notes)
        return made

    def frame(self) -> Any:
        """Return them as a ``pandas.DataFrame`` of fields and coordinates, a row for each place along all axes.

        Units stand in ``attrs``. ImportError where pandas is not installed.
        """
        pandas = _package("pandas")
        held = {**self.coordinates, **self.fields}
        axes = tuple(dict.fromkeys(axis for names, _ in held.values() for axis in names))
        sizes = {axis: values.shape[k] for names, values in held.values() for k, axis in enumerate(names)}
        shape = tuple(sizes[axis] for axis in axes)
        columns = {}
        for name, (names, values) in held.items():
            order = sorted(range(len(names)), key=lambda k: axes.index(names[k]))
            spread = [sizes[axis] if axis in names else 1 for axis in axes]
            columns[name] = np.broadcast_to(np.transpose(values, order).reshape(spread), shape).ravel()
        made = pandas.DataFrame(columns)
        made.attrs["units"] = dict(self.units)
        return made


class Labelled(ABC):
    """A value that xarray and pandas can take."""

    @abstractmethod
    def labelled(self) -> LabelledArrays:
        """Return its arrays with named axes."""

    def to_xarray(self) -> Any:
        """Return an ``xarray.Dataset`` with coordinates and units; ImportError without the extra ``tables``."""
        return self.labelled().dataset()

    def to_pandas(self) -> Any:
        """Return a ``pandas.DataFrame``, a row for each number; ImportError without the extra ``tables``."""
        return self.labelled().frame()


def _package(name: str) -> Any:
    if find_spec(name) is None:
        raise ImportError(NEEDS.format(package=name))
    return import_module(name)
