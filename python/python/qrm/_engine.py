"""The program `qrm-engine`, which derives the equations of scene files."""

from __future__ import annotations

import os
import shutil

from . import _native


def choose_engine() -> None:
    """Takes the engine that the environment variable `QRM_ENGINE` names, or else the one on the path."""
    program = os.environ.get("QRM_ENGINE") or shutil.which("qrm-engine")
    if program:
        _native.choose_engine(program)
