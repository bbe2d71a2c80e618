"""Reads a bag of ROS 2 with rosbags, and its file with mcap-ros2-support; prints what both found as one JSON object.

Both decode every message by the definitions in the bag, and have to find the same.
"""

import array
import dataclasses
import json
import math
import sys
from pathlib import Path

import numpy
from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

# The definitions of two releases of ROS; grid_map_msgs is in neither, so that comes from the bag.
STORES = [Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY]


def plain(value):
    """The value in what JSON has; no number becomes null."""
    if isinstance(value, (numpy.ndarray, array.array)):
        # Only no number is unlike itself.
        return [item if item == item else None for item in value.tolist()]
    if isinstance(value, (list, tuple, bytes, bytearray, memoryview)):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if dataclasses.is_dataclass(value):
        names = [field.name for field in dataclasses.fields(value) if not field.name.startswith("__")]
    elif isinstance(value, (int, str)):
        return value
    else:
        names = [name for name in (getattr(value, "__slots__", None) or vars(value)) if not name.startswith("_")]
    # rosbags has the constants of a definition among its fields.
    return {name: plain(getattr(value, name)) for name in names if not name.isupper()}


def by_rosbags(folder):
    """By the first release; the first message of each topic by the others too, which has to be the same."""
    found, last = {}, 0
    stores = [get_typestore(store) for store in STORES[1:]]
    with AnyReader([folder], default_typestore=get_typestore(STORES[0])) as reader:
        for connection, logged, data in reader.messages():
            assert logged >= last, f"{connection.topic} goes back in time"
            last = logged
            message = plain(reader.deserialize(data, connection.msgtype))
            for store in stores if connection.topic not in found else []:
                if connection.msgtype in store.types:
                    assert plain(store.deserialize_cdr(data, connection.msgtype)) == message, connection
            found.setdefault(connection.topic, []).append([logged, message])
    return found


def main(folder):
    folder = Path(folder)
    [file] = folder.glob("*.mcap")
    found = by_rosbags(folder)
    others = {}
    for message in read_ros2_messages(str(file)):
        at = message.log_time_ns, plain(message.ros_msg)
        others.setdefault(message.channel.topic, []).append(list(at))
    assert others.keys() == found.keys(), (others.keys(), found.keys())
    for topic, messages in found.items():
        assert others[topic] == messages, topic
    topics = {}
    with Reader(folder) as reader:
        for connection in reader.connections:
            assert connection.msgcount == len(found[connection.topic]), connection
            [qos] = connection.ext.offered_qos_profiles
            qos = [qos.history.value, qos.depth, qos.reliability.value, qos.durability.value]
            topics[connection.topic] = {"type": connection.msgtype, "qos": qos}
        assert reader.message_count == sum(len(messages) for messages in found.values())
        first = min(messages[0][0] for messages in found.values())
        last = max(messages[-1][0] for messages in found.values())
        assert (reader.start_time, reader.end_time) == (first, last + 1)
    with open(file, "rb") as stream:
        reader = make_reader(stream)
        profile = reader.get_header().profile
        notes = {record.name: record.metadata for record in reader.iter_metadata()}
    print(json.dumps({"profile": profile, "topics": topics, "notes": notes, "messages": found}))


main(sys.argv[1])
