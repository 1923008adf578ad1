"""Transfers of a plate with instruments, and their derivatives, from compliances between ports."""

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from analysis.arrays import Complex, Real
from simulation.twin.instruments import Instruments


@dataclass(frozen=True)
class Transfer:
    """Outputs per unit of the input; see `simulation.twin.instruments` for the equations.

    Attributes
    ----------
    instruments : Instruments
    compliance : (N, c + 1, F) complex ndarray
        G of the N ports of `Instruments.seen` over the c + 1 of `Instruments.driving`.
    admittance : (F, c, c) complex ndarray
    voltage : (c, F) complex ndarray
        On the connected ports.
    frequency : (F,) ndarray, Hz
    factors : (K, F) complex ndarray
        Of `Instruments.factors`.
    response : (K, F) complex ndarray
    """

    instruments: Instruments
    compliance: Complex
    admittance: Complex
    voltage: Complex
    frequency: Real
    factors: Complex
    response: Complex

    @classmethod
    def of(cls, instruments: Instruments, capacitance: Real, compliance: Complex, frequency: Real) -> Self:
        """Connect all instruments at once.

        Parameters
        ----------
        capacitance : (P,) ndarray, F
            Of all patches.
        compliance : (N, c + 1, F) complex ndarray
            G of the ports of `Instruments.seen` over those of `Instruments.driving`.
        frequency : (F,) ndarray, Hz, above 0

        Returns
        -------
        Transfer
        """
        count = len(instruments.connected)
        admittance = instruments.admittance(capacitance, compliance[:count, :count], frequency)
        short = instruments.amplitude * compliance[:, -1]
        voltage = np.asarray(-np.linalg.solve(admittance, short[:count].T[..., None])[..., 0].T, complex)
        moved = short + np.einsum("ikf,kf->if", compliance[:, :-1], voltage)
        factors = instruments.factors(frequency)
        response = _read(instruments, voltage, moved, factors)
        return cls(instruments, compliance, admittance, voltage, np.asarray(frequency), factors, response)

    @cached_property
    def impedance(self) -> Complex:
        """Inverse of the admittance, (F, c, c)."""
        return np.asarray(np.linalg.inv(self.admittance))

    def change(self, slopes: Complex) -> Complex:
        """Differentiate `response`, (D, K, F), given the derivatives of the compliance, (D, N, c + 1, F).

        Y V = -h gives Y V' = -(h' + G' V), from which the other outputs follow.
        """
        count = len(self.instruments.connected)
        direct = self.instruments.amplitude * slopes[:, :, -1]
        direct = direct + np.einsum("dikf,kf->dif", slopes[:, :, :-1], self.voltage)
        voltage = np.asarray(-np.einsum("fck,dkf->dcf", self.impedance, direct[:, :count]))
        moved = direct + np.einsum("ikf,dkf->dif", self.compliance[:, :-1], voltage)
        return np.stack(
            [_read(self.instruments, one, other, self.factors) for one, other in zip(voltage, moved, strict=True)]
        )

    def drive(self, count: int) -> Complex:
        """Return x on all `count` ports, (count, F)."""
        x = np.zeros((count, self.response.shape[1]), complex)
        x[self.instruments.source] = self.instruments.amplitude
        x[list(self.instruments.connected)] = self.voltage
        return x

    def sense(self, count: int) -> Complex:
        """Differentiate each output by (G x) at each of `count` ports, at constant x, (K, count, F)."""
        instruments, connected = self.instruments, list(self.instruments.connected)
        inverse = -self.impedance.transpose(1, 2, 0)
        weights = np.zeros((len(instruments.pickups), count, self.response.shape[1]), complex)
        for k, pickup in enumerate(instruments.pickups):
            if pickup.voltage:
                weights[k, connected] = inverse[connected.index(pickup.port)]
            else:
                row = self.compliance[instruments.seen.index(pickup.port), :-1]
                weights[k, connected] = self.factors[k] * np.einsum("kf,kif->if", row, inverse)
                weights[k, pickup.port] += self.factors[k]
        return weights


def _read(instruments: Instruments, voltage: Complex, moved: Complex, factors: Complex) -> Complex:
    """Return the outputs (K, F) of voltages (c, F) on the connected ports and (G x) of the ports seen, (N, F)."""
    seen = instruments.seen
    return np.stack(
        [
            voltage[instruments.connected.index(one.port)] if one.voltage else factor * moved[seen.index(one.port)]
            for one, factor in zip(instruments.pickups, factors, strict=True)
        ]
    )
