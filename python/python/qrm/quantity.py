"""Numbers that have a name."""

from __future__ import annotations

from typing import NamedTuple


class Quantity(NamedTuple):
    """A named number."""

    name: str
    unit: str
    """Its unit; empty for a number without one."""
    doc: str
    """What it is."""
