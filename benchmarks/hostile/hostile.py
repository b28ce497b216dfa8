"""Runs the program on hostile inputs and checks how it ends.

    python3 hostile.py target/release/openbench [--only TEXT] [--every N]

For each input: the exit code is 0, 1 or 2; there is no panic, no hang, and no more than 1 GB of
memory; errors are short and repeat nothing, and no secret is shown; no input file is lost or
changed; no temporary file remains. Exit code 1 if anything of that does not hold.
"""

import argparse
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import cases
import town

LONGEST_S = 60.0
MOST_BYTES = 1 << 30
LONGEST_ERROR = 20_000
SECRET = b"hunter2"
# What commands write, by the words on their command lines.
WRITTEN = ("--out", "--memory", "--truth")
# An installation looks the same to all cases.
HIDDEN = ("OPENAI_API_KEY", "OPENBENCH_API_KEY", "OPENBENCH_API_BASE", "OPENBENCH_LOG")


def snapshot(folder):
    """The files of a folder by name; large ones by length alone."""
    files = {}
    for path in sorted(folder.rglob("*")):
        if path.is_symlink() or not path.is_file():
            continue
        size = path.stat().st_size
        content = b"" if size > 100 << 20 else path.read_bytes()
        files[str(path.relative_to(folder))] = (size, hashlib.sha256(content).hexdigest())
    return files


def outputs(words):
    """The names that a command line writes to."""
    pairs = zip(words, words[1:])
    names = {value for key, value in pairs if key in WRITTEN}
    return {os.path.normpath(name) for name in names} | {"new", "runs"}


def run(binary, words, folder):
    """Exit code, output, seconds and peak memory of a command."""
    environment = {k: v for k, v in os.environ.items() if k not in HIDDEN}
    environment["OPENBENCH_API_TIMEOUT"] = "2"
    with tempfile.TemporaryFile() as output:
        began = time.monotonic()
        process = subprocess.Popen(
            [binary, *words],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=output,
            env=environment,
        )
        hung = False
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - began > LONGEST_S and not hung:
                hung = True
                os.kill(process.pid, signal.SIGKILL)
            time.sleep(0.01)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.monotonic() - began
        output.seek(0)
        return process.returncode, output.read(), seconds, usage.ru_maxrss * 1024


def repeated(text):
    """A part of an error that is said twice."""
    line = next((line for line in text.splitlines() if line.startswith("openbench: ")), "")
    parts = [part.strip() for part in line.split(": ") if len(part.strip()) > 12]
    return next((part for part in parts if parts.count(part) > 1), None)


def problems(case, valid, binary):
    """What is wrong with how a case ends."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "files"
        shutil.copytree(valid, folder, symlinks=True)
        for name, content in case.files.items():
            (folder / name).write_bytes(content)
        if case.prepare:
            case.prepare(folder)
        before = snapshot(folder)
        code, output, seconds, memory = run(binary, case.words, folder)
        after = snapshot(folder)
    found = []
    if seconds > LONGEST_S:
        found.append(f"it did not end within {LONGEST_S:.0f} s")
    elif code not in (0, 1, 2):
        found.append(f"exit code {code}")
    text = output.decode("utf-8", "replace")
    if "panicked" in text:
        found.append("a panic")
    if memory > MOST_BYTES:
        found.append(f"{memory / 2**20:.0f} MB of memory")
    if code != 0 and len(output) > LONGEST_ERROR:
        found.append(f"an error of {len(output)} bytes")
    if code != 0 and not output.strip():
        found.append("no word about what is wrong")
    if SECRET in output:
        found.append("a secret is shown")
    again = repeated(text)
    if again:
        found.append(f"said twice: {again[:100]}")
    written = outputs(case.words)
    for name in before:
        kept = before[name] == after.get(name)
        ours = any(name == out or name.startswith(f"{out}/") for out in written)
        # A command that failed must not have replaced its output either.
        if not kept and (not ours or code != 0):
            found.append(f"{name} was {'changed' if name in after else 'lost'}")
    left = [name for name in after if name not in before and ".part" in name]
    found += [f"{name} remains" for name in left]
    return code, seconds, memory, found, text


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", type=Path)
    parser.add_argument("--only", default="", help="cases with this text in their names")
    parser.add_argument("--every", type=int, default=1, help="every so many cases only")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    binary = str(args.binary.resolve())
    with tempfile.TemporaryDirectory() as place:
        valid = Path(place)
        town.write(valid, binary)
        chosen = [case for case in cases.all_cases(valid) if args.only in case.name]
        chosen = chosen[:: args.every]
        codes, bad, worst, slowest = Counter(), 0, (0, ""), (0.0, "")
        with ThreadPoolExecutor(args.jobs) as pool:
            ends = pool.map(lambda case: (case, problems(case, valid, binary)), chosen)
            for case, (code, seconds, memory, found, text) in ends:
                codes[code] += 1
                worst = max(worst, (memory, case.name))
                slowest = max(slowest, (seconds, case.name))
                if found:
                    bad += 1
                    print(f"{case.name}\n  {' '.join(case.words)[:200]}")
                    for problem in found:
                        print(f"  - {problem}")
                    print(f"  said: {text.strip()[:300]}", flush=True)
    print(f"{len(chosen)} inputs: " + ", ".join(f"exit code {c}: {n}" for c, n in sorted(codes.items())))
    print(f"most memory {worst[0] / 2**20:.0f} MB ({worst[1]}), longest {slowest[0]:.1f} s ({slowest[1]})")
    print(f"{bad} ended badly")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
