"""Decodes every message of MCAP logs with the readers of MCAP and of rosbags, and compares definitions and bytes.

For each log: (1) the `mcap` reader, which checks the file's checksums, decodes every message by the schemas in the file; (2) rosbags,
which has definitions of its own, decodes each message and encodes it again, which must give the same bytes; (3) the
definitions in the file must be those of ROS 2; (4) rosbags opens the file as a recording, and finds as many messages.
"""

import sys
from collections import Counter
from pathlib import Path

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)


def decoded_by_mcap(path):
    """Messages by topic and type, decoded by the schemas in the file."""
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        profile = reader.get_header().profile
        counts = Counter((c.topic, s.name) for s, c, _, _ in reader.iter_decoded_messages())
        total = reader.get_summary().statistics.message_count
    yield from [] if profile == "ros2" else [f"the profile is {profile!r}, not 'ros2'"]
    yield from [] if total == sum(counts.values()) else [f"{total} messages in the statistics, {sum(counts.values())} in the file"]
    for (topic, kind), count in sorted(counts.items()):
        print(f"  {count:7} {topic:28} {kind}")


def encoded_again_by_rosbags(path):
    """Messages whose bytes change when rosbags decodes and encodes them."""
    differing = Counter()
    with open(path, "rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            value = STORE.deserialize_cdr(message.data, schema.name)
            if bytes(STORE.serialize_cdr(value, schema.name)) != message.data:
                differing[channel.topic] += 1
    yield from (f"{count} messages of {topic} change when encoded again" for topic, count in differing.items())


def definitions(path):
    """Types that the file defines otherwise than ROS 2 does."""
    with open(path, "rb") as file:
        schemas = make_reader(file).get_summary().schemas.values()
    for schema in schemas:
        for name, fields in get_types_from_msg(schema.data.decode(), schema.name).items():
            if fields != STORE.fielddefs[name]:
                yield f"{name} is defined otherwise than in ROS 2"


def opened_as_a_recording(path):
    """Whether rosbags opens the file, and finds every message."""
    with open(path, "rb") as file:
        total = make_reader(file).get_summary().statistics.message_count
    with AnyReader([path], default_typestore=STORE) as recording:
        found = sum(1 for c, _, raw in recording.messages() if recording.deserialize(raw, c.msgtype) is not None)
    yield from [] if found == total else [f"rosbags finds {found} of {total} messages"]


def logs_of(argument):
    path = Path(argument)
    return sorted(path.glob("episodes/*.mcap")) if path.is_dir() else [path]


def main(arguments):
    paths = [path for argument in arguments for path in logs_of(argument)]
    if not paths:
        sys.exit("no .mcap in " + ", ".join(arguments))
    problems = 0
    for path in paths:
        print(path)
        for check in (decoded_by_mcap, encoded_again_by_rosbags, definitions, opened_as_a_recording):
            for problem in check(path):
                problems += 1
                print(f"  PROBLEM: {problem}")
    print(f"{len(paths)} logs, {problems} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
