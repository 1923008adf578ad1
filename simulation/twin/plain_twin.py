"""The digital twin as an experiment sees it: one input, and all outputs at once."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analysis.channel import Channel
from analysis.experiment import Experiment
from analysis.material import MaterialBox
from simulation.reduction.modal_form import ModalForm
from simulation.reduction.reduced_model import ReducedModel
from simulation.twin.instruments import Instruments
from simulation.twin.transfer import Transfer

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Twin:
    """Transfer from one input of a plate to K outputs, in the units of both.

    Attributes
    ----------
    reduced : ReducedModel
        With the masses of its transducers, see `ReducedModel.loaded`.
    instruments : Instruments
        Its ports are the patches, then the footprints of `reduced`.
    """

    reduced: ReducedModel
    instruments: Instruments

    def __post_init__(self) -> None:
        count = self.reduced.capacitance.size + len(self.reduced.footprints)
        for port in (*self.instruments.driving, *self.instruments.seen):
            if not 0 <= port < count:
                raise ValueError(f"twin: port {port} is outside 0 to {count - 1}")

    @classmethod
    def of(cls, experiment: Experiment, reduced: ReducedModel, source: Channel | None = None) -> Self:
        """Join an experiment's instruments to the reduced model of its plate, patches and footprints.

        `source` is the input that is driven, the first unless given.
        """
        if len(reduced.footprints) != len(experiment.footprints):
            raise ValueError(
                f"twin: {len(experiment.footprints)} footprints are declared, the reduced model holds "
                f"{len(reduced.footprints)}"
            )
        masses = np.array([footprint.mass for footprint in experiment.footprints])
        return cls(reduced.loaded(masses), Instruments.of(experiment, source))

    @property
    def box(self) -> MaterialBox:
        """Where the twin may be asked."""
        return self.reduced.box

    @property
    def band(self) -> tuple[float, float]:
        """Frequencies at which the twin may be asked, Hz."""
        return self.reduced.band

    @property
    def error(self) -> float:
        """Error of the reduced model, see `ReducedModel.error`."""
        return self.reduced.error

    @property
    def outputs(self) -> int:
        """Number of outputs K."""
        return len(self.instruments.pickups)

    def frf(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """Return the outputs per unit of the input, (K, F); ValueError outside box or band."""
        material = (youngs_modulus, poisson_ratio, loss_factor)
        lines = np.atleast_1d(np.asarray(frequency, float))
        self.reduced.require(*material, lines)
        return self.uncertified_frf(*material, lines)

    def uncertified_frf(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> Complex:
        """As `frf`, at frequencies too for which nothing is certified."""
        lines = np.atleast_1d(np.asarray(frequency, float))
        modal = self.reduced.modal_form(youngs_modulus, poisson_ratio, loss_factor)
        return self._transfer(modal.compliance(*self._ports, lines), lines).response

    def sensitivities(
        self, youngs_modulus: float, poisson_ratio: float, loss_factor: float, frequency: ArrayLike
    ) -> tuple[Complex, Complex]:
        """Transfer (K, F) and its derivatives (3, K, F) with respect to E [1/Pa], nu and eta."""
        material = (youngs_modulus, poisson_ratio, loss_factor)
        lines = np.atleast_1d(np.asarray(frequency, float))
        self.reduced.require(*material, lines)
        modal: ModalForm = self.reduced.modal_form(*material)
        changes, weights = self.reduced.stiffness_derivatives(*material)
        compliance, slopes = modal.compliance_and_derivatives(*self._ports, changes, lines)
        transfer = self._transfer(compliance, lines)
        return transfer.response, np.einsum("pd,dkf->pkf", weights, transfer.change(slopes))

    @property
    def _ports(self) -> tuple[Real, Real]:
        """Columns of the ports that are seen, (r, N), and of those that drive, (r, c + 1)."""
        columns = self.reduced.ports
        return columns[:, list(self.instruments.seen)], columns[:, list(self.instruments.driving)]

    def _transfer(self, compliance: Complex, lines: Real) -> Transfer:
        return Transfer.of(self.instruments, self.reduced.capacitance, compliance, lines)

    def modes(self, youngs_modulus: float, poisson_ratio: float, loss_factor: float) -> tuple[Real, Real]:
        """Natural frequencies [Hz], ascending, and loss factors of the elastic modes up to the band's end.

        Hysteretic reading: a pole is w_n**2 (1 + j eta_n). Patches short-circuited. Modes below the band
        are good to a per cent or so: only their tails were trained.
        """
        poles = self.reduced.modal_form(youngs_modulus, poisson_ratio, loss_factor).damped_poles()
        elastic = poles[poles.real < (2 * np.pi * self.band[1]) ** 2]
        return np.sqrt(elastic.real) / (2 * np.pi), elastic.imag / elastic.real
