"""Output and inputs of a sound card, through the package ``sounddevice``: ``[cards] kind = "soundcard"``.

Declared are its channels, and what their full scale is worth.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from analysis.arrays import Real
from analysis.protocol.sweep import compare_drive
from drivers.clock import Clock, SystemClock
from drivers.interruptions import held_back
from drivers.ni.cards import Action, Cards, CardsSettings, DaqError, Record, Volts, go_on

Input = Annotated[str, Field(pattern=r"^in[1-9][0-9]?$", description="in1, in2, …")]
Output = Annotated[str, Field(pattern=r"^out[1-9][0-9]?$", description="out1, out2, …")]


class SoundCard(CardsSettings):
    """Channels of a sound card.

    Attributes
    ----------
    kind : str
    device : str
        Name of the device, or a part of it; the system's own choice if left out.
    output : str
        Drives the amplifier, and by a loop-back cable `drive_input`.
    drive_input : str
        Records the drive.
    responses : (K,) tuple of str
        Of the sensors, in the experiment's order.
    input_range, output_range : float
        Voltage of a sample of 1, V: what the volume controls are set to.
    """

    kind: Literal["soundcard"] = "soundcard"
    device: str = ""
    output: Output
    drive_input: Input
    responses: Annotated[tuple[Input, ...], Field(min_length=1)]
    sample_rate: Annotated[float, Field(ge=8_000.0, le=384_000.0, description="Hz")] = 48_000.0
    input_range: Volts
    output_range: Volts

    @property
    def inputs(self) -> tuple[str, ...]:
        """The drive's input, then the responses'."""
        return (self.drive_input, *self.responses)

    def open(self) -> Cards:
        """Open it through ``sounddevice``."""
        return SoundCards(self)

    @model_validator(mode="after")
    def _each_input_once(self) -> Self:
        for name in self.inputs:
            if self.inputs.count(name) > 1:
                raise ValueError(f"input {name!r} is used {self.inputs.count(name)} times")
        return self


def channel_number(name: str) -> int:
    """Return the number in a channel's name, from 1."""
    return int(name.removeprefix("out").removeprefix("in"))


LONGEST_LATENCY = 0.5
"""The longest way from output to input that is waited for, s."""
LEAD_SAMPLES = 64
"""Samples kept before the drive arrives."""
LATEST_END = 5.0
"""A stream may end so long after its last sample, s."""
END_INTERVAL = 0.1
"""The end of a sweep is looked for so often, s."""
TEST_LEVEL = 0.05
"""Of the loop-back test, share of the output's full scale."""
LOOPBACK_GAIN_ERROR = 0.05
"""The loop-back may have another gain than the full scales say by so much, as a share."""
TEST_BAND = (200.0, 2000.0)
"""Band of the loop-back test, Hz."""
MISSING = "install it: pip install 'flexura[soundcard]' (on Linux PortAudio besides: libportaudio2)"
NOT_STARTED = "start this computer's sound system, or connect a card; python -m sounddevice lists what it finds"


def backend() -> Any:
    """Return the package; DaqError where it, or PortAudio, is not installed, or PortAudio does not start."""
    try:
        return import_module("sounddevice")
    except (ImportError, OSError) as error:  # OSError: PortAudio is not there
        raise DaqError("loading sounddevice", str(error), None, Action.STOP, MISSING) from error
    except Exception as error:  # PortAudio starts while it is loaded, and fails with a class of that module's own
        raise DaqError("loading sounddevice", str(error), None, Action.STOP, NOT_STARTED) from error


class SoundCards:
    """A sound card with a loop-back cable from its output to the drive's input.

    Output and inputs have one clock. What the card plays arrives some hundredths of a second late: every record is
    cut so that the drive begins at the same sample. Before the first sweep, a quiet sound shows that the
    loop-back is there and that the full scales are those declared. An output at rest plays nothing, which is 0 V.

    Parameters
    ----------
    settings : SoundCard
    sound : optional
        Stands in for the package ``sounddevice``.
    clock : Clock, optional

    Raises
    ------
    DaqError
        If there is no such device, or it cannot do what is declared.
    """

    def __init__(self, settings: SoundCard, sound: Any = None, clock: Clock | None = None) -> None:
        self._settings = settings
        self._sound = sound if sound is not None else backend()
        self._clock = clock or SystemClock()
        self._delay: float | None = None
        self._proven = False
        self.zero()
        self._proven = True

    @property
    def sample_rate(self) -> float:
        """Rate of output and inputs, Hz."""
        return self._settings.sample_rate

    def sweep(self, drive: ArrayLike, check: Callable[[], None] = go_on) -> Record:
        """Play a drive (M,), V, and return M samples of what came back; see `drivers.ni.cards.Cards`.

        The first raises DaqError where the loop-back is not there, or not as loud as declared.
        """
        volts = np.ascontiguousarray(drive, dtype=np.float64)
        if volts.ndim != 1 or volts.size < 2 or not np.all(np.isfinite(volts)):
            raise ValueError(f"drive of shape {volts.shape}; (M,) finite voltages with M >= 2 allowed")
        peak = float(np.max(np.abs(volts)))
        if peak > self._settings.output_range:
            raise ValueError(f"drive reaches {peak:g} V; output_range allows {self._settings.output_range:g} V")
        with held_back() as let_through:

            def pausing() -> None:
                let_through()
                check()

            if self._delay is None:
                self._delay = self._loop_back()
            recorded = self._played(volts, pausing)
        recorded = recorded[:, self._first(recorded[0], volts, self._delay) :][:, : volts.size]
        return Record(recorded[0], recorded[1:], self.sample_rate, self._settings.input_range)

    def temperatures(self) -> Real:
        """Return none: a sound card has no thermocouples."""
        return np.empty(0)

    def zero(self) -> None:
        """End whatever is played; DaqError where the card does not take silence."""
        self._sound.stop()
        self._played(np.zeros(LEAD_SAMPLES), go_on, latency=0.0)

    def close(self) -> None:
        """Bring the output to 0 V."""
        with held_back():
            self.zero()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _played(self, volts: Real, pausing: Callable[[], None], latency: float = LONGEST_LATENCY) -> Real:
        """Play (M,), V, and return everything recorded meanwhile and a little longer, (1 + K, N), V."""
        settings = self._settings
        samples = np.append(
            volts / settings.output_range, np.zeros(LEAD_SAMPLES + round(latency * self.sample_rate))
        )
        doing = f"the sweep of {volts.size / self.sample_rate:.3g} s"
        deadline = self._clock.now() + samples.size / self.sample_rate + LATEST_END
        try:
            recorded = self._sound.playrec(
                samples.astype(np.float32)[:, None],
                samplerate=self.sample_rate,
                dtype="float32",
                input_mapping=[channel_number(name) for name in settings.inputs],
                output_mapping=[channel_number(settings.output)],
                device=settings.device or None,
                latency="high",
            )
            while self._sound.get_stream().active:
                if self._clock.now() > deadline:
                    step = "pull the device's cable and plug it in again"
                    raise DaqError(doing, "The device's stream does not end.", None, Action.LOST_DEVICE, step)
                self._clock.sleep(END_INTERVAL)
                pausing()
            status = self._sound.get_status()
        except (self._sound.PortAudioError, ValueError) as error:
            step = "look at the device's name and channels (python -m sounddevice lists them), its rate, its cable"
            # What was accepted before and is refused now has gone: that is no slip in the settings.
            action = Action.LOST_DEVICE if self._proven else Action.STOP
            raise DaqError(doing, str(error), None, action, step) from error
        finally:
            self._sound.stop()
        if status:
            step = "close other programs, turn off power saving, use a USB port of its own"
            raise DaqError(doing, f"Samples were lost: {status}", None, Action.RETRY_DISCARD, step)
        return np.asarray(recorded.T, dtype=np.float64) * settings.input_range

    def _first(self, recorded: Real, volts: Real, usual: float) -> int:
        """Return the sample with which a record is to begin: at the same moment of every sweep.

        `usual` is the delay of the loop-back test, in samples. Its fraction is the converters' own and stays;
        whole samples differ from stream to stream. Silence shows no delay.
        """
        first = round(usual) - LEAD_SAMPLES // 2
        if volts.any():
            padded = np.pad(volts, (0, recorded.size - volts.size))
            band = (0.002 * self.sample_rate, 0.45 * self.sample_rate)
            first += round(compare_drive(recorded, padded, self.sample_rate, band)[1] - usual)
        return min(max(first, 0), recorded.size - volts.size)

    def _loop_back(self) -> float:
        """Return the delay of the drive as recorded, samples; DaqError unless its level is the declared one."""
        settings, rate = self._settings, self.sample_rate
        rng = np.random.default_rng(0)
        size = round(0.25 * rate)
        grid = np.fft.rfftfreq(size, 1.0 / rate)
        phases = np.where(
            (grid > TEST_BAND[0]) & (grid < TEST_BAND[1]), np.exp(2j * np.pi * rng.random(grid.size)), 0.0
        )
        noise = np.fft.irfft(phases, size)
        played = TEST_LEVEL * settings.output_range * noise / np.abs(noise).max()
        recorded = self._played(played, go_on)[0]
        gain, delay, correlation = compare_drive(
            recorded, np.pad(played, (0, recorded.size - size)), rate, TEST_BAND
        )
        doing = f"the loop-back test from {settings.output} to {settings.drive_input}"
        if correlation < 0.9 or not 0.0 <= delay <= LONGEST_LATENCY * rate:
            said = f"What comes back is not what was played (correlation {correlation:.2f})."
            step = "connect the output to the drive's input, switch off monitoring and effects of the mixer"
            raise DaqError(doing, said, None, Action.STOP, step)
        if abs(gain - 1.0) > LOOPBACK_GAIN_ERROR:
            fitting = settings.input_range / gain
            said = f"{gain:.3f} times the voltage played comes back."
            step = (
                f"if cards.output_range is right, cards.input_range is {fitting:.4g} V instead of "
                f"{settings.input_range:g} V; else correct the volume controls"
            )
            raise DaqError(doing, said, None, Action.STOP, step)
        return delay
