"""What a rig asks of its cards, and what they give back."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from analysis.declaration.strict import Sparse
from drivers.kinds import Kinds


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
