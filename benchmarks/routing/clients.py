"""Asks our server by routingpy, as anybody would ask OSRM, and keeps a route with steps.

Usage: clients.py URL LON,LAT LON,LAT OUT.json
"""

import sys
import time
import urllib.error
import urllib.request

import routingpy


def wait_for(url):
    for _ in range(300):
        try:
            return urllib.request.urlopen(url).read()
        except urllib.error.HTTPError as error:
            return error.read()
        except OSError:
            time.sleep(0.1)
    sys.exit(f"nobody answers at {url}")


def main():
    url, *places, out = sys.argv[1:]
    places = [[float(number) for number in place.split(",")] for place in places]
    wait_for(url)
    client = routingpy.OSRM(base_url=url)
    route = client.directions(locations=places, profile="foot")
    table = client.matrix(locations=places, profile="foot")
    assert len(route.geometry) > 1 and route.distance > 0 and table.durations[0][1] > 0
    print(f"routingpy: {route.distance} m in {route.duration} s, {len(route.geometry)} points; table {table.durations}")
    ends = ";".join(",".join(map(str, place)) for place in places)
    with open(out, "wb") as file:
        file.write(wait_for(f"{url}/route/v1/foot/{ends}?steps=true&overview=full&geometries=geojson"))


if __name__ == "__main__":
    main()
