"""Hopper for Python: planners of your own, missions in lockstep, the certified solver, journals and recordings."""

import enum
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ._native import Brief as Brief
from ._native import DecideTimeout as DecideTimeout
from ._native import HopperError as HopperError
from ._native import Map as Map
from ._native import State as State

__version__: str

class Action(enum.IntEnum):
    HOLD = 0
    NORTH = 1
    EAST = 2
    SOUTH = 3
    WEST = 4
    STEP_NORTH = 5
    STEP_EAST = 6
    STEP_SOUTH = 7
    STEP_WEST = 8
    UP_NORTH = 14
    UP_EAST = 15
    UP_SOUTH = 16
    UP_WEST = 17

HOPS: tuple[Action, Action, Action, Action]
STEPS: tuple[Action, Action, Action, Action]
UPS: tuple[Action, Action, Action, Action]

class Planner(Protocol):
    def decide(self, brief: Brief, map: Map, state: State) -> Action: ...

Columns = dict[str, npt.NDArray[Any]]

def fly(
    planner: Planner,
    *,
    instance: str | None = None,
    robot: int | Iterable[int] | None = None,
    takeover: bool = False,
    stay: bool = False,
    wait: float | None = None,
    timeout: float = 5.0,
) -> int: ...

@dataclass(frozen=True, eq=False)
class Flight:
    def __eq__(self, other: object) -> bool: ...
    summary: dict[str, Any]
    rows: Columns
    route: Columns
    map: Columns
    @property
    def digest(self) -> str: ...
    def plot(self, ax: Any = None) -> Any: ...

def run(
    scenario: str | os.PathLike[str] | None = None,
    planner: str | Planner | None = None,
    seed: int = 1,
    *,
    profile: str | None = None,
    dem: str | os.PathLike[str] | None = None,
    nodata: float | Sequence[float] | None = None,
) -> Flight: ...

def check(make: Callable[[], Planner]) -> None: ...

@dataclass(frozen=True, eq=False)
class World:
    def __eq__(self, other: object) -> bool: ...
    payoff: npt.ArrayLike
    goal: npt.ArrayLike
    lost: npt.ArrayLike
    slope_east: npt.ArrayLike = ...
    slope_north: npt.ArrayLike = ...
    soil: npt.ArrayLike = ...
    soils: Sequence[tuple[float, float, float, float]] = ...
    discount: float = ...
    loss: float = ...
    leaving: str = ...

@dataclass(frozen=True, eq=False)
class Solution:
    def __eq__(self, other: object) -> bool: ...
    values: npt.NDArray[np.float64]
    policy: npt.NDArray[np.uint8]
    bound: float
    is_solved: bool
    sweeps: int
    def __iter__(self) -> Iterator[Any]: ...

def solve(world: World, *, error_max: float = 1e-6, sweeps_max: int | None = None) -> Solution: ...

@dataclass(frozen=True, eq=False)
class Journal:
    def __eq__(self, other: object) -> bool: ...
    seed: int
    digest: str
    brief: dict[str, Any]
    scenario: str
    rows: Columns
    route: Columns

def read_journal(path: str | os.PathLike[str]) -> Journal: ...

@dataclass(frozen=True, eq=False)
class Recording:
    def __eq__(self, other: object) -> bool: ...
    is_whole: bool
    lost_bytes: int
    undecodable: int
    metadata: dict[str, dict[str, str]]
    messages: dict[str, int]
    states: Columns
    commands: Columns

def read_recording(path: str | os.PathLike[str]) -> Recording: ...
