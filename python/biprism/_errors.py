"""Errors as a person mends them."""

from __future__ import annotations

from typing import Any


class SceneError(ValueError):
    """A scene, a file or a value that cannot be: where, which rule it breaks, and the next step.

    ``str(error)`` is the whole message, with the line at fault where there is one.
    """

    path: str
    """Where: a file, or what the scene is called; of a replaced value also its key."""
    line: int | None
    """The line at fault, from 1, where a text has one."""
    column: int | None
    """The character of that line, from 1."""
    key: str | None
    """The key at fault, as ``board.square_mm``."""
    rule: str
    """What was found and which rule it breaks, in one sentence."""
    help: str
    """What to do next, in one sentence."""

    def __init__(
        self,
        path: str,
        line: int | None,
        column: int | None,
        key: str | None,
        rule: str,
        help: str,
        message: str | None = None,
    ) -> None:
        super().__init__(f"{path}: {rule}; {help}" if message is None else message)
        self.path, self.line, self.column, self.key, self.rule, self.help = path, line, column, key, rule, help

    def __reduce__(self) -> tuple[Any, ...]:
        fields = (self.path, self.line, self.column, self.key, self.rule, self.help)
        return type(self), (*fields, str(self))
