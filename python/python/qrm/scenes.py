"""Scenes and methods by their names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import _native
from .mechanism import Mechanism
from .options import in_python

if TYPE_CHECKING:
    from os import PathLike


def scenes() -> list[str]:
    """Lists the scenes that are compiled into the package."""
    return _native.scenes()


def methods() -> dict[str, str]:
    """Lists the integration methods with what they are."""
    return {name: in_python(doc) for name, doc in _native.methods()}


def load(scene: str | PathLike[str]) -> Mechanism:
    """Loads a compiled scene by its name, or a scene file by its path.

    A file is read anew by each call. The equations of a file that is not a compiled scene are derived by the program
    `qrm-engine` where they are not in the cache, and interpreted.
    """
    return Mechanism(scene)
