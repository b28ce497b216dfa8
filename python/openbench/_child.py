"""An agent in a process of its own: `python -m openbench._child FILE CLASS`."""

from __future__ import annotations

import importlib.util
import os
import sys
import traceback
from collections.abc import Callable
from pathlib import Path

from openbench._openbench import PolicyEnd, __version__
from openbench._serving import serve
from openbench.agent import Agent


def load(file: str, name: str) -> Callable[[], Agent]:
    """The class of that name in a file."""
    path = Path(file).resolve()
    # A file may import what lies beside it.
    sys.path.insert(0, str(path.parent))
    spec = importlib.util.spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    made: Callable[[], Agent] = getattr(module, name)
    return made


def main() -> None:
    end = PolicyEnd.of_standard_streams()
    # What an agent prints would be taken for messages.
    os.dup2(2, 1)
    file, name = sys.argv[1:]
    try:
        make = load(file, name)
    except Exception as error:
        traceback.print_exc()
        end.failed(f"{file}: {error!r}")
        return
    version = ".".join(map(str, sys.version_info[:3]))
    end.hello(f"openbench {__version__} for Python {version}")
    serve(end, make)


if __name__ == "__main__":
    main()
