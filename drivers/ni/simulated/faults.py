"""What is to go wrong on the simulated rig, and when; how the driver refuses."""

from dataclasses import dataclass

from nidaqmx.error_codes import DAQmxErrors


class DaqmxStatusError(Exception):
    """A call the driver refuses.

    Parameters
    ----------
    error : DAQmxErrors or int
    message : str
        As the driver would word it for a person.
    """

    def __init__(self, error: DAQmxErrors | int, message: str) -> None:
        self.code = int(error)
        super().__init__(message)


def status_name(code: int) -> str:
    """Return the driver's name for a status, in words."""
    try:
        return str(DAQmxErrors(code).name).replace("_", " ").capitalize()
    except ValueError:
        return "Unknown status"


@dataclass(frozen=True)
class FailingCall:
    """One kind of call fails with a status of the driver's.

    Attributes
    ----------
    call : str
        Name of the remote call: "ReadAnalogF64", "StartTask", …
    code : int
        Status it fails with.
    first : int
        Which of these calls is the first to fail, counted from 1 after the fault is put in.
    times : int
        How many in a row fail.
    """

    call: str
    code: int
    first: int = 1
    times: int = 1

    def __post_init__(self) -> None:
        if self.code >= 0:
            raise ValueError(f"status {self.code}; an error's is negative")
        if self.first < 1 or self.times < 1:
            raise ValueError(f"fails from call {self.first} on, {self.times} times; both at least 1")

    def strikes(self, count: int) -> bool:
        """Whether the call that is number `count`, from 1, fails."""
        return self.first <= count < self.first + self.times


@dataclass(frozen=True)
class Faults:
    """Everything that is to go wrong.

    Attributes
    ----------
    calls : tuple of FailingCall
    unplugged : (float, float), optional
        From when to when, s on the rig's clock, the chassis is not there.
    unplugged_code : int
        What a task that is running then fails with.
    stalled_at, stalled : float
        At the first read after `stalled_at` the reading program loses `stalled` seconds, s.
    dead_inputs : frozenset of str
        Input terminals whose cable is broken.
    stuck_trigger : bool
        The input's start trigger never reaches the output.
    """

    calls: tuple[FailingCall, ...] = ()
    unplugged: tuple[float, float] | None = None
    unplugged_code: int = -201003
    stalled_at: float = float("inf")
    stalled: float = 0.0
    dead_inputs: frozenset[str] = frozenset()
    stuck_trigger: bool = False

    def __post_init__(self) -> None:
        if self.unplugged is not None and not self.unplugged[0] < self.unplugged[1]:
            raise ValueError(f"unplugged from {self.unplugged[0]} to {self.unplugged[1]} s; the end must be later")
        if not self.stalled >= 0.0:
            raise ValueError(f"stalled for {self.stalled} s; 0 or above allowed")
