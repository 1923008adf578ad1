"""The simulated controller that answers the driver of one kind."""

from drivers.clock import Clock
from drivers.ovens.eurotherm import MODEL_2400, MODEL_3500
from drivers.ovens.settings import OvenSettings
from drivers.ovens.simulated.controller import Controller
from drivers.ovens.simulated.espec import SimulatedEspec
from drivers.ovens.simulated.eurotherm import SimulatedEurotherm
from drivers.ovens.simulated.f4t import SimulatedF4T
from drivers.ovens.simulated.regulated_oven import RegulatedOven
from drivers.ovens.simulated.votsch import SimulatedVotsch


def simulated_controller(settings: OvenSettings, oven: RegulatedOven, clock: Clock) -> Controller:
    """Return the controller that `settings` describe, around `oven`.

    Parameters
    ----------
    settings : OvenSettings
    oven : RegulatedOven
    clock : Clock
        The oven's.
    """
    match settings.kind:
        case "eurotherm-2400" | "eurotherm-3500":
            registers = MODEL_2400 if settings.kind == "eurotherm-2400" else MODEL_3500
            return SimulatedEurotherm(oven, registers, settings.address, settings.decimals)
        case "votsch-ascii2":
            return SimulatedVotsch(oven, settings.address)
        case "espec-p300":
            return SimulatedEspec(oven, clock)
        case "watlow-f4t":
            return SimulatedF4T(oven, settings.address)
