"""The options of a run as the extension module takes them."""

from __future__ import annotations

import re
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


_OF_COMMANDS = (
    "set",
    "vary",
    "of",
    "by",
    "at",
    "budget",
    "reference",
    "every",
    "threads",
    "no-extremes",
    "no-error-estimate",
)
_NAMES = "|".join(sorted({*_OF_COMMANDS, *(name.replace("_", "-") for name in NAMES)}))
_QUOTED = re.compile(rf"`--({_NAMES}) ([^`]+)`")
_OPTION = re.compile(rf"(?<![\w-])--({_NAMES})(?![\w-])")


def in_python(text: str) -> str:
    """The text with the options of the command as arguments of Python."""

    def quoted(match: re.Match[str]) -> str:
        name, value = match[1].replace("-", "_"), match[2]
        if name in ("set", "start"):
            return f"`{value}`"
        if not re.fullmatch(r"[\w.+-]+", value):
            return f"`{name}`: `{value}`"
        return f"`{name}={value}`" if value[0].isdigit() else f'`{name}="{value}"`'

    return _OPTION.sub(lambda match: match[1].replace("-", "_"), _QUOTED.sub(quoted, text))
