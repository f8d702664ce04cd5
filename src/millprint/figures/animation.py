"""The mill in motion: balls and jar from above and from the side, drawn frame by frame into an animation."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize, to_rgb
from PIL import Image

from millprint.config.errors import ConfigError
from millprint.figures.style import COLUMN_WIDTH_IN, PAGE_WIDTH_IN, no_formula, plt
from millprint.run.files import whole_file
from millprint.run.job import progress
from millprint.view.frames import Frame, Movie, Panel, Picture

# A compromise between sharp text and a file of a few megabytes.
DPI = 150
SPEEDS = plt.get_cmap("plasma", 32)
WALL_DARK, WALL_LIGHT = 0.74, 0.95
INK = "#303030"

# Inches: margins of the panels, and the room of heading, clock and colour bar.
LEFT, RIGHT, TOP, BETWEEN, BOTTOM = 0.46, 0.62, 0.66, 0.42, 0.38


class _View:
    """The artists of one panel, made once and given new arrays for each frame."""

    def __init__(self, axes: Axes, panel: Panel, balls: int) -> None:
        self._axes = axes
        (self._path,) = axes.plot(*panel.path_mm.T, color=INK, linewidth=0.5, linestyle=(0, (3, 3)))
        self._wall = PolyCollection([], linewidths=0.3)
        self._outline = LineCollection([], colors=INK, linewidths=0.7)
        # Each ball is followed by its highlight, so that a nearer ball covers both.
        size = np.zeros(2 * balls)
        self._balls = EllipseCollection(
            size, size, np.zeros(2 * balls), units="xy", offsets=np.zeros((2 * balls, 2)), transOffset=axes.transData
        )
        self._balls.set(edgecolor=[INK, "none"] * balls, linewidth=[0.4, 0.0] * balls)
        (self._jar,) = axes.plot([], [], marker="+", color=INK, markersize=5, markeredgewidth=0.7)
        # Thin, over the balls: otherwise a full bed would hide a stirrer.
        self._inserts = LineCollection([], colors=INK, linewidths=0.5, alpha=0.6)
        # From the back to the front.
        self._artists = (self._wall, self._path, self._jar, self._outline, self._balls, self._inserts)
        for artist in self._artists:
            artist.set_animated(True)
        for collection in (self._wall, self._outline, self._balls, self._inserts):
            axes.add_collection(collection, autolim=False)

    def draw(self, picture: Picture, speeds: Normalize) -> None:
        grey = WALL_DARK + (WALL_LIGHT - WALL_DARK) * picture.wall_shade
        shades = np.repeat(grey[:, None], 3, axis=1)
        self._wall.set(verts=picture.wall_mm, facecolor=shades, edgecolor=shades)
        self._outline.set(segments=picture.outline_mm)
        self._inserts.set(segments=picture.insert_mm)
        # The order from back to front changes from frame to frame.
        size = np.outer(picture.radius_mm, [2.0, 0.7]).ravel()
        self._balls.set(widths=size, heights=size)
        glint = picture.centre_mm + np.outer(picture.radius_mm, [-0.35, 0.35])
        self._balls.set_offsets(np.stack([picture.centre_mm, glint], axis=1).reshape(-1, 2))
        colours = SPEEDS(speeds(picture.speed_m_s))
        self._balls.set(facecolor=np.stack([colours, _glint(colours)], axis=1).reshape(-1, 4))
        self._jar.set_data(picture.jar_mm[:1], picture.jar_mm[1:])
        for artist in self._artists:
            self._axes.draw_artist(artist)


class Animation:
    """A figure with a panel for each view, all to one scale; only balls, jar and clock are redrawn."""

    def __init__(self, movie: Movie) -> None:
        self._movie = movie
        self._width = COLUMN_WIDTH_IN if movie.columns == 1 else PAGE_WIDTH_IN
        room = (self._width - RIGHT) / movie.columns - LEFT
        sizes = [panel.limits_mm[1] - panel.limits_mm[0] for panel in movie.panels]
        scale = room / max(size[0] for size in sizes)
        # The panels of a row show the same view, so they have the same height.
        rows = [scale * size[1] for size in sizes[:: movie.columns]]
        height = TOP + BOTTOM + BETWEEN * (len(rows) - 1) + sum(rows)
        self.figure = plt.figure(figsize=(self._width, height), dpi=DPI, layout="none")
        self._speeds = Normalize(0, movie.speed_max_m_s)
        balls = len(movie.frames[0].pictures[0].centre_mm)
        self._views = []
        for place, (panel, size) in enumerate(zip(movie.panels, sizes, strict=True)):
            row, column = divmod(place, movie.columns)
            bottom = height - TOP - sum(rows[: row + 1]) - BETWEEN * row
            left = LEFT + column * (room + LEFT)
            axes = self._axes(panel, left, bottom, scale * size[0], rows[row], height)
            self._views.append(_View(axes, panel, balls))
            if row == len(rows) - 1:
                axes.set_xlabel(panel.labels[0])
        self._colour_bar(height)
        self.figure.text(0.02, 1 - 0.05 / height, no_formula(movie.heading), va="top", fontsize=8, linespacing=1.3)
        self._clock = self.figure.text(
            0.02, 1 - 0.36 / height, "", va="top", fontsize=7, color=INK, animated=True, family="monospace"
        )
        canvas = self.figure.canvas
        assert isinstance(canvas, FigureCanvasAgg), "figures.style has chosen to draw pixels"
        self._canvas = canvas
        canvas.draw()
        self._empty = canvas.copy_from_bbox(self.figure.bbox)

    def _axes(self, panel: Panel, left: float, bottom: float, width: float, height: float, whole: float) -> Axes:
        axes = self.figure.add_axes((left / self._width, bottom / whole, width / self._width, height / whole))
        axes.set(xlim=panel.limits_mm[:, 0], ylim=panel.limits_mm[:, 1], ylabel=panel.labels[1], aspect="equal")
        axes.set_title(panel.title, loc="left", fontsize=7, pad=2)
        axes.tick_params(labelsize=6, length=2)
        return axes

    def _colour_bar(self, height: float) -> None:
        bottom, top = BOTTOM, height - TOP
        place = ((self._width - RIGHT + 0.1) / self._width, bottom / height, 0.1 / self._width, (top - bottom) / height)
        bar = self.figure.colorbar(ScalarMappable(self._speeds, SPEEDS), cax=self.figure.add_axes(place))
        bar.set_label("speed relative to the jar [m/s]", fontsize=7)
        bar.ax.tick_params(labelsize=6, length=2)

    def draw(self, frame: Frame) -> Image.Image:
        """One frame as a picture."""
        self._canvas.restore_region(self._empty)
        for view, picture in zip(self._views, frame.pictures, strict=True):
            view.draw(picture, self._speeds)
        turns = "" if frame.revolution is None else f"  revolution {frame.revolution:5.2f}"
        self._clock.set_text(f"t = {frame.time_s:.3f} s{turns}  {self._movie.pace}")
        self.figure.draw_artist(self._clock)
        return Image.fromarray(np.asarray(self._canvas.buffer_rgba())[..., :3])


def _glint(colours: np.ndarray) -> np.ndarray:
    """Lighter versions of colours (n, 4)."""
    return 1 - 0.55 * (1 - colours)


def _palette() -> Image.Image:
    """The colours that are drawn and their blends with the ink, the same for every frame so that nothing flickers."""
    ink, balls = np.array([*to_rgb(INK), 1]), SPEEDS(np.arange(SPEEDS.N))
    # Not closer: Pillow finds colours on a grid of four levels and would use a light grey for the paper.
    greys = np.repeat(np.linspace(0, 1, 33)[:, None], 4, axis=1)
    darker = [(share * balls + (1 - share) * ink) for share in (0.75, 0.5, 0.25)]
    colours = np.concatenate([greys, balls, _glint(balls), *darker])
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.round(255 * colours[:, :3]).astype(np.uint8).tobytes())
    return palette


def save_animation(movie: Movie, *paths: str | Path) -> None:
    """Draw a movie into files, GIF or PNG (which browsers also play), by the ending of the name.

    Raises ConfigError for another ending.
    """
    for path in paths:
        if Path(path).suffix not in (".gif", ".png"):
            raise ConfigError(f"{path}: an animation is a .gif or a .png")
    animation = Animation(movie)
    palette = _palette()

    drawn = []
    with progress(len(movie.frames), "drawing", "frame") as bar:
        for frame in movie.frames:
            drawn.append(animation.draw(frame).quantize(palette=palette, dither=Image.Dither.NONE))
            bar.update()
    plt.close(animation.figure)
    for path in paths:
        with whole_file(path) as partial:
            drawn[0].save(partial, save_all=True, append_images=drawn[1:], duration=movie.delay_ms, loop=0)
