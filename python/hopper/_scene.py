"""Frames of missions, for `render()`: images of pixels, and a window that shows them."""

import numpy as np

from ._native import HopperError

#: Pixels of a frame's longer side, about.
_SIDE = 384

#: Colours.
UNSEEN, IMPASSABLE, ROUTE, GOAL, START, TREASURE = (
    np.array(colour, "u1") for colour in [(38, 38, 46), (120, 36, 30), (250, 250, 250), (60, 200, 90), (90, 140, 255), (255, 205, 60)]
)

#: Colours of robots, in the order of their numbers.
ROBOTS = np.array([(255, 90, 60), (80, 190, 255), (255, 210, 80), (190, 120, 255), (110, 230, 150), (255, 140, 200)], "u1")


def ground(height, sand, impassable, seen):
    """The colours of all cells, row 0 southernmost."""
    known = seen > 0
    shades = np.zeros(height.shape)
    if known.any():
        least, most = height[known].min(), height[known].max()
        shades = (height - least) / max(most - least, 1e-9)
    grey = 90 + 130 * np.clip(shades, 0, 1)
    cells = np.repeat(grey[..., None], 3, axis=2)
    cells[sand > 0] *= (1.0, 0.82, 0.55)
    cells[impassable > 0] = IMPASSABLE
    cells[~known] = UNSEEN
    return cells.astype("u1")


class Frame:
    """An image of a map."""

    def __init__(self, cells):
        self._rows, self._columns = cells.shape[:2]
        self._pixels = max(1, _SIDE // max(self._rows, self._columns))
        self._image = cells.repeat(self._pixels, axis=0).repeat(self._pixels, axis=1)

    def mark(self, cell, colour, share=0.7):
        """Fills the middle of a cell (x, y); beyond the map nothing."""
        x, y = cell
        if not (0 <= x < self._columns and 0 <= y < self._rows):
            return
        margin = int(self._pixels * (1 - share) / 2)
        across, up = (slice(side * self._pixels + margin, (side + 1) * self._pixels - margin) for side in (x, y))
        self._image[up, across] = colour

    def image(self):
        """The image, north up: an array of shape (height, width, 3) of bytes."""
        return np.ascontiguousarray(self._image[::-1])


def tiled(frames):
    """One image of several of one size, side by side."""
    columns = int(np.ceil(np.sqrt(len(frames))))
    rows = -(-len(frames) // columns)
    blank = np.zeros_like(frames[0])
    frames = [np.pad(frame, ((0, 4), (0, 4), (0, 0))) for frame in [*frames, *[blank] * (rows * columns - len(frames))]]
    return np.concatenate([np.concatenate(frames[row * columns:(row + 1) * columns], axis=1) for row in range(rows)])


def checked(render_mode):
    """A render mode, or an error."""
    if render_mode not in (None, "human", "rgb_array"):
        raise HopperError(f"render_mode needs to be None, 'human' or 'rgb_array', got {render_mode!r}")
    if render_mode == "human":
        _pyplot()
    return render_mode


class Window:
    """Shows frames in a window of matplotlib. Where its backend has no windows, they are drawn and not shown."""

    def __init__(self, title):
        self._title, self._shown = title, None

    def show(self, image):
        """Shows an image in place of the last one."""
        plt = _pyplot()
        if self._shown is None:
            figure, ax = plt.subplots(num=self._title, clear=True)
            ax.set_axis_off()
            self._shown = figure, ax.imshow(image)
            if plt.get_backend().lower() != "agg":
                figure.show()
        figure, picture = self._shown
        picture.set_data(image)
        figure.canvas.draw_idle()
        figure.canvas.flush_events()

    def close(self):
        """Closes the window."""
        if self._shown is not None:
            _pyplot().close(self._shown[0])
            self._shown = None

    def __deepcopy__(self, memo):
        # A copy opens one of its own.
        return Window(self._title)

    def __reduce__(self):
        return Window, (self._title,)


def _pyplot():
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise HopperError("render_mode 'human' needs matplotlib: pip install matplotlib") from None
    return plt
