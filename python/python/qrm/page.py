"""Pages that show a mechanism moving, in a notebook or a browser."""

from __future__ import annotations

import html
from os import PathLike
from pathlib import Path


class Page:
    """A page with everything in it. A notebook shows it in the output of a cell."""

    html: str
    """The text of the page."""

    def __init__(self, title: str, text: str, height: int):
        self._title, self._height = title, height
        self.html = text

    def __repr__(self) -> str:
        return f"<Page of {self._title}: {len(self.html) // 1000} kB; `save` writes it to a file>"

    def _repr_html_(self) -> str:
        # A frame of its own keeps styles and scripts of page and notebook apart.
        return (
            f'<iframe title="{html.escape(self._title)}" srcdoc="{html.escape(self.html)}" width="100%" '
            f'height="{self._height}" style="border: 0" sandbox="allow-scripts allow-downloads"></iframe>'
        )

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the page to a file, which any browser shows."""
        Path(path).write_text(self.html, encoding="utf-8")
