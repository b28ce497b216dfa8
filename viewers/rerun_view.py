#!/usr/bin/env python3
"""Opens the log of an episode in Rerun, or saves it as a recording with its blueprint.

    pip install rerun-sdk==0.41.0 mcap mcap-ros2-support
    python3 viewers/rerun_view.py runs/latest/episodes/000.mcap
    python3 viewers/rerun_view.py runs/latest/episodes/000.mcap --save delivery.rrd

Rerun reads transforms, clouds, images, the costmap and the robot's form from the log by itself. It
does not draw paths and markers, so this script adds them.
"""

import argparse

import rerun as rr
import rerun.blueprint as rrb
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

PATHS = {
    "/route": [120, 120, 200],
    "/path": [40, 130, 240],
    "/waypoints": [170, 90, 200],
}
MARKERS = ["/map/markers", "/ground_truth/doors", "/found", "/facades"]
# Of visualization_msgs/Marker.
CUBE, SPHERE, LINE_LIST, TEXT = 1, 2, 5, 9


def blueprint():
    world = rrb.Spatial3DView(
        name="world",
        origin="/",
        spatial_information=rrb.SpatialInformation(target_frame="map"),
        # The matrix of the camera would draw each image twice.
        contents=["$origin/**", "- /camera/image/**"],
    )
    image = rrb.Spatial2DView(name="plates", origin="/camera/image/compressed")
    words = rrb.Tabs(
        rrb.TextDocumentView(name="plan", origin="/plan"),
        rrb.TextDocumentView(name="task", origin="/task"),
        rrb.TextDocumentView(name="plate", origin="/plate"),
        rrb.TextDocumentView(name="note", origin="/note"),
    )
    side = rrb.Vertical(image, words)
    return rrb.Blueprint(
        rrb.Horizontal(world, side, column_shares=[2, 1]),
        rrb.TimePanel(timeline="message_log_time", state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
    )


def messages(path, topics):
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, raw, message in reader.iter_decoded_messages(topics=topics):
            yield channel.topic, raw.log_time, message


def at(nanoseconds):
    """The instants that Rerun gives to the messages of the log."""
    rr.set_time("message_log_time", timestamp=nanoseconds * 1e-9)


def draw(name, frame, drawn):
    # Static, so that the entity has a frame before it has a shape.
    rr.log(name, rr.CoordinateFrame(frame), static=True)
    rr.log(name, drawn)


def log_path(topic, message):
    line = [[p.pose.position.x, p.pose.position.y, 0.08] for p in message.poses]
    # Away from the raw messages, which have the topics' own names.
    strip = rr.LineStrips3D([line], colors=PATHS[topic], radii=0.05)
    draw(f"drawn{topic}", message.header.frame_id, strip)


def log_markers(topic, message):
    for marker in message.markers:
        color = [int(255 * c) for c in (marker.color.r, marker.color.g, marker.color.b)]
        drawn = shape(marker, color)
        if drawn is not None:
            name = f"drawn{topic}/{marker.ns}/{marker.id}"
            draw(name, marker.header.frame_id, drawn)


def shape(marker, color):
    p = marker.pose.position
    if marker.type == LINE_LIST:
        ends = [[q.x, q.y, q.z] for q in marker.points]
        pairs = [ends[i : i + 2] for i in range(0, len(ends), 2)]
        return rr.LineStrips3D(pairs, colors=color, radii=marker.scale.x / 2)
    if marker.type == TEXT:
        return rr.Points3D([[p.x, p.y, p.z]], colors=color, radii=0.05, labels=[marker.text])
    if marker.type in (CUBE, SPHERE):
        return rr.Points3D([[p.x, p.y, p.z]], colors=color, radii=marker.scale.x / 2)
    return None


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("log", help="an MCAP file of OpenBench")
    parser.add_argument("--save", metavar="FILE.rrd", help="save instead of opening a window")
    args = parser.parse_args()
    rr.init("openbench", spawn=args.save is None)
    if args.save is not None:
        rr.save(args.save, default_blueprint=blueprint())
    else:
        rr.send_blueprint(blueprint())
    rr.log_file_from_path(args.log)
    for topic, time, message in messages(args.log, list(PATHS) + MARKERS):
        at(time)
        (log_path if topic in PATHS else log_markers)(topic, message)


main()
