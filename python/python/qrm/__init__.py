"""Mechanisms with closed loops: linkages in, motion and forces out.

>>> import qrm
>>> m = qrm.load("quick-return")
>>> result = m.run(O2A=0.25, method="dop853", tolerance=1e-10)
>>> result["x6"].max(), result.units["x6"], result.errors["x6"]
"""

from __future__ import annotations

from ._engine import choose_engine
from .accuracy import Accuracy
from .equations import Equations
from .errors import Error, Finding, OptionError, RunError, RunWarning, SceneError
from .mechanism import Mechanism
from .modes import LinearModel, Modes
from .page import Page
from .quantity import Quantity
from .result import Result
from .scenes import load, methods, scenes
from .sensitivity import MotionQuantity, Objectives, Sensitivity
from .steady import Steady
from .sweep import SweepTable

__all__ = [
    "Accuracy",
    "Equations",
    "Error",
    "Finding",
    "LinearModel",
    "Mechanism",
    "Modes",
    "MotionQuantity",
    "Objectives",
    "OptionError",
    "Page",
    "Quantity",
    "Result",
    "RunError",
    "RunWarning",
    "SceneError",
    "Sensitivity",
    "Steady",
    "SweepTable",
    "load",
    "methods",
    "scenes",
]

choose_engine()
