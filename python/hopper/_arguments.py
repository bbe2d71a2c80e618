"""Arguments of the package's functions: each is what was asked for, or an error that names it."""

from __future__ import annotations

import math
import operator
import os
import sys
import warnings

import numpy as np

from . import _native
from ._native import HopperError

#: Seeds are below it.
SEEDS = 2**64


def told(value):
    """A value with its type, in a few words."""
    try:
        text = repr(value)
    except Exception:
        text = "?"
    return f"{text[:80]} of type {type(value).__name__}"


def integer(name, value, least, most):
    """A whole number from `least` to `most`; neither a float nor a bool is one."""
    try:
        if isinstance(value, (bool, np.bool_)):
            raise TypeError
        number = operator.index(value)
    except (TypeError, ValueError):
        raise HopperError(f"{name} needs to be a whole number, got {told(value)}") from None
    if not least <= number <= most:
        raise HopperError(f"{name} needs to be a whole number from {least} to {most}, got {told(number)}")
    return number


def seed(value):
    """The seed of a mission."""
    return integer("a seed", value, 0, SEEDS - 1)


def number(name, value, *, least=-math.inf):
    """A finite number, not below `least`."""
    try:
        if isinstance(value, (str, bytes, bool, np.bool_)) or np.ndim(value) != 0:
            raise TypeError
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise HopperError(f"{name} needs to be a number, got {told(value)}") from None
    if not math.isfinite(number) or number < least:
        need = "a finite number" if least == -math.inf else f"a finite number, at least {least}"
        raise HopperError(f"{name} needs to be {need}, got {number}")
    return number


def path(name, value):
    """A path as text; None stays None."""
    if value is None:
        return None
    try:
        text = os.fsdecode(value)
    except TypeError:
        raise HopperError(f"{name} needs to be a path, got {told(value)}") from None
    if "\0" in text:
        raise HopperError(f"{name} needs to be a path, got {told(value)}")
    return text


def text(name, value):
    """Text of whole characters; None stays None."""
    if value is None:
        return None
    try:
        str.encode(value)
    except (TypeError, UnicodeError):
        raise HopperError(f"{name} needs to be text, got {told(value)}") from None
    return str(value)


def mission(scenario, profile, dem, nodata):
    """The scenario that is asked for, read and checked. It warns of what is probably not as intended."""
    if scenario is not None:
        scenario = text("a scenario", path("a scenario", scenario))
    resolved = _native.Resolved(scenario, text("a profile", profile), path("dem", dem), _nodata(nodata))
    for warning in resolved.warnings:
        warn(warning)
    return resolved


def _nodata(value):
    """Stored values that are nodata; None if that is not settled."""
    if value is None:
        return None
    try:
        several = [value] if np.ndim(value) == 0 else list(value)
    except Exception:
        raise HopperError(f"nodata needs to be a number, or several, got {told(value)}") from None
    return [number("nodata", one) for one in several]


#: Packages whose lines are not the user's.
_BETWEEN = ("hopper", "gymnasium", "pettingzoo")


def warn(message):
    """Warns at the line of the user that led here."""
    frame, level = sys._getframe(1), 2
    while frame.f_back is not None and str(frame.f_globals.get("__name__")).partition(".")[0] in _BETWEEN:
        frame, level = frame.f_back, level + 1
    warnings.warn(message, UserWarning, stacklevel=level)


def options(value, *known):
    """What `reset` is given beside a seed, a dictionary of the options that are `known`."""
    given = {} if value is None else value
    if not isinstance(given, dict):
        raise HopperError(f"options need to be a dictionary, got {told(value)}")
    strange = [name for name in given if not isinstance(name, str) or name not in known]
    if strange:
        but = f" but {', '.join(known)}" if known else ""
        raise HopperError(f"reset takes no option{but}, got {told(strange[0])}")
    return given


def array(name, value, shape, kind):
    """A contiguous array of that shape: `kind` "f8" takes numbers, "u1" whole numbers from 0 to 255, "?" bools or 0 and 1."""
    values = numbers(name, value)
    try:
        values = np.broadcast_to(values, shape)
    except ValueError:
        raise HopperError(f"{name} needs shape {shape}, got {values.shape}") from None
    if kind != "f8" and values.dtype.kind != "b":
        need, most = ("bools, or 0 and 1", 1) if kind == "?" else ("whole numbers from 0 to 255", 255)
        # What is no number compares as false.
        wrong = ~((values >= 0) & (values <= most) & (values == np.floor(values)))
        if wrong.any():
            raise HopperError(f"{name} needs {need}, got {values[wrong][0]}")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(values, dtype="f8" if kind == "f8" else "u1")


def numbers(name, value):
    """An array of real numbers, none of them masked."""
    if np.ma.is_masked(value):
        raise HopperError(f"{name} needs a number in each cell, got masked ones")
    try:
        values = np.asarray(value)
    except Exception as error:
        raise HopperError(f"{name} needs to be an array of numbers: {error}") from None
    if values.dtype == object:
        # Python's whole numbers beyond 64 bits, and whatever is no number.
        try:
            values = np.array([float(cell) for cell in values.ravel()]).reshape(values.shape)
        except (TypeError, ValueError, OverflowError):
            raise HopperError(f"{name} needs to be an array of numbers, got {told(value)}") from None
    if values.dtype.kind not in "biuf":
        raise HopperError(f"{name} needs to be an array of real numbers, got {values.dtype}")
    return values
