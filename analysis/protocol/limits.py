"""What stops a campaign, and what makes it repeat a sweep.

Apart from the protocol, because the watchdog's process reads it: that imports nothing which may crash or be large.
"""

from typing import Annotated, Self

from pydantic import Field, model_validator

from analysis.declaration.strict import Declared, Temperature


class Limits(Declared):
    """Limits of the rig and of a good sweep.

    They never replace the oven's own over-temperature limiter.
    """

    coldest: Annotated[Temperature, Field(description="degrees Celsius; a colder reading stops the campaign")]
    hottest: Annotated[Temperature, Field(description="degrees Celsius; a hotter reading stops the campaign")]
    patch_voltage: Annotated[
        float | None, Field(gt=0.0, le=2000.0, description="V, rated amplitude on the driven patch")
    ] = None
    retries: Annotated[int, Field(ge=0, le=10, description="further attempts at one sweep")] = 2
    coherence: Annotated[
        float, Field(ge=0.0, le=1.0, description="least median over the band, over the repeats")
    ] = 0.8
    silence: Annotated[float, Field(ge=0.0, le=10.0, description="V rms; a response below it is none")] = 2e-4
    drift: Annotated[
        float, Field(gt=0.0, le=20.0, description="K, largest change of temperature during one sweep")
    ] = 0.5
    lost_after: Annotated[
        float, Field(ge=5.0, le=36_000.0, description="s without cards, oven or usable reading before it stops")
    ] = 120.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.coldest >= self.hottest:
            raise ValueError(f"coldest {self.coldest:g} °C must be below hottest {self.hottest:g} °C")
        return self
