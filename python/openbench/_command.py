"""The command `openbench`."""

import os
import sys

from openbench._openbench import main as run


def main() -> None:
    """Runs the command line and exits."""
    # Agents in Python run in the interpreter that has this package.
    os.environ.setdefault("OPENBENCH_PYTHON", sys.executable)
    sys.exit(run(["openbench", *sys.argv[1:]]))
