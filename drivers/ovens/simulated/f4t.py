"""A simulated Watlow F4T, control loop 1, with its profiles: edited one at a time, run on loop 1."""

import math

from drivers.ovens import f4t
from drivers.ovens import f4t as at
from drivers.ovens.f4t import START
from drivers.ovens.simulated.controller import ModbusServer, float_words, words_float
from drivers.ovens.simulated.regulated_oven import RegulatedOven

MINUTES = {57: 1.0, 39: 60.0}
NO_RAMP = 62
CELSIUS = 15


NOT_RUNNING, NONE = 253, 61
STEPS = range(at.KIND, at.KIND + 50 * at.STEP)


class SimulatedProfiles:
    """Profiles of a ramp, a hold and an end with the loop off; others are kept, and refused when they are started.

    Parameters
    ----------
    oven : RegulatedOven

    Attributes
    ----------
    running : bool
        Whether one was started and has not been ended since.
    """

    def __init__(self, oven: RegulatedOven) -> None:
        self._oven = oven
        self._profiles: dict[int, dict[int, int]] = {}
        self._registers = {at.EDITED: 1, at.EDIT: 0, at.NUMBER: 1, at.FIRST_STEP: 1, at.START: 0, at.STOP: 0}
        self._step = 1
        self.running = False

    def end_if_over(self) -> bool:
        """End the one that runs if it has come to its end; say whether it has."""
        over = self.running and self._oven.stop_at < math.inf and not self._oven.regulating
        if over:
            self.running, self._oven.stop_at = False, math.inf
        return over

    def holds(self, register: int) -> bool:
        """Whether a register is one of these."""
        return register in self._registers or register in (at.STEPS, at.STATE) or register in STEPS

    def read(self, register: int) -> int:
        """Return a register; LookupError where the profile edited has none."""
        if register == at.STATE:
            return at.RUNNING if self.running else NOT_RUNNING
        if register == at.STEPS:
            return sum((word - at.KIND) % at.STEP == 0 for word in self._edited(required=False))
        return self._registers[register] if register in self._registers else self._edited().get(register, NONE)

    def write(self, register: int, words: tuple[int, ...]) -> None:
        """Store registers, begin or end a profile; ValueError for what is not simulated."""
        if register in STEPS:
            # a step's registers are there once it has a type
            edited = self._edited()
            if (register - at.KIND) % at.STEP == 0:
                edited.update({register + offset: 0 for offset in range(at.STEP)})
            edited.update({register + i: word for i, word in enumerate(words)})
            return
        (value,) = words
        self._registers[register] = value
        if register == at.EDIT and value == at.ADD:
            self._profiles[self._registers[at.EDITED]] = {}
        elif register == at.EDIT and value == at.DELETE:
            del self._profiles[self._registers[at.EDITED]]
        elif register == at.START and value == at.BEGIN:
            self._step = self._registers[at.FIRST_STEP]
            self._started()
            self.running, self._oven.stop_at = True, math.inf
        elif register == at.STOP and value == at.TERMINATE:
            self.running, self._oven.stop_at = False, math.inf

    def drive(self, start: float) -> None:
        """Let the loop follow the profile that runs, from its own set-point."""
        steps = self._started()
        target, dwell = self._target(steps, 1), self._duration(steps, 1)
        if self._step == 1:
            self._oven.run(target, 60.0 * abs(target - start) / self._duration(steps, 0), dwell, start)
        else:
            self._oven.run(target, math.inf, dwell)

    def _edited(self, *, required: bool = True) -> dict[int, int]:
        found = self._profiles.get(self._registers[at.EDITED])
        if found is None and required:
            raise LookupError("no such profile")
        return {} if found is None else found

    def _started(self) -> dict[int, int]:
        steps = self._profiles.get(self._registers[at.NUMBER], {})
        kinds = [steps.get(at.KIND + at.STEP * i) for i in range(3)]
        if kinds != [at.RAMP, at.HOLD, at.END] or steps[at.END_MODE + 2 * at.STEP] != at.LOOP_OFF:
            raise ValueError(f"a profile of steps {kinds} is not simulated")
        return steps

    def _target(self, steps: dict[int, int], step: int) -> float:
        first = at.TARGET + at.STEP * step
        return words_float((steps[first], steps[first + 1]), low_first=True)

    def _duration(self, steps: dict[int, int], step: int) -> float:
        hours, minutes, seconds = (
            steps[register + at.STEP * step] for register in (at.HOURS, at.MINUTES, at.SECONDS)
        )
        return 3600.0 * hours + 60.0 * minutes + seconds


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
