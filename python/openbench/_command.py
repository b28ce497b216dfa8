"""The command `openbench`."""

import os
import signal
import sys

from openbench._openbench import main as run


def main() -> None:
    """Runs the command line and exits."""
    # Agents in Python run in the interpreter that has this package.
    os.environ.setdefault("OPENBENCH_PYTHON", sys.executable)
    # Python only notes an interrupt, and would wait for the command to return.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run(["openbench", *sys.argv[1:]]))
