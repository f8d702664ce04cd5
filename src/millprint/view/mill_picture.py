"""Views of a mill, and moments of its motion, from its description only."""

from dataclasses import dataclass

import numpy as np

from millprint.config.mill import MillConfig
from millprint.mill.bodies import Body, build_bodies
from millprint.mill.wall_words import round_triangles, walls_in_words
from millprint.view.frames import VIEWS, Drawing, Shape, View, draw_bodies

FRAMES = 8
PATH_POINTS = 361
# A margin around everything that moves, as a fraction of its size.
MARGIN = 0.06


@dataclass(frozen=True)
class Look(Drawing):
    """A mill in one view at one moment, with the marked point mark_mm (2,)."""

    mark_mm: np.ndarray


@dataclass(frozen=True)
class MillPicture:
    """Views of a mill at the start of a turn, and a strip of FRAMES moments in the view that shows most of its motion.

    path_mm (m, 2): the path of a marked point of the wall (of the first insert, if the vessel does not move) in the
    view of the strip; limits_mm (2, 2) of every view in turn, and of the strip; mark_mm in a `Look` is that point.
    """

    title: str
    walls: str
    speed_unit: str
    views: tuple[View, ...]
    looks: tuple[Look, ...]
    limits_mm: tuple[np.ndarray, ...]
    strip_view: View
    strip: tuple[Look, ...]
    strip_limits_mm: np.ndarray
    path_mm: np.ndarray


def _picture_of(view: View, bodies: list[Body], shapes: list[Shape], mark: tuple[int, np.ndarray], turn: float) -> Look:
    vertices = [body.to_laboratory(shape.vertices_m, turn) for body, shape in zip(bodies, shapes, strict=True)]
    drawing = draw_bodies(view, shapes, vertices, [body.motion.rotation(turn) for body in bodies])
    body, point = mark
    return Look(**vars(drawing), mark_mm=view.flat(bodies[body].to_laboratory(point[None], turn))[0])


def _limits(view: View, points: np.ndarray) -> np.ndarray:
    flat = view.flat(points).reshape(-1, 2)
    low, high = flat.min(axis=0), flat.max(axis=0)
    return np.array([low, high]) + MARGIN * (high - low).max() * np.array([[-1.0], [1.0]])


def picture_mill(mill: MillConfig) -> MillPicture:
    """The picture of a mill; raises ConfigError for a shape or a motion that is refused."""
    bodies = build_bodies(mill)
    shapes = [Shape(*body.vessel.triangles(), round_triangles(body.vessel)) for body in bodies]
    # One turn per second, so that times are turns.
    turns = np.arange(FRAMES) / FRAMES
    moving = next((k for k, body in enumerate(bodies) if body.motion.frequency_hz), 0)
    corners = shapes[moving].vertices_m
    # The vertex farthest from the body's origin in the horizontal plane is easiest to follow.
    mark = moving, corners[np.argmax(np.linalg.norm(corners - shapes[moving].middle_m, axis=1))]
    times = np.linspace(0, 1, PATH_POINTS)
    path = np.array([bodies[moving].to_laboratory(mark[1][None], time)[0] for time in times])
    everywhere = np.concatenate([
        body.to_laboratory(shape.vertices_m, turn) for turn in turns for body, shape in zip(bodies, shapes, strict=True)
    ])  # fmt: skip
    spans = [np.ptp(view.flat(path), axis=0) for view in VIEWS]
    strip_view = VIEWS[int(np.argmax([span.prod() + 1e-6 * span.sum() for span in spans]))]
    start = [body.to_laboratory(shape.vertices_m, 0.0) for body, shape in zip(bodies, shapes, strict=True)]
    return MillPicture(
        title=mill.title,
        walls=f"wall: {walls_in_words(bodies)}",
        speed_unit=mill.speed_unit,
        views=VIEWS,
        looks=tuple(_picture_of(view, bodies, shapes, mark, 0.0) for view in VIEWS),
        limits_mm=tuple(_limits(view, np.concatenate(start)) for view in VIEWS),
        strip_view=strip_view,
        strip=tuple(_picture_of(strip_view, bodies, shapes, mark, turn) for turn in turns),
        strip_limits_mm=_limits(strip_view, everywhere),
        path_mm=strip_view.flat(path),
    )
