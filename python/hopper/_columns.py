"""Tables as columns: arrays over the bytes that the native half returns."""

import numpy as np


def columns(table):
    """A dictionary of arrays by the columns' names."""
    return {name: np.frombuffer(data, dtype=kind) for name, (kind, data) in table.items()}
