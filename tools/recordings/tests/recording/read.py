"""Reads a recording with the mcap package of PyPI, and prints what it found as one JSON object."""

import json
import struct
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def main(path):
    topics, decisions, digest, cells = {}, [], None, None
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        statistics = reader.get_summary().statistics
        for _, channel, _, message in reader.iter_decoded_messages(log_time_order=False):
            topics[channel.topic] = topics.get(channel.topic, 0) + 1
            if channel.topic == "hop/past":
                decisions += [record.decision for record in message.records]
            if channel.topic == "hop/state":
                digest = message.digest.hex()
            if channel.topic == "view/map":
                points = range(0, len(message.data), message.point_stride)
                heights = [struct.unpack_from("<f", message.data, at + 8)[0] for at in points]
                finite = sum(height == height for height in heights)
                cells = {"bytes": len(message.data), "seen": len(heights), "finite": finite}
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    print(json.dumps({
        "messages": statistics.message_count,
        "topics": topics,
        "decisions": decisions,
        "digest": digest,
        "cells": cells,
        "metadata": metadata,
    }))


main(sys.argv[1])
