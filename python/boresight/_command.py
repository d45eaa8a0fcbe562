"""The command ``boresight``, as installed with the package."""

from __future__ import annotations

import sys

from . import _core


def main() -> int:
    """Runs the command line on the arguments of the process; its exit code."""
    return _core.cli(["boresight", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
