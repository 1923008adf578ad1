"""What a run folder of a test holds, read at once."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.identification.modes import Modes, PoleReading
from analysis.shapes.participation import ModeShapes
from analysis.shapes.stabilization import StabilizationChart
from app.modal_test.frf_set import FrfSet
from app.modal_test.modes_of_test import load_stabilization, load_test
from app.modal_test.without_windows import rebuilt


@dataclass(frozen=True)
class HeldTest:
    """FRFs, modes, shapes and stabilization chart of a test.

    Attributes
    ----------
    run : Path
        Its folder.
    frfs : FrfSet
    modes : Modes
    shapes : ModeShapes
    chart : StabilizationChart
    """

    run: Path
    frfs: FrfSet
    modes: Modes
    shapes: ModeShapes
    chart: StabilizationChart

    @classmethod
    def read(cls, run: Path) -> "HeldTest":
        """Read a run folder; ResultFileError where a file is missing or something else."""
        frfs, modes, shapes = load_test(run)
        return cls(run, frfs, modes, shapes, load_stabilization(run / "stabilization.h5"))

    @cached_property
    def rebuilt(self) -> NDArray[np.complex128]:
        """FRFs of poles and residues, (L, F)."""
        return self.model(self.frfs.frequency)

    def model(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """FRFs of poles and residues at other frequencies, Hz."""
        return rebuilt(self.modes, frequency, self.frfs)

    @cached_property
    def reading(self) -> PoleReading:
        """Frequency and damping of every pole."""
        return self.modes.reading()

    @property
    def places(self) -> NDArray[np.float64]:
        """Frequencies of the modes in the order of the shapes, (S,), Hz."""
        found: NDArray[np.float64] = self.reading.frequency_hz[self.shapes.pole]
        return found
