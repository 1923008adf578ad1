"""The profiles of a simulated Watlow F4T: edited one at a time, run on loop 1."""

import math

from drivers.ovens import f4t_profile as at
from drivers.ovens.simulated.modbus_server import words_float
from drivers.ovens.simulated.regulated_oven import RegulatedOven

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
