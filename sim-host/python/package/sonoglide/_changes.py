"""Changes of a scene: conversion of a mapping of keys to values to the text `key=value` of the command line."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

#: A value of a scene's key; `None` removes an optional number.
Value: TypeAlias = "bool | int | float | str | Sequence[Any] | Mapping[str, Any] | None"


def changes(values: Mapping[str, Value] | None) -> list[str]:
    """Returns the values as `key=value`, in order."""
    return [f"{key}={literal(value)}" for key, value in (values or {}).items()]


def literal(value: Any) -> str:
    """Formats a value as TOML."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {literal(item)}" for key, item in value.items()) + "}"
    if hasattr(value, "tolist"):  # numbers and arrays of NumPy
        return literal(value.tolist())
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, Sequence):
        return "[" + ", ".join(literal(item) for item in value) + "]"
    raise TypeError(f"a scene cannot contain values of type {type(value).__name__}")
