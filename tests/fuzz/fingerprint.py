"""A digest of what was read from a file, by which a silent change is seen."""

import hashlib
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel


def fingerprint(value: object) -> str:
    """Digest of what was read, the same for the same values."""
    digest = hashlib.sha256()
    _feed(digest.update, value)
    return digest.hexdigest()


def _feed(update: Callable[[bytes], Any], value: object) -> None:
    if isinstance(value, BaseModel):
        update(value.model_dump_json().encode())
    elif is_dataclass(value) and not isinstance(value, type):
        for field in fields(value):
            _feed(update, getattr(value, field.name))
    elif isinstance(value, np.ndarray):
        update(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    elif isinstance(value, dict):
        for key in sorted(value):
            update(str(key).encode())
            _feed(update, value[key])
    elif isinstance(value, tuple | list):
        for part in value:
            _feed(update, part)
    else:
        update(repr(value).encode())
