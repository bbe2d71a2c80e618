"""What classes of arrays have in common: they are compared by what they hold, and shown in a line."""

import dataclasses

import numpy as np


class Contents:
    """Dataclasses that hold arrays. They are equal if their fields are, cell by cell; NaN is equal to NaN."""

    def __eq__(self, other):
        if type(other) is not type(self):
            return NotImplemented
        return all(_equal(getattr(self, name), getattr(other, name)) for name in _compared(self))

    # What is compared by its contents, which may change, has no hash.
    __hash__ = None

    def __repr__(self):
        fields = ", ".join(f"{name}={_shown(getattr(self, name))}" for name in _compared(self))
        return f"{type(self).__name__}({fields})"


def _compared(record):
    return [field.name for field in dataclasses.fields(record) if field.compare]


def _equal(one, other):
    if one is other:
        return True
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_equal(one[name], other[name]) for name in one)
    try:
        one, other = np.asarray(one), np.asarray(other)
    except ValueError:
        # Lists of lists of different lengths.
        return bool(one == other)
    return one.shape == other.shape and bool(np.all((one == other) | ((one != one) & (other != other))))


def _shown(value):
    """A value in a few characters; an array by its type and shape."""
    if isinstance(value, np.ndarray):
        return f"<{value.dtype} {value.shape}>"
    text = repr(value)
    return text if len(text) <= 60 and "\n" not in text else f"<{type(value).__name__}>"
