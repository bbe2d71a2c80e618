"""Reads the journal and the recording of a mission; prints what tests/python.rs compares."""

import json
import sys

import numpy as np

import hopper

journal = hopper.read_journal(sys.argv[1])
told = {
    "digest": journal.digest,
    "decisions": len(journal.rows["decision"]),
    "actions": journal.rows["action"].tolist(),
    "planning_us": float(np.median(journal.rows["planning_ns"])) / 1e3,
}
assert journal.brief["robots"][0]["goal"] and "[truth" in journal.scenario and journal.seed > 0
if len(sys.argv) > 2:
    recording = hopper.read_recording(sys.argv[2])
    assert recording.is_whole and recording.lost_bytes == 0 and recording.metadata
    last = recording.states["decision"].argmax()
    route = journal.route
    assert (recording.states["x"][last], recording.states["y"][last]) == (route["x"][-1], route["y"][-1])
    told["commands"] = sorted(set(recording.commands["decision"].tolist()))
    assert sum(recording.messages.values()) > 0
print(json.dumps(told))
