"""Round trips to unmodified policy servers on loopback: round_trip.py [OUT.json]

Starts a server of openpi and one of vla-eval, each with a policy that answers at once. The
benchmark drives an episode with each; openpi's own client asks the same server as often with
images of the same size. Prints the time from question to answer, which both measure around
packing, sending, receiving and unpacking, and compares the answers.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from socket import create_connection, socket
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
BINARY = ROOT / "target" / "release" / "openbench"
#: What both policies answer: a slow circle, without declaring a delivery.
CIRCLE = np.array([[0.1, 0.5, 0.0]] * 2, np.float32)
#: What they answer last: that the parcel is delivered.
DELIVERED = np.array([[0.0, 0.0, 1.0]], np.float32)
QUESTIONS = 500
SUITE = """
name = "round-trips"
goal = "point"

[world.builtin]
name = "small"
seed = 1

[[episodes]]
instruction = "Box to unit 1, building 3."
deliveries = [{ building = "building3", unit = "unit1" }]
"""


class Constant:
    """A policy that takes no time, and delivers after so many questions."""

    def __init__(self) -> None:
        self.asked = 0

    def infer(self, observation: dict[str, Any]) -> dict[str, Any]:
        self.asked += 1
        is_last = self.asked % (QUESTIONS + 1) == 0
        return {"actions": DELIVERED if is_last else CIRCLE}


def serve_openpi(port: int) -> None:
    from openpi_server.websocket_policy_server import WebsocketPolicyServer

    WebsocketPolicyServer(Constant(), host="127.0.0.1", port=port, metadata={}).serve_forever()


def serve_vla_eval(port: int) -> None:
    from vla_eval.model_servers.predict import PredictModelServer
    from vla_eval.model_servers.serve import serve

    policy = Constant()

    class Server(PredictModelServer):
        def predict(self, obs: dict[str, Any], ctx: Any) -> dict[str, Any]:
            return policy.infer(obs)

    serve(Server(), host="127.0.0.1", port=port)


class Running:
    """A server in a process of its own."""

    def __init__(self, kind: str) -> None:
        with socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        words = [sys.executable, __file__, f"--serve-{kind}", str(self.port)]
        self.process = subprocess.Popen(words, stderr=subprocess.DEVNULL)

    def __enter__(self) -> Running:
        until = time.monotonic() + 60
        while True:
            try:
                create_connection(("127.0.0.1", self.port), 1).close()
                return self
            except OSError:
                if time.monotonic() > until:
                    raise
                time.sleep(0.2)

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()


def by_openbench(agent: str, size: str) -> list[float]:
    """Milliseconds of each question of an episode."""
    with tempfile.TemporaryDirectory() as folder:
        suite, out = Path(folder) / "suite.toml", Path(folder) / "run"
        suite.write_text(SUITE)
        words = [str(BINARY), "run", str(suite), "--agent", agent, "--out", str(out)]
        words += ["--set", f"size={size}", "--set", "arrival=policy", "--record", "none"]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        text = (out / "episodes" / "000.models.jsonl").read_text()
    lines = [json.loads(line) for line in text.splitlines()]
    answers = [line for line in lines if "answer" in line["outcome"]][:QUESTIONS]
    assert len(answers) == QUESTIONS
    for line in answers:
        steps = line["outcome"]["answer"]["velocities"]["steps"]
        got = [[s["velocity"]["linear"], s["velocity"]["angular"]] for s in steps]
        assert np.array_equal(np.array(got, np.float32), CIRCLE[:, :2]), got
    return [line["took_us"] / 1e3 for line in answers]


def by_openpi(port: int, shape: tuple[int, int, int]) -> list[float]:
    from openpi_client.websocket_client_policy import WebsocketClientPolicy

    client = WebsocketClientPolicy("127.0.0.1", port)
    observation = {
        "observation/image": np.zeros(shape, np.uint8),
        "observation/state": np.zeros(5, np.float32),
        "observation/goal": np.zeros(2, np.float32),
        "prompt": "drive to the goal",
    }
    times = []
    for _ in range(QUESTIONS + 1):
        # As long as the benchmark simulates and renders between two questions: a server that just
        # answered is faster.
        time.sleep(0.03)
        began = time.perf_counter()
        answer = client.infer(observation)
        times.append(1e3 * (time.perf_counter() - began))
        expected = CIRCLE if len(times) <= QUESTIONS else DELIVERED
        assert np.array_equal(answer["actions"], expected)
    return times[:QUESTIONS]


def main() -> None:
    rows = []

    def row(server: str, client: str, size: str, times: list[float]) -> None:
        median, late = np.percentile(times, [50, 95])
        figures = {"ms_p50": round(median, 3), "ms_p95": round(late, 3), "n": len(times)}
        rows.append({"server": server, "client": client, "images": size, **figures})
        print(f"{server:10} {client:10} {size:8} {median:8.2f} {late:8.2f} {len(times):7}")

    print(f"{'server':10} {'client':10} {'images':8} {'p50 ms':>8} {'p95 ms':>8} {'n':>7}")
    with Running("openpi") as server:
        for size, shape in (("224", (224, 224, 3)), ("camera", (480, 640, 3))):
            ours = by_openbench(f"openpi:ws://127.0.0.1:{server.port}", size)
            row("openpi", "openbench", size, ours)
            row("openpi", "its own", size, by_openpi(server.port, shape))
    with Running("vla-eval") as server:
        for size in ("224", "camera"):
            ours = by_openbench(f"vla-eval:ws://127.0.0.1:{server.port}", size)
            row("vla-eval", "openbench", size, ours)
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--serve-openpi", port]:
            serve_openpi(int(port))
        case ["--serve-vla-eval", port]:
            serve_vla_eval(int(port))
        case _:
            main()
