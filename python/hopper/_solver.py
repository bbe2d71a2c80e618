"""The certified solver."""

from __future__ import annotations

import dataclasses

import numpy as np

from . import _arguments, _native
from ._columns import columns
from ._contents import Contents
from ._native import HopperError

#: Most cells of a world.
_CELLS_MAX = 2**26


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class World(Contents):
    """A grid world of hops, its arrays indexed [y, x], row 0 southernmost. One number stands for an array full of it.

    Attributes:
        payoff: Payoff of landing on a cell.
        goal: Cells where the process ends.
        lost: Cells where the hopper is lost.
        slope_east: Slope towards the east in slope limits, clamped to [-1, 1].
        slope_north: Slope towards the north in slope limits, clamped to [-1, 1].
        soil: Index of each cell's soil in `soils`.
        soils: (intended, stuck, sideways, wait) of each soil, 1 to 6 of them: intended + stuck + 2 sideways = 1; `wait` is the
            share of hops that take a second period.
        discount: Discount of one period, in [0, 1).
        loss: What being lost is worth, in units of payoff.
        leaving: Leaving the grid: "stays" or "loses".
    """

    payoff: np.ndarray
    goal: np.ndarray
    lost: np.ndarray
    slope_east: np.ndarray = 0.0
    slope_north: np.ndarray = 0.0
    soil: np.ndarray = 0
    soils: tuple = ((0.9, 0.0, 0.05, 0.0),)
    discount: float = 0.99
    loss: float = 0.0
    leaving: str = "stays"


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Solution(Contents):
    """Certified values of a world. Unpacks as `values, policy, bound`.

    Attributes:
        values: Value of each cell.
        policy: Best hop of each cell as a code of `Action`; HOLD where there is none to choose.
        bound: Proven bound on the error of the values.
        is_solved: Whether `bound` is within the error that was asked for. It is not where the sweeps ended first, or where that
            error is below what floating point can prove.
        sweeps: Work done.
    """

    values: np.ndarray
    policy: np.ndarray
    bound: float
    is_solved: bool
    sweeps: int

    def __iter__(self):
        return iter((self.values, self.policy, self.bound))


def solve(world, *, error_max=1e-6, sweeps_max=None):
    """Solves a `World` from nothing, to an error of `error_max` in units of payoff or within `sweeps_max` sweeps.

    Numbers that the world cannot have are refused, by name. Ctrl-C interrupts.
    """
    if not isinstance(world, World):
        raise HopperError(f"solve needs a hopper.World, got {_arguments.told(world)}")
    error_max = _arguments.number("error_max", error_max, least=0)
    if sweeps_max is not None:
        sweeps_max = _arguments.integer("sweeps_max", sweeps_max, 0, 2**64 - 1)
    shape = _arguments.numbers("payoff", world.payoff).shape
    if len(shape) != 2:
        raise HopperError(f"a payoff needs 2 dimensions, got {len(shape)}")
    if not 1 <= shape[0] * shape[1] <= _CELLS_MAX:
        raise HopperError(f"a world needs 1 to {_CELLS_MAX} cells, got shape {shape}")
    kinds = {"payoff": "f8", "slope_east": "f8", "slope_north": "f8", "soil": "u1", "goal": "?", "lost": "?"}
    arrays = {name: _arguments.array(name, getattr(world, name), shape, kind) for name, kind in kinds.items()}
    native = _World(
        shape=shape, soils=_soils(world.soils), discount=_arguments.number("discount", world.discount),
        loss=_arguments.number("loss", world.loss), leaving=_leaving(world.leaving), **arrays,
    )
    table, bound, is_solved, sweeps = _native.solve(native, error_max, sweeps_max)
    table = columns(table)
    return Solution(table["values"].reshape(shape), table["policy"].reshape(shape), bound, is_solved, sweeps)


def _leaving(leaving):
    if leaving is None:
        raise HopperError('leaving needs to be "stays" or "loses", got None')
    return _arguments.text("leaving", leaving)


def _soils(soils):
    try:
        soils = [tuple(_arguments.number("a soil's share", share) for share in soil) for soil in soils]
    except TypeError:
        raise HopperError(f"soils need to be (intended, stuck, sideways, wait) of each, got {_arguments.told(soils)}") from None
    for soil in soils:
        if len(soil) != 4:
            raise HopperError(f"a soil needs (intended, stuck, sideways, wait), got {_arguments.told(soil)}")
    return soils


@dataclasses.dataclass(frozen=True)
class _World:
    shape: tuple
    payoff: np.ndarray
    slope_east: np.ndarray
    slope_north: np.ndarray
    soil: np.ndarray
    goal: np.ndarray
    lost: np.ndarray
    soils: list
    discount: float
    loss: float
    leaving: str
