#!/usr/bin/env python3
"""Whether other people's tools can read the log of an episode.

    pip install mcap mcap-ros2-support rosbags
    python3 viewers/check.py runs/latest/episodes/000.mcap

Every message is decoded twice: by `mcap` with the definitions in the log, and by `rosbags` with
those of ROS 2 Humble, which must be the same. The frames must form one tree with the root `map`,
and every frame that a message names must be in it.
"""

import collections
import pathlib
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

EXPECTED = {
    "/tf", "/tf_static", "/clock", "/cmd_vel", "/robot_description", "/camera/camera_info",
    "/map/markers", "/ground_truth/doors", "/ground_truth/odom", "/livox/lidar", "/costmap",
}


def by_mcap(path):
    """Messages by topic, and the parents and the uses of frames."""
    counts, parents, used = collections.Counter(), {}, set()
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            counts[channel.topic] += 1
            for transform in getattr(message, "transforms", []):
                parents[transform.child_frame_id] = transform.header.frame_id
            for part in [message, *getattr(message, "markers", [])]:
                if hasattr(part, "header"):
                    used.add(part.header.frame_id)
    return counts, parents, used


def by_rosbags(path):
    """Messages by topic."""
    counts, types = collections.Counter(), get_typestore(Stores.ROS2_HUMBLE)
    with AnyReader([pathlib.Path(path)], default_typestore=types) as reader:
        for connection, _, raw in reader.messages():
            types.deserialize_cdr(raw, connection.msgtype)
            counts[connection.topic] += 1
    return counts


def root_of(frame, parents):
    seen = set()
    while frame in parents and frame not in seen:
        seen.add(frame)
        frame = parents[frame]
    return frame


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    counts, parents, used = by_mcap(sys.argv[1])
    problems = [f"there is no {topic}" for topic in sorted(EXPECTED - set(counts))]
    if by_rosbags(sys.argv[1]) != counts:
        problems.append("rosbags reads other messages than mcap")
    for frame in sorted(used | set(parents)):
        if root_of(frame, parents) != "map":
            problems.append(f"nothing says where the frame {frame} is")
    for topic, count in sorted(counts.items()):
        print(f"{count:7} {topic}")
    print("\n".join(problems) or "all messages can be read, and all frames have a place")
    sys.exit(1 if problems else 0)


main()
