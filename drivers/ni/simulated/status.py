"""The driver's refusals."""

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
