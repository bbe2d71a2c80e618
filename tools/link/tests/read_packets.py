"""Prints what packets say, as libraries of others read them: `read_packets.py XTCE STREAM`, a JSON list.

Values are read by space-packet-parser from the XTCE, headers and checksums by spacepackets.
"""

import json
import struct
import sys

from space_packet_parser.generators import ccsds_generator
from space_packet_parser.xtce.definitions import XtcePacketDefinition
from spacepackets.ecss.tm import PusTm

TIME_BYTES = 6


def plain(value):
    """A value as it stands in JSON: bytes in hexadecimal, floats by their bits, codes by their number."""
    raw = value.raw_value
    if isinstance(value, bytes):
        return bytes(value).hex()
    if isinstance(value, float):
        return struct.pack(">d", value).hex()
    if isinstance(value, str) and isinstance(raw, int):
        return int(raw)
    if isinstance(value, str):
        return str(value)
    return int(raw)


def main():
    definition = XtcePacketDefinition.from_xtce(sys.argv[1])
    containers = {}
    for name in definition.containers:
        for comparison in definition.containers[name].restriction_criteria or []:
            containers[int(comparison.required_value)] = name
    told = []
    with open(sys.argv[2], "rb") as stream:
        for raw in ccsds_generator(stream):
            # The checksum is verified here.
            header = PusTm.unpack(bytes(raw), timestamp_len=TIME_BYTES)
            packet = definition.parse_bytes(raw)
            told.append(
                {
                    "container": containers[header.apid],
                    "apid": header.apid,
                    "sequence": header.seq_count,
                    "service": [header.service, header.subservice],
                    "time": int.from_bytes(header.pus_tm_sec_header.timestamp, "big"),
                    "values": {name: plain(value) for name, value in packet.items() if not name.isupper()},
                }
            )
            assert packet["PKT_APID"] == header.apid
            assert packet["MISSION_TIME"].raw_value == told[-1]["time"]
    json.dump(told, sys.stdout)


if __name__ == "__main__":
    main()
