"""What every declaration is made of: strict settings, and numbers whose ranges catch a wrong unit."""

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, SerializerFunctionWrapHandler, model_serializer

Coordinate = Annotated[float, Field(ge=-1000.0, le=1000.0, description="m")]
Point = tuple[Coordinate, Coordinate]
Length = Annotated[float, Field(ge=0.01, le=5.0, description="m")]
Width = Annotated[float, Field(ge=0.001, le=1.0, description="m")]
Thickness = Annotated[float, Field(ge=1e-4, le=0.05, description="m")]
TEMPERATURES = (-80.0, 200.0)
"""Degrees Celsius: a room's temperature in kelvin lies outside, and is refused."""
Temperature = Annotated[float, Field(ge=TEMPERATURES[0], le=TEMPERATURES[1], description="degrees Celsius")]
Degrees = Annotated[float, Field(ge=-360.0, le=360.0, description="degrees, counter-clockwise")]
LONGEST_NAME, LONGEST_PATH = 255, 1000
"""Bytes that file systems allow to a name; to names of folders and a file together, with room for those above."""


def _possible(name: str) -> str:
    longest = max(len(part.encode()) for part in name.split("/"))
    whole = len(name.encode())
    for what, seen, most in (("a name", longest, LONGEST_NAME), ("a path", whole, LONGEST_PATH)):
        if seen > most:
            raise ValueError(f"{what} of {seen} bytes; no file can have more than {most}")
    return name


FileName = Annotated[str, Field(min_length=1), AfterValidator(_possible)]
"""Beside the declaration, or in a folder there. A name that no file can have would be an error of the system."""


class Declared(BaseModel):
    """Frozen settings that accept no unknown key and no infinite or missing number."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy with other values; what was computed from the values before is not copied."""
        copied = super().model_copy(update=update, deep=deep)
        for name in set(copied.__dict__) - set(type(self).model_fields):
            del copied.__dict__[name]
        return copied


class Sparse(Declared):
    """Settings that are dumped without what is as it is by default, except the keys in `always`.

    A declaration that uses nothing new is written, and named in caches, as it was before there was anything new.
    """

    always: ClassVar[frozenset[str]] = frozenset()

    @model_serializer(mode="wrap")
    def _declared_only(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        left_out = self._left_out()
        return {name: value for name, value in dump(self).items() if name not in left_out}

    def _left_out(self) -> set[str]:
        """Keys that are not dumped."""
        found = set()
        for name, field in type(self).model_fields.items():
            if name not in self.always and not field.is_required() and getattr(self, name) == field.default:
                found |= {name, field.alias or name}
        return found
