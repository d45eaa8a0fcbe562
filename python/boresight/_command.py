"""The command ``boresight``, as installed with the package."""

from __future__ import annotations

import signal
import sys

from . import _core


def main() -> int:
    """Runs the command line on the arguments of the process; its exit code."""
    # Python's own handler would only take a note of Ctrl-C and wait for the command to end
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _core.cli(["boresight", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
