"""What a long call says of itself."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple, TextIO


class Progress(NamedTuple):
    """How far a call is."""

    step: str
    """What is being done."""
    done: int
    """How much of it is done; 0 where nobody counts."""
    of: int
    """Of how much; 0 where nobody counts."""


ProgressCallback = Callable[[Progress], object]
"""Called on the thread of the call that it was given to; what it raises stops that call and is raised by it."""


def told(progress: ProgressCallback | None) -> Callable[[str, int, int], None] | None:
    """The callback as the extension module calls it."""
    if progress is None:
        return None
    say = progress

    def tell(step: str, done: int, of: int) -> None:
        say(Progress(step, done, of))

    return tell


def bar(file: TextIO | None = None, width: int = 30) -> ProgressCallback:
    """A progress callback that keeps one line on a terminal or below a notebook's cell.

    >>> import io
    >>> out = io.StringIO()
    >>> show = bar(out, width=4)
    >>> show(Progress("trials", 1, 2))
    >>> print(out.getvalue().strip())
    [##..] 1 of 2 trials
    """
    last = 0

    def show(progress: Progress) -> None:
        nonlocal last
        out = sys.stderr if file is None else file
        if progress.of:
            full = width * progress.done // progress.of
            line = f"[{'#' * full}{'.' * (width - full)}] {progress.done} of {progress.of} {progress.step}"
        else:
            line = progress.step
        end = "\n" if progress.of and progress.done == progress.of else ""
        out.write("\r" + line.ljust(last) + end)
        out.flush()
        last = 0 if end else len(line)

    return show
