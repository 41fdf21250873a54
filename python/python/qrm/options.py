"""The options of a run as the extension module takes them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, SupportsFloat, Union

Number = Union[SupportsFloat, str]
"""A number, or a formula of numbers such as `"3*pi"`."""

NAMES = frozenset(
    {
        "method",
        "tolerance",
        "step",
        "end_time",
        "until",
        "start",
        "max_step",
        "projection",
        "closure_tolerance",
        "closure_iterations",
    }
)
"""The options of a run beside its parameters."""


def only_parameters(arguments: Mapping[str, Any], set: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Takes all arguments as parameters, to which those of `set` are added."""
    parameters = dict(arguments)
    for name, value in (set or {}).items():
        if name in parameters:
            raise TypeError(f"parameter `{name}` is given twice: by name and in `set`")
        parameters[name] = value
    return {"set": parameters}


def split(arguments: Mapping[str, Any], set: Mapping[str, Any] | None = None, **options: Any) -> dict[str, Any]:
    """Parts arguments into options and parameters, to which those of `set` are added."""
    parameters = {}
    for name, value in arguments.items():
        if name == "set":
            set = value
        elif name in NAMES:
            options[name] = value
        else:
            parameters[name] = value
    return {**only_parameters(parameters, set), **options}
