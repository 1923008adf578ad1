"""Who listens to a panel and what is to be heard: ``[sound]`` of its file."""

from itertools import pairwise
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from analysis.arrays import Real
from analysis.declaration.strict import Coordinate, Sparse
from analysis.radiation.radiator import LEAST_LISTENER_HEIGHT, Air, Mounting

Height = Annotated[float, Field(ge=LEAST_LISTENER_HEIGHT, le=100.0, description="m in front of the panel")]
Decibels = Annotated[float, Field(ge=-100.0, le=100.0, description="dB")]
Weight = Annotated[float, Field(ge=0.0, le=1e4)]
Frequency = Annotated[float, Field(ge=1.0, le=20_000.0, description="Hz")]


class SoundListener(Sparse):
    """Someone who hears the panel: an ear, or a microphone.

    Attributes
    ----------
    name : str
    position : (float, float, float)
        m, in the coordinates of the plate; the third is the height in front of the panel.
    zone : str
        Listeners of one zone hear the same programme.
    """

    name: Annotated[str, Field(min_length=1, max_length=40)]
    position: tuple[Coordinate, Coordinate, Height]
    zone: Annotated[str, Field(max_length=40)] = ""


class PanelSound(Sparse):
    """Listeners, air and mounting of a panel, the sound wanted, and the weights of what is wanted.

    Weights are of squared relative errors, beside 1 for the field's: that of pressure at listeners (or of net
    volume) over the wanted one, that of pressure in zones that are to be quiet over the wanted one elsewhere, and
    the power radiated by what moves outside the target over that of the target alone.
    """

    mounting: Annotated[Mounting, Field(description="in a rigid baffle, or the front of a closed box")] = "baffle"
    sound_speed: Annotated[float, Air.model_fields["sound_speed"]] = Air().sound_speed
    density: Annotated[float, Air.model_fields["density"]] = Air().density
    listener: Annotated[tuple[SoundListener, ...], Field(max_length=64)] = ()
    level: Annotated[
        float, Field(ge=-80.0, le=40.0, description="dB, of the sound of the target if it moved alone as asked")
    ] = -3.0
    curve: Annotated[
        tuple[tuple[Frequency, Decibels], ...],
        Field(max_length=100, description="Hz and dB on top of level; between them linear in log f"),
    ] = ()
    field_weight: Weight = 1.0
    sound_weight: Weight = 10.0
    quiet_weight: Weight = 10.0
    power_weight: Weight = 0.0

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        names = [one.name for one in self.listener]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"two listeners are named {twice[0]!r}; give each a name of its own")
        for (before, _), (after, _) in pairwise(self.curve):
            if not before < after:
                raise ValueError(f"curve: {after:g} Hz after {before:g} Hz; frequencies must ascend")
        if self.field_weight == 0.0 and self.sound_weight == 0.0:
            raise ValueError("field_weight and sound_weight are both 0: nothing is asked for; raise one of them")
        return self

    @property
    def air(self) -> Air:
        """The air in front."""
        return Air(sound_speed=self.sound_speed, density=self.density)

    def listeners(self, center: tuple[float, float]) -> tuple[SoundListener, ...]:
        """Those declared; else one at 1 m in front of the panel's `center`, m."""
        return self.listener or (SoundListener(name="axis", position=(*center, 1.0)),)

    def wanted(self, frequency: Real) -> Real:
        """Wanted level (F,) at `frequency` (F,), Hz, as a factor: `level` and `curve`."""
        if not self.curve:
            return np.full(len(frequency), 10.0 ** (self.level / 20.0))
        places, values = np.array(self.curve).T
        curve = np.interp(np.log(frequency), np.log(places), values)
        return np.asarray(10.0 ** ((self.level + curve) / 20.0))
