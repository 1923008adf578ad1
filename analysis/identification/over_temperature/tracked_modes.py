"""Modes followed over temperature."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.identification.modes import Damping, Modes, PoleReading, read_poles
from analysis.labelled import Labelled, LabelledArrays

ABSENT = "absent"


@dataclass(frozen=True)
class TrackedModes(Labelled):
    """One identification per sweep, and which pole of each belongs to which mode.

    Attributes
    ----------
    temperature : (T,) ndarray
        Degrees Celsius, in the order recorded.
    direction : tuple of str
        ``up`` or ``down``, per sweep.
    level : (T,) ndarray
        Drive amplitude, in `level_unit`.
    channels : tuple of str
        Sensor names.
    modes : tuple of Modes
        Per sweep, every pole of its model.
    track : (T, J) int ndarray
        Index of each mode's pole in the sweep's `modes`, -1 where the sweep does not show it. Modes stand
        by rising frequency.
    start : int
        Sweep that was identified without start values.
    notes : tuple of str
        Messages about sweeps that the user should check.
    level_unit : str
    """

    temperature: NDArray[np.float64]
    direction: tuple[str, ...]
    level: NDArray[np.float64]
    channels: tuple[str, ...]
    modes: tuple[Modes, ...]
    track: NDArray[np.int64]
    start: int
    notes: tuple[str, ...] = ()
    level_unit: str = "V"

    def __post_init__(self) -> None:
        sweeps = len(self.modes)
        if not len(self.temperature) == len(self.direction) == len(self.level) == len(self.track) == sweeps:
            raise ValueError(
                f"temperature, direction, level, modes and track hold {len(self.temperature)}, "
                f"{len(self.direction)}, {len(self.level)}, {sweeps} and {len(self.track)} sweeps"
            )
        for t, (modes, row) in enumerate(zip(self.modes, self.track, strict=True)):
            used = row[row >= 0]
            if len(set(used.tolist())) != len(used) or (used >= len(modes.poles)).any():
                raise ValueError(f"sweep {t}: track {row.tolist()} does not fit {len(modes.poles)} poles")

    @property
    def poles(self) -> NDArray[np.complex128]:
        """Poles (T, J), rad/s, at the temperatures stated for the sweeps, NaN where absent."""
        gathered = np.full(self.track.shape, complex(np.nan, np.nan))
        for t, j, n in self._present():
            gathered[t, j] = self.modes[t].stated_poles[n]
        return gathered

    @property
    def residues(self) -> NDArray[np.complex128]:
        """Residues (T, K, J), NaN where absent."""
        sweeps, count = self.track.shape
        gathered = np.full((sweeps, len(self.channels), count), complex(np.nan, np.nan))
        for t, j, n in self._present():
            gathered[t, :, j] = self.modes[t].residues[:, n]
        return gathered

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance (T, J, 2, 2) of log |pole| and log damping ratio, NaN where absent."""
        gathered = np.full((*self.track.shape, 2, 2), np.nan)
        for t, j, n in self._present():
            gathered[t, j] = self.modes[t].covariance[n]
        return gathered

    @property
    def status(self) -> tuple[tuple[str, ...], ...]:
        """Status of every mode in every sweep, T by J; ``absent`` where a sweep does not show it."""
        return tuple(
            tuple(self.modes[t].status[n] if n >= 0 else ABSENT for n in row) for t, row in enumerate(self.track)
        )

    @property
    def misfit(self) -> NDArray[np.float64]:
        """Residual of each sweep's model, as a share of rms |h|: (T,) ndarray."""
        return np.array([modes.misfit for modes in self.modes])

    @property
    def damping(self) -> Damping:
        """How `reading` reads poles unless it is told: as the modes of the first sweep."""
        return next((modes.damping for modes in self.modes), "hysteretic")

    def reading(self, damping: Damping | None = None) -> PoleReading:
        """Frequency, damping ratio and loss factor, each (T, J), with standard deviations; NaN where absent."""
        return read_poles(self.poles, self.covariance, damping or self.damping)

    def read_as(self, damping: Damping) -> "TrackedModes":
        """Return the same modes, read in another way."""
        return replace(self, modes=tuple(modes.read_as(damping) for modes in self.modes))

    def synthesis(self, frequency: NDArray[np.float64]) -> NDArray[np.complex128]:
        """Rebuild the FRFs of every sweep, (T, K, F), at `frequency` [Hz]."""
        return np.array([modes.synthesis(frequency) for modes in self.modes])

    def labelled(self) -> LabelledArrays:
        """Frequency, damping and status over sweep and mode, residues over channel, too; NaN where absent."""
        read, of_modes = self.reading(), ("sweep", "mode")
        return LabelledArrays(
            {
                "frequency": (of_modes, read.frequency_hz),
                "sigma_frequency": (of_modes, read.sigma_frequency_hz),
                "damping_ratio": (of_modes, read.damping_ratio),
                "sigma_damping_ratio": (of_modes, read.sigma_damping_ratio),
                "loss_factor": (of_modes, read.loss_factor),
                "sigma_loss_factor": (of_modes, read.sigma_loss_factor),
                "status": (of_modes, np.array(self.status).reshape(self.track.shape)),
                "residue": (("sweep", "channel", "mode"), self.residues),
            },
            {
                "temperature": (("sweep",), self.temperature),
                "direction": (("sweep",), np.array(self.direction)),
                "level": (("sweep",), self.level),
                "mode": (("mode",), np.arange(1, self.track.shape[1] + 1)),
                "channel": (("channel",), np.array(self.channels)),
            },
            {"frequency": "Hz", "sigma_frequency": "Hz", "temperature": "degC", "level": self.level_unit},
            self.notes,
        )

    def _present(self) -> list[tuple[int, int, int]]:
        return [(t, j, int(n)) for t, row in enumerate(self.track) for j, n in enumerate(row) if n >= 0]
