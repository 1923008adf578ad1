"""Inputs and outputs of a plate at its ports, transfers between them and their derivatives.

Ports are one voltage per patch, one force per footprint. With b of a patch and the mean deflection d of a
footprint as columns of B, the plate's response is u = -Z**-1 B x, where x are volts on patches and minus the
forces along z. All outputs follow from the compliances between ports, G = B' Z**-1 B:

    a patch on an input, or open   (y + G_cc) x_c = -(G x)_c without x_c, y = Cp + Cc + 1/(j w R)
    a patch held at 0 V            q = b'u = -(G x), the charge it gives to its amplifier
    a motion                       (j w)**n d'u = -(j w)**n (G x), n = 0, 1, 2

A charge is the voltage times Cc in the limit of a large Cc, with its sign.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from analysis.arrays import Complex, Real
from analysis.channel import ORDER, Channel
from analysis.experiment import Experiment
from simulation.shell.electric_load import ElectricLoad

OPEN = ElectricLoad(np.inf)


@dataclass(frozen=True)
class Pickup:
    """Quantity that one output measures at its port.

    Attributes
    ----------
    port : int
    voltage : bool
        Whether it is the port's voltage; if not, a charge or a motion.
    order : int
        Number of time derivatives of a motion.
    sign : float
    """

    port: int
    voltage: bool = True
    order: int = 0
    sign: float = 1.0


@dataclass(frozen=True)
class Instruments:
    """One input, K outputs, and patches that carry a voltage of their own, over P patches and S footprints.

    Attributes
    ----------
    source : int
        Port that is driven.
    amplitude : float
        Voltage or force at that port per unit of the input.
    connected : tuple of int
        Patches on inputs, and open ones.
    loads : tuple of ElectricLoad
        Across each of them.
    pickups : tuple of Reading
        Of the outputs.
    """

    source: int
    amplitude: float
    connected: tuple[int, ...]
    loads: tuple[ElectricLoad, ...]
    pickups: tuple[Pickup, ...]

    def __post_init__(self) -> None:
        if not self.pickups or self.source in self.connected:
            raise ValueError(
                f"instruments: {len(self.pickups)} outputs, port {self.source} driven; at least one "
                f"output is needed, and no driven port among those connected, {self.connected}"
            )
        if any(pickup.voltage and pickup.port not in self.connected for pickup in self.pickups):
            raise ValueError(f"instruments: a voltage is read of a port that is not among {self.connected}")

    @classmethod
    def of_patches(cls, actuator: int, sensors: Sequence[int], load: ElectricLoad) -> Self:
        """Drive one patch and read the voltage of others, a load across each.

        Parameters
        ----------
        actuator : int
            Port of the patch that is driven.
        sensors : sequence of int
            Ports of the patches that are read.

        Returns
        -------
        Instruments
        """
        pickups = tuple(Pickup(port) for port in sensors)
        return cls(actuator, 1.0, tuple(sensors), (load,) * len(pickups), pickups)

    @classmethod
    def of(cls, experiment: Experiment, source: Channel | None = None) -> Self:
        """Take all declared instruments, and one input, the first by default; other actuators are held at 0 V."""
        source = source or experiment.inputs[0]
        inputs = experiment.acquisition
        load = ElectricLoad(inputs.input_resistance, inputs.input_capacitance)
        wired = {c.patch: load for c in experiment.outputs if c.quantity == "voltage" and c.patch is not None}
        wired |= {k: OPEN for k, patch in enumerate(experiment.patch) if patch.role == "open"}
        port = ports(experiment)
        return cls(
            source=port[source.id],
            amplitude=-source.footprint.along if source.footprint else 1.0,
            connected=tuple(wired),
            loads=tuple(wired.values()),
            pickups=tuple(
                Pickup(
                    port[output.id],
                    output.quantity == "voltage",
                    ORDER.get(output.quantity, 0),
                    output.footprint.along if output.footprint else 1.0,
                )
                for output in experiment.outputs
            ),
        )

    @property
    def seen(self) -> tuple[int, ...]:
        """Ports whose compliances are needed: the connected ones, then other outputs, each once."""
        others = (pickup.port for pickup in self.pickups if not pickup.voltage)
        return tuple(dict.fromkeys((*self.connected, *others)))

    @property
    def driving(self) -> tuple[int, ...]:
        """Ports that drive the plate: the connected ones, then the input."""
        return (*self.connected, self.source)

    def admittance(self, capacitance: Real, compliance: Complex, frequency: ArrayLike) -> Complex:
        """Return Y + G of the connected ports.

        Parameters
        ----------
        capacitance : (P,) ndarray
            Of all patches, F.
        compliance : (c, c, F) ndarray
            G between the connected ports.
        frequency : (F,) array_like, Hz, above 0

        Returns
        -------
        (F, c, c) complex ndarray, F
        """
        total = np.moveaxis(compliance, -1, 0).astype(complex)
        own = np.arange(len(self.connected))
        total[:, own, own] += self.across(capacitance, frequency).T
        return total

    def across(self, capacitance: Real, frequency: ArrayLike) -> Complex:
        """Return Y of the connected ports, (c, F), F; `capacitance` (P,) is that of all patches, F."""
        lines = np.atleast_1d(np.asarray(frequency, float))
        loads = zip(self.connected, self.loads, strict=True)
        found = [load.across(capacitance[[port]], lines)[0] for port, load in loads]
        return np.reshape(found, (len(self.connected), lines.size)).astype(complex)

    def wired(self, resistance: float, capacitance: float) -> Self:
        """Return the same with resistance and capacitance of all inputs multiplied by factors."""
        loads = tuple(ElectricLoad(a.resistance * resistance, a.capacitance * capacitance) for a in self.loads)
        return replace(self, loads=loads)

    def across_change(
        self, capacitance: Real, resistance: float, input_capacitance: float, frequency: Real
    ) -> Complex:
        """Differentiate `across` by a parameter.

        Parameters
        ----------
        capacitance : (P,) ndarray, F
            Derivative of those of all patches.
        resistance, input_capacitance : float
            Relative derivatives of those of all inputs.
        frequency : (F,) ndarray, Hz, above 0

        Returns
        -------
        (c, F) complex ndarray, F
        """
        omega = 2 * np.pi * frequency
        rows = [
            capacitance[port] + load.capacitance * input_capacitance - resistance / (1j * omega * load.resistance)
            for port, load in zip(self.connected, self.loads, strict=True)
        ]
        return np.reshape(rows, (len(self.connected), omega.size)).astype(complex)

    def factors(self, frequency: ArrayLike) -> Complex:
        """-sign (j w)**n of every output on its port's (G x), (K, F); 0 for voltages."""
        s = 2j * np.pi * np.atleast_1d(np.asarray(frequency, float))
        return np.array([0.0 * s if one.voltage else -one.sign * s**one.order for one in self.pickups])


def ports(experiment: Experiment) -> dict[str, int]:
    """Port of every input and output: patches as declared, then `Experiment.footprints`."""
    channels = (*experiment.inputs, *experiment.outputs)
    placed = [channel.id for channel in channels if channel.footprint is not None]
    found = {channel.id: channel.patch for channel in channels if channel.patch is not None}
    return found | {name: len(experiment.patch) + k for k, name in enumerate(placed)}


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
