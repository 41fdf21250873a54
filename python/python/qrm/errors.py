"""The exceptions of the package: what is wrong, where, and how to mend it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from .options import in_python

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .result import Result


class Finding(NamedTuple):
    """A problem and its place in a scene."""

    path: str
    """The file of the scene."""
    line: int | None
    """The line, from 1 on; `None` for the whole file."""
    column: int | None
    """The column, from 1 on, in characters."""
    message: str
    """The problem, in one sentence."""
    hint: str | None
    """The way to mend it."""


class Error(Exception):
    """The base of all exceptions of the package."""

    hints: list[str]
    """The ways to mend it."""

    def __init__(self, message: str, hints: Sequence[str] = ()):
        message = in_python(message).removeprefix("error: ")
        super().__init__(message)
        self.hints = [in_python(hint) for hint in hints]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), self.args, self.__dict__


class OptionError(Error, ValueError):
    """A wrong option: an unknown name of a scene, parameter or method, or a value that cannot be."""


class SceneError(Error, ValueError):
    """A scene that is wrong, or that cannot be assembled with these values. The text shows the places."""

    findings: list[Finding]
    """All problems, in the order of the text."""

    def __init__(self, message: str, hints: Sequence[str] = ()):
        super().__init__(message, hints)
        self.findings = []

    def _set_findings(self, findings: Sequence[tuple[Any, ...]]) -> None:
        self.findings = [Finding(*finding) for finding in findings]

    @property
    def path(self) -> str | None:
        """The file of the scene."""
        return self.findings[0].path if self.findings else None

    @property
    def line(self) -> int | None:
        """The line of the first problem, from 1 on."""
        return self.findings[0].line if self.findings else None

    @property
    def column(self) -> int | None:
        """The column of the first problem, from 1 on, in characters."""
        return self.findings[0].column if self.findings else None


class RunError(Error, RuntimeError):
    """A run that did not come to its end, or whose numbers are not to be trusted."""

    result: Result | None = None
    """The rows up to there, if there are any."""


class RunWarning(UserWarning):
    """Something about a run that its user should know."""

    def __init__(self, message: str):
        super().__init__(in_python(message))
