"""Round trips to a policy in Python over pipes: pipe.py [OUT.json]

Plays the benchmark to the child process of `--agent python:FILE:CLASS`, with a policy that takes no
time. Prints the time from `act` to `action`, packing and unpacking included, for policies that read
no sensor, the LiDAR or the camera. It needs the packages openbench and msgpack.
"""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, BinaryIO

import msgpack
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BINARY = ROOT / "target" / "release" / "openbench"
QUESTIONS = 2000
POINTS = 20_000
POLICIES = """
from openbench import Drive


class Blind:
    def begin(self, briefing):
        pass

    def act(self, observation):
        return Drive(0.1, 0.5)


class Lidar(Blind):
    def act(self, observation):
        assert len(observation.scan.points) == 20_000
        return Drive(0.1, 0.5)


class Camera(Blind):
    def act(self, observation):
        assert observation.image.shape == (480, 640, 3)
        return Drive(0.1, 0.5)
"""
SENSORS = {
    "want_scan": {
        "scan": {
            "stamp": 0,
            "xyz": np.ones((POINTS, 3), "<f4").tobytes(),
            "offset_ns": np.arange(POINTS, dtype="<u4").tobytes(),
            "reflectivity": bytes(POINTS),
            "line": bytes(POINTS),
        }
    },
    "want_image": {
        "image": {"stamp": 0, "width": 640, "height": 480, "rgb": bytes(640 * 480 * 3)}
    },
}


class Child:
    """A policy in a process of its own."""

    def __init__(self, file: Path, name: str) -> None:
        words = [sys.executable, "-m", "openbench._child", str(file), name]
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        assert self.process.stdin and self.process.stdout
        self.input, self.output = self.process.stdin, self.process.stdout
        assert "hello" in self.receive()

    def ask(self, message: bytes) -> Any:
        send(self.input, message)
        return self.receive()

    def receive(self) -> Any:
        return msgpack.unpackb(receive(self.output))

    def close(self) -> None:
        self.input.close()
        self.process.wait()


def act(step: int) -> dict[str, Any]:
    """What is sensed in 50 ms."""
    stamps = [50_000_000 * step + 10_000_000 * i for i in range(5)]
    imu = [{"stamp": t, "gyro": [0.0, 0.0, 0.5], "accel": [0.0, 0.0, 9.8]} for t in stamps]
    wheels = [{"stamp": t, "left": 0.1 * step, "right": 0.1 * step} for t in stamps]
    time_ns = 50_000_000 * (step + 1)
    content = {"time": time_ns, "imu": imu, "wheels": wheels, "gnss": None, "has_scan": True}
    return {"act": content}


def begin(folder: Path) -> bytes:
    """The message with which the benchmark begins an episode."""
    kept = folder / "begin"
    agent = f"program:{sys.executable} {__file__} --keep {kept}"
    words = [str(BINARY), "run", "small", "--agent", agent, "--out", str(folder / "run")]
    subprocess.run(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return kept.read_bytes()


def keep(file: Path) -> None:
    """A policy that writes the message `begin` into a file, and refuses."""
    send(sys.stdout.buffer, msgpack.packb({"hello": {"protocol": 1, "program": "keeper"}}))
    while True:
        content = receive(sys.stdin.buffer)
        if not content:
            return
        if "begin" in msgpack.unpackb(content):
            file.write_bytes(content)
        refusal = {"address": None, "cause": "briefing", "detail": "kept"}
        send(sys.stdout.buffer, msgpack.packb({"refuse": refusal}))


def send(stream: BinaryIO, content: bytes) -> None:
    stream.write(struct.pack("<I", len(content)) + content)
    stream.flush()


def receive(stream: BinaryIO) -> bytes:
    head = stream.read(4)
    return stream.read(struct.unpack("<I", head)[0]) if head else b""


def round_trips(file: Path, name: str, briefing: bytes) -> list[float]:
    """Milliseconds of each question."""
    child = Child(file, name)
    answer = child.ask(briefing)
    assert "ready" in answer, answer
    times = []
    for step in range(QUESTIONS):
        question = act(step)
        began = time.perf_counter()
        answer = child.ask(msgpack.packb(question))
        while isinstance(answer, str):
            answer = child.ask(msgpack.packb(SENSORS[answer]))
        times.append(1e3 * (time.perf_counter() - began))
        assert answer["action"]["action"] == {"drive": {"linear": 0.1, "angular": 0.5}}, answer
    child.close()
    return times


def main() -> None:
    rows = []
    print(f"{'reads':8} {'p50 ms':>8} {'p95 ms':>8} {'n':>7}")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "policies.py"
        file.write_text(POLICIES)
        briefing = begin(Path(folder))
        for name in ("Blind", "Lidar", "Camera"):
            times = round_trips(file, name, briefing)
            median, late = np.percentile(times, [50, 95])
            figures = {"ms_p50": round(median, 3), "ms_p95": round(late, 3), "n": len(times)}
            rows.append({"reads": name.lower(), **figures})
            print(f"{name.lower():8} {median:8.3f} {late:8.3f} {len(times):7}")
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--keep", file]:
            keep(Path(file))
        case _:
            main()
