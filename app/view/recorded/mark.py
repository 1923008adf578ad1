"""Differences of the cursors from a mark."""

import numpy as np

from analysis.frf import Frf
from app.view.parts import decibels


class Mark:
    """A place in frequency and temperature that the cursors are compared with.

    Parameters
    ----------
    frf : Frf
    line, row : int
        Where it stands first: frequency line and sweep.
    """

    def __init__(self, frf: Frf, line: int, row: int) -> None:
        self._frf, self.line, self.row = frf, line, row

    def put(self, line: int, row: int) -> None:
        """Move it."""
        self.line, self.row = line, row

    def differences(self, line: int, row: int, channel: int) -> list[tuple[str, str]]:
        """Differences of a line of a sweep from the mark, for the readout; none where both are one.

        Parameters
        ----------
        line, row, channel : int
            Frequency line, sweep and output.

        Returns
        -------
        list of (str, str)
        """
        if (line, row) == (self.line, self.row):
            return []
        frf, here, there = self._frf, self._frf.h[row, channel, line], self._frf.h[self.row, channel, self.line]
        apart = frf.frequency[line] - frf.frequency[self.line], frf.temperature[row] - frf.temperature[self.row]
        turn = np.degrees(np.angle(here * np.conj(there)))
        return [
            ("from mark (M)", f"{apart[0]:+.2f} Hz, {apart[1]:+.2f} K"),
            ("", f"{float(decibels(here) - decibels(there)):+.2f} dB, {turn:+.1f}°"),
        ]
