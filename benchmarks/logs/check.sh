#!/bin/sh
# Decodes a run's logs with other people's readers. Usage: check.sh LOG.mcap... (or the folder of a run)
set -eu
here=$(cd "$(dirname "$0")" && pwd)
if [ "$#" -eq 0 ]; then
    echo "usage: $0 LOG.mcap... | RUN" >&2
    exit 2
fi
if [ ! -x "$here/.venv/bin/python" ]; then
    python3 -m venv "$here/.venv"
fi
"$here/.venv/bin/python" -m pip install --quiet --disable-pip-version-check -r "$here/requirements.txt"
exec "$here/.venv/bin/python" "$here/check.py" "$@"
