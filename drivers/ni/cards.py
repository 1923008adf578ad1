"""What a rig asks of its cards, what they give back, and what they refuse.

An error says which action it requires, and has the message for the user.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from analysis.declaration.strict import Sparse
from drivers.kinds import Kinds


class Action(Enum):
    """What a campaign does about an error; the value is how often one sweep may be tried again.

    Tries are few because the plate's temperature keeps moving while they are made.
    """

    RETRY_DISCARD = ("discard the sweep and repeat it", 3)
    RETRY_ONCE = ("repeat the sweep once, then stop", 1)
    STOP = ("stop: repeating cannot help", 0)
    LIST_EXISTING = ("stop and name what exists", 0)
    RESERVED = ("stop until the other program releases it", 0)
    LOST_DEVICE = ("hold the oven, search for the device, resume", 0)

    def __init__(self, meaning: str, retries: int) -> None:
        self.meaning = meaning
        self.retries = retries


@dataclass(frozen=True)
class KnownError:
    """An NI-DAQmx error this rig can meet.

    Attributes
    ----------
    code : int
        The driver's status.
    name : str
        What `nidaqmx.error_codes.DAQmxErrors` calls it.
    action : Action
    next_step : str
        What a person can do about it.
    """

    code: int
    name: str
    action: Action
    next_step: str


_SLOW = "the computer fell behind: close other programs, turn off power saving, use a USB port of its own"
_STARVED = "the output ran dry: close other programs, use a USB port of its own"
_SETTING = "correct this setting of the rig; the module's data sheet states what it allows"
_TRIGGER = "no samples arrived: check that the sweep is started by the input task's own start trigger"
CHECK_CABLE = "check the chassis' power and its USB or network cable, then run the same command again to resume"
_NAME = "correct the name in the rig's settings"
_TAKEN = (
    "close the program that holds it (NI MAX test panel, LabVIEW, another acquisition) and start again; "
    "on a computer named in cards.grpc, restart the NI gRPC Device Server if no program holds it"
)

KNOWN_ERRORS = (
    KnownError(-200279, "SAMPLES_NO_LONGER_AVAILABLE", Action.RETRY_DISCARD, _SLOW),
    KnownError(-200361, "INPUT_FIFO_OVERFLOW_2", Action.RETRY_DISCARD, _SLOW),
    KnownError(-200010, "INPUT_FIFO_OVERFLOW", Action.RETRY_DISCARD, _SLOW),
    KnownError(-200019, "ADC_OVERRUN", Action.RETRY_DISCARD, _SLOW),
    KnownError(-200290, "GEN_STOPPED_TO_PREVENT_REGEN_OF_OLD_SAMPLES", Action.RETRY_DISCARD, _STARVED),
    KnownError(-200018, "DAC_UNDERFLOW", Action.RETRY_DISCARD, _STARVED),
    KnownError(-200621, "OUTPUT_FIFO_UNDERFLOW_2", Action.RETRY_DISCARD, _STARVED),
    KnownError(-200284, "SAMPLES_NOT_YET_AVAILABLE", Action.RETRY_ONCE, _TRIGGER),
    KnownError(-200560, "WAIT_UNTIL_DONE_DOES_NOT_INDICATE_DONE", Action.RETRY_ONCE, _TRIGGER),
    KnownError(-200077, "INVALID_ATTRIBUTE_VALUE", Action.STOP, _SETTING),
    KnownError(-200452, "ATTRIBUTE_NOT_SUPPORTED_IN_TASK_CONTEXT", Action.STOP, _SETTING),
    KnownError(-200265, "INVALID_ANALOG_TRIG_SRC", Action.STOP, _SETTING),
    KnownError(
        -200561, "INVALID_AO_DATA_WRITE", Action.STOP, "lower the drive level: it leaves the output's range"
    ),
    KnownError(-89120, "INVALID_ROUTING_SOURCE_TERMINAL_NAME_ROUTING", Action.STOP, _SETTING),
    KnownError(-200170, "PHYSICAL_CHAN_DOES_NOT_EXIST", Action.LIST_EXISTING, _NAME),
    KnownError(-200220, "INVALID_DEVICE_ID", Action.LIST_EXISTING, _NAME),
    KnownError(-50103, "PAL_RESOURCE_RESERVED", Action.RESERVED, _TAKEN),
    KnownError(-200022, "RESOURCE_ALREADY_RESERVED", Action.RESERVED, _TAKEN),
    KnownError(-201003, "DEV_CANNOT_BE_ACCESSED", Action.LOST_DEVICE, CHECK_CABLE),
    KnownError(-200324, "DEV_ABSENT_OR_UNAVAILABLE", Action.LOST_DEVICE, CHECK_CABLE),
    KnownError(-88705, "DRIVER_DEVICE_GUID_NOT_FOUND_ROUTING", Action.LOST_DEVICE, CHECK_CABLE),
    KnownError(-88709, "RUNTIME_ABORTED_ROUTING", Action.LOST_DEVICE, CHECK_CABLE),
    KnownError(-88710, "RUNTIME_ABORTING_ROUTING", Action.LOST_DEVICE, CHECK_CABLE),
    KnownError(-50405, "PAL_TRANSFER_ABORTED", Action.LOST_DEVICE, CHECK_CABLE),
)


class DaqError(Exception):
    """A card, its driver or the way to it failed.

    Parameters
    ----------
    doing : str
        What was being done, as the end of "… failed".
    said : str
        The vendor's own words.
    code : int, optional
        The vendor's status, where there is one.
    action : Action
    next_step : str
        What a person can do about it.
    existing : tuple of str
        What can be named instead, for a name that does not exist.
    """

    def __init__(
        self,
        doing: str,
        said: str,
        code: int | None,
        action: Action,
        next_step: str,
        existing: tuple[str, ...] = (),
    ) -> None:
        self.doing = doing
        self.said = " ".join(said.split()).rstrip(".") + "."
        self.code = code
        self.action = action
        self.next_step = next_step
        self.existing = existing
        status = "" if code is None else f" (NI-DAQmx {code})"
        listed = f" What exists: {', '.join(existing)}." if existing else ""
        super().__init__(f"{doing} failed{status}: {self.said} Next step: {next_step}.{listed}")


def from_status(doing: str, code: int, said: str, existing: tuple[str, ...] = ()) -> DaqError:
    """Return the error for a driver's status; one not in the table stops the campaign.

    Parameters
    ----------
    doing, said : str
        See `DaqError`.
    code : int
        The driver's status.
    existing : tuple of str
        What exists; in the message only if a name was wrong.

    Returns
    -------
    DaqError
        With the table's action and next step. It is returned, not raised.
    """
    known = next((error for error in KNOWN_ERRORS if error.code == code), None)
    if known is None:
        step = "look the status up in NI's documentation; `nidaqmx.error_codes` names it"
        return DaqError(doing, said, code, Action.STOP, step)
    listed = existing if known.action is Action.LIST_EXISTING else ()
    return DaqError(doing, said, code, known.action, known.next_step, listed)


@dataclass(frozen=True)
class Record:
    """One sweep as the input module recorded it.

    Attributes
    ----------
    drive : (M,) ndarray, V
        As recorded beside the responses, never as asked for.
    responses : (K, M) ndarray, V
    sample_rate : float
        As read back, Hz.
    full_scale : float
        Voltage beyond which the inputs clip, V.
    """

    drive: NDArray[np.float64]
    responses: NDArray[np.float64]
    sample_rate: float
    full_scale: float

    def __post_init__(self) -> None:
        if self.drive.ndim != 1 or self.responses.ndim != 2 or self.responses.shape[1] != self.drive.size:
            raise ValueError(
                f"drive of shape {self.drive.shape} and responses of shape {self.responses.shape}; "
                "(M,) and (K, M) allowed"
            )
        if not self.sample_rate > 0.0 or not self.full_scale > 0.0:
            raise ValueError(
                f"sample rate {self.sample_rate:g} Hz and full scale {self.full_scale:g} V; both above 0"
            )

    @property
    def overloaded(self) -> NDArray[np.bool_]:
        """(1 + K,) Whether each channel, drive first, came within 0.1 % of where it clips."""
        signals = np.vstack([self.drive[None], self.responses])
        return np.asarray(np.max(np.abs(signals), axis=1) >= 0.999 * self.full_scale)


def go_on() -> None:
    """Wish for no end."""


class Cards(Protocol):
    """Output, inputs and thermocouples of a rig, ready for use."""

    @property
    def sample_rate(self) -> float:
        """Rate of both output and inputs, as read back, Hz."""
        ...

    def sweep(self, drive: NDArray[np.float64], check: Callable[[], None] = go_on) -> Record:
        """Play `drive` (M,), V, and return what came back; `check`, called meanwhile, raises to break it off."""
        ...

    def temperatures(self) -> NDArray[np.float64]:
        """Return the thermocouples' readings now, degrees Celsius, in the wiring's order."""
        ...

    def zero(self) -> None:
        """Bring the output to 0 V."""
        ...

    def close(self) -> None:
        """Bring the output to 0 V and let go of the hardware."""
        ...


Volts = Annotated[float, Field(gt=0.0, le=60.0, description="V, magnitude")]


class CardsSettings(Sparse):
    """What every kind of cards declares. Each kind derives from it, adds its terminals, and opens them.

    Attributes
    ----------
    kind : str
    responses : (K,) tuple of str
        Inputs of the sensors, in the experiment's order, as the kind names them.
    sample_rate : float
        Asked for, Hz; what the hardware makes of it is read back.
    input_range, output_range : float
        Largest magnitude expected, V.
    """

    kind: Annotated[str, Field(description="how the cards are reached")]
    responses: Annotated[tuple[str, ...], Field(min_length=1)]
    sample_rate: Annotated[float, Field(ge=100.0, le=2e6, description="Hz")]
    input_range: Volts = 5.0
    output_range: Volts = 4.24

    @property
    def has_thermocouples(self) -> bool:
        """Whether `Cards.temperatures` gives any."""
        return False

    @property
    def settling(self) -> float:
        """How much earlier than its drive every sweep begins, s: for sensors whose supply has to settle."""
        return 0.0

    @property
    def places(self) -> tuple[str, ...]:
        """Devices that only one process can use, for messages and locks; none where that does not matter."""
        return ()

    def open(self) -> Cards:
        """Return the cards with their output at 0 V; DaqError where they cannot be opened. Obligatory."""
        raise NotImplementedError

    def _left_out(self) -> set[str]:
        return super()._left_out() & {"kind"}  # a campaign begun before there were kinds is still the same one


CARDS = Kinds(
    "flexura.cards",
    CardsSettings,
    {"ni": "drivers.ni.wiring:Wiring", "soundcard": "drivers.soundcard.card:SoundCard"},
)
