"""Journals and recordings."""

from __future__ import annotations

import dataclasses
import json

from . import _arguments, _native
from ._columns import columns
from ._contents import Contents
from ._native import HopperError


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Journal(Contents):
    """A journal of decisions.

    Attributes:
        seed: The seed of the mission.
        digest: The digest after the last decision.
        brief: The brief, every field of it, a dictionary.
        scenario: The resolved scenario as TOML.
        rows: Columns of one row for each decision, as in `Flight`.
        route: Columns x, y, robot, as in `Flight`.
    """

    seed: int
    digest: str
    brief: dict
    scenario: str
    rows: dict
    route: dict

    def __repr__(self):
        scenario, decisions = self.brief["scenario"], len(self.rows["decision"])
        return f"<Journal of scenario {scenario}, seed {self.seed}: {decisions} decisions, digest {self.digest}>"


def read_journal(path):
    """Reads a journal, or the journal in the output directory of a run."""
    about, scenario, rows, route = _native.read_journal(_path(path))
    about = json.loads(about)
    return Journal(about["seed"], about["digest"], about["brief"], scenario, columns(rows), columns(route))


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Recording(Contents):
    """States and commands of a recording, one row for each message.

    Attributes:
        is_whole: Whether the file is complete.
        lost_bytes: How many bytes after its last whole record are not read.
        undecodable: Number of Hopper's messages that cannot be decoded. They have no row.
        metadata: Metadata records by name.
        messages: Number of messages by topic.
        states: Columns of all states.
        commands: Columns of all commands.
    """

    is_whole: bool
    lost_bytes: int
    undecodable: int
    metadata: dict
    messages: dict
    states: dict
    commands: dict

    def __repr__(self):
        end = "whole" if self.is_whole else f"cut, {self.lost_bytes} bytes lost"
        return f"<Recording of {sum(self.messages.values())} messages on {len(self.messages)} topics, {end}>"


def read_recording(path):
    """Reads an MCAP file of `hopper run --record`, up to its last whole record. Warns of messages that cannot be decoded."""
    about, tables = _native.read_recording(_path(path))
    about = json.loads(about)
    states, commands = columns(tables["state"]), columns(tables["command"])
    if about["undecodable"]:
        _arguments.warn(f"{path}: {about['damage']}")
    return Recording(
        about["whole"], about["lost_bytes"], about["undecodable"], about["metadata"], about["messages"], states, commands
    )


def _path(path):
    if path is None:
        raise HopperError("a path needs to be named, got None")
    return _arguments.path("a path", path)
