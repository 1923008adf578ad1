"""Modes of one sweep as they are paired: measured ones, or those that a twin has."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from analysis.identification.modes import Damping, Modes, PoleReading, read_poles

HEARD = 0.3
"""Peak of a mode over the rms of its FRFs from which on it counts as strong. Smaller ones lie on the flanks of
their neighbours, and what is missing there changes their residues first. Of an aluminium plate with three
accelerometers 13 of 14 modes reach it, of a polypropylene plate with one patch half."""


@dataclass(frozen=True)
class ModeList:
    """Frequencies, damping and residues of the modes of one sweep.

    Attributes
    ----------
    frequency, sigma_frequency : (J,) ndarray
        Hz, ascending; standard deviations are 0 where they are not known.
    damping_ratio, sigma_damping_ratio : (J,) ndarray
    residues : (K, J) complex ndarray
        Per channel, over the rms of the channel's measured FRF, rad/s.
    certain : (J,) bool ndarray
        Modes that are surely there: of measured ones those kept and confirmed.
    """

    frequency: NDArray[np.float64]
    sigma_frequency: NDArray[np.float64]
    damping_ratio: NDArray[np.float64]
    sigma_damping_ratio: NDArray[np.float64]
    residues: NDArray[np.complex128]
    certain: NDArray[np.bool_]

    def __post_init__(self) -> None:
        shape = self.frequency.shape
        for name in ("sigma_frequency", "damping_ratio", "sigma_damping_ratio", "certain"):
            if getattr(self, name).shape != shape:
                raise ValueError(f"{name} has shape {getattr(self, name).shape}; {shape} wanted")
        if self.residues.ndim != 2 or self.residues.shape[1:] != shape:
            raise ValueError(f"residues have shape {self.residues.shape}; (K, {len(self.frequency)}) wanted")
        if (np.diff(self.frequency) < 0.0).any() or not (self.frequency > 0.0).all():
            raise ValueError("frequencies must ascend from above 0 Hz")

    @classmethod
    def measured(cls, modes: Modes, rms: NDArray[np.float64]) -> Self:
        """Take the identified modes of a sweep, without poles that are no modes; `rms` (K,) of its FRFs."""
        own = modes.real
        certain = modes.sure & (modes.overlapped < 0)
        return cls._of(modes.reading(), modes.residues / rms[:, None], certain, np.flatnonzero(own))

    @classmethod
    def computed(
        cls,
        poles: NDArray[np.complex128],
        residues: NDArray[np.complex128],
        rms: NDArray[np.float64],
        sigma: tuple[float, float] = (0.0, 0.0),
        damping: Damping = "hysteretic",
    ) -> Self:
        """Take poles and residues of a twin.

        Parameters
        ----------
        poles : (J,) complex ndarray
            rad/s, upper half plane.
        residues : (K, J) complex ndarray
            FRF unit times rad/s, gain included.
        rms : (K,) ndarray
            Of the measured FRFs.
        sigma : (float, float)
            Relative standard deviations of all frequencies and all damping ratios.
        damping : str
            How poles are read.

        Returns
        -------
        ModeList
        """
        covariance = np.zeros((len(poles), 2, 2))
        covariance[:, 0, 0], covariance[:, 1, 1] = np.square(sigma)
        reading = read_poles(poles, covariance, damping)
        return cls._of(reading, residues / rms[:, None], np.ones(len(poles), dtype=bool), np.arange(len(poles)))

    @classmethod
    def _of(
        cls,
        reading: PoleReading,
        residues: NDArray[np.complex128],
        certain: NDArray[np.bool_],
        own: NDArray[np.intp],
    ) -> Self:
        row = own[np.argsort(reading.frequency_hz[own], kind="stable")]
        return cls(
            reading.frequency_hz[row],
            reading.sigma_frequency_hz[row],
            reading.damping_ratio[row],
            reading.sigma_damping_ratio[row],
            residues[:, row],
            certain[row],
        )

    @property
    def bandwidth(self) -> NDArray[np.float64]:
        """Half-power bandwidths 2 zeta f, Hz, (J,)."""
        return 2.0 * self.damping_ratio * self.frequency

    @property
    def peak(self) -> NDArray[np.float64]:
        """Height of every mode's own resonance over the rms of its FRFs, root mean square over channels: (J,)."""
        width = 2.0 * np.pi * self.frequency * self.damping_ratio
        return np.asarray(np.sqrt((np.abs(self.residues) ** 2).mean(axis=0)) / width)

    @property
    def strong(self) -> NDArray[np.bool_]:
        """Modes that are certain and whose peak stands out of the FRFs, (J,)."""
        return np.asarray(self.certain & (self.peak > HEARD))
