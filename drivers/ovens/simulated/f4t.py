"""A simulated Watlow F4T, control loop 1."""

import math

from drivers.ovens import f4t
from drivers.ovens.f4t_profile import START
from drivers.ovens.simulated.f4t_profiles import SimulatedProfiles
from drivers.ovens.simulated.modbus_server import ModbusServer, float_words, words_float
from drivers.ovens.simulated.regulated_oven import RegulatedOven

MINUTES = {57: 1.0, 39: 60.0}
NO_RAMP = 62
CELSIUS = 15


class SimulatedF4T(ModbusServer):
    """Answers for the registers a ramp needs: floats low word first, choices in one register.

    Parameters
    ----------
    oven : RegulatedOven
    address : int
    low, high : float
        Its own set-point limits, degrees Celsius: beyond them it refuses.

    Attributes
    ----------
    locked : bool
        Acknowledges writes without effect.
    sensor_broken : bool
    profiles : bool
        Whether it has them.
    writes : list of tuple
        Register and words of every write, oldest first.
    """

    def __init__(self, oven: RegulatedOven, address: int = 1, low: float = -40.0, high: float = 180.0) -> None:
        super().__init__(address)
        self._oven = oven
        self._floats = {f4t.LOW_LIMIT: low, f4t.HIGH_LIMIT: high, f4t.SET_POINT: oven.working, f4t.RAMP_RATE: 0.0}
        self._choices = {f4t.MODE: f4t.OFF, f4t.RAMP_ACTION: NO_RAMP, f4t.RAMP_SCALE: 39, f4t.UNIT: CELSIUS}
        self._profiles = SimulatedProfiles(oven)
        self.locked = False
        self.profiles = True
        self.writes: list[tuple[int, tuple[int, ...]]] = []
        self.sensor_broken = False

    def read_word(self, register: int) -> int:
        """Return a choice, or half of a float."""
        self._note_end()
        if self.profiles and self._profiles.holds(register):
            return self._profiles.read(register)
        if register in self._choices:
            return self._choices[register]
        start = register - register % 2
        return float_words(self._float(start), low_first=True)[register - start]

    def write_words(self, register: int, words: tuple[int, ...]) -> None:
        """Store a choice, or a whole float."""
        self._note_end()
        self.writes.append((register, words))
        if self.profiles and self._profiles.holds(register):
            if not self.locked:
                was = self._profiles.running
                self._profiles.write(register, words)
                if was != self._profiles.running or register == START:
                    self._drive()
            return
        if register in self._choices:
            if not self.locked:
                changed = self._choices[register] != words[0]
                self._choices[register] = words[0]
                if changed or not self._profiles.running:
                    self._drive()
            return
        value = words_float(words, low_first=True)
        if register not in self._floats:
            raise LookupError(register)
        low, high = self._floats[f4t.LOW_LIMIT], self._floats[f4t.HIGH_LIMIT]
        if register == f4t.SET_POINT and not low <= value <= high:
            raise ValueError(f"set-point {value} beyond {low} to {high}")
        if not self.locked:
            self._floats[register] = value
            if not self._profiles.running:
                self._drive()

    def _float(self, register: int) -> float:
        if register == f4t.TEMPERATURE:
            return math.nan if self.sensor_broken else self._oven.measured
        if register == f4t.WORKING_SET_POINT:
            return self._oven.working
        return self._floats[register]

    def _note_end(self) -> None:
        """Switch the loop off where a profile has come to its end."""
        if self._profiles.end_if_over():
            self._choices[f4t.MODE] = f4t.OFF

    def _drive(self) -> None:
        if self._choices[f4t.MODE] != f4t.AUTO:
            self._oven.stop()
            return
        if self._profiles.running:
            self._profiles.drive(self._floats[f4t.SET_POINT])
            return
        ramps = self._choices[f4t.RAMP_ACTION] == f4t.RAMP_ON_SET_POINT
        rate = self._floats[f4t.RAMP_RATE] / MINUTES[self._choices[f4t.RAMP_SCALE]] if ramps else math.inf
        self._oven.go(self._floats[f4t.SET_POINT], rate)
