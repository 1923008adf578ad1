"""Base of everything that is declared in a settings file."""

from pydantic import BaseModel, ConfigDict


class Declared(BaseModel):
    """Frozen settings that accept no unknown key and no infinite or missing number."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
