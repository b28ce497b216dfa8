"""How long OSRM takes in process for the pairs given as JSON on standard input; prints JSON.

Usage: osrm_speed.py MAP.osrm
"""

import json
import sys
import time

import osrm


def percentiles(call, items):
    """CPU microseconds, each item's fastest of three goes: the median and the 99th percentile."""
    times = []
    for item in items:
        goes = []
        for _ in range(3):
            began = time.process_time_ns()
            call(item)
            goes.append((time.process_time_ns() - began) / 1e3)
        times.append(min(goes))
    times.sort()
    return times[len(times) // 2], times[min(int(len(times) * 0.99), len(times) - 1)]


def main():
    pairs = json.load(sys.stdin)
    engine = osrm.OSRM(
        algorithm="MLD", storage_config=sys.argv[1], use_shared_memory=False, max_locations_distance_table=1000
    )

    def route(pair, **more):
        ends = [(pair[0], pair[1]), (pair[2], pair[3])]
        return engine.Route(osrm.RouteParameters(coordinates=ends, generate_hints=False, **more))

    def nearest(pair):
        return engine.Nearest(osrm.NearestParameters(coordinates=[(pair[0], pair[1])], generate_hints=False))

    def answer(pair):
        try:
            best = route(pair, overview="false")["routes"][0]
        except RuntimeError:
            return None
        return best["distance"], best["duration"]

    first = pairs[:100]
    places = [(pair[0], pair[1]) for pair in first] + [(pair[2], pair[3]) for pair in first]
    indices = list(range(len(first))), list(range(len(first), 2 * len(first)))
    parameters = osrm.TableParameters(
        coordinates=places, sources=indices[0], destinations=indices[1], annotations=["duration"], generate_hints=False
    )
    answers = [answer(pair) for pair in pairs]
    found = [pair for pair, known in zip(pairs, answers) if known]
    result = {"answers": answers}
    result["route_us_p50"], result["route_us_p99"] = percentiles(lambda pair: route(pair, overview="false"), found)
    full = {"overview": "full", "steps": True, "geometries": "geojson"}
    result["steps_us_p50"], result["steps_us_p99"] = percentiles(lambda pair: route(pair, **full), found)
    result["nearest_us_p50"], result["nearest_us_p99"] = percentiles(nearest, pairs)
    table, _ = percentiles(lambda _: engine.Table(parameters), range(3))
    result["table_100_ms"] = table / 1e3
    json.dump(result, sys.stdout)


if __name__ == "__main__":
    main()
