"""How colours look with a reduced colour vision, and how far apart two colours are to the eye.

Simulation: Viénot, Brettel and Mollon, Color Research and Application 24 (1999) 243, in linear sRGB: the cone that is
missing takes the response that keeps white and blue (protanopia, deuteranopia) as they are. Distance: CIE 1976, the
distance of two colours in CIELAB with the white point D65 (IEC 61966-2-1, CIE 15).
"""

import numpy as np
from matplotlib.colors import to_rgb

# Linear sRGB to the responses of the long, middle and short cones (Viénot et al., table of the method).
TO_CONES = np.array([[17.8824, 43.5161, 4.11935], [3.45565, 27.1554, 3.86714], [0.0299566, 0.184309, 1.46709]])
# The response that is lost, from the two that are left.
LOST = {
    "normal": np.eye(3),
    "protanopia": np.array([[0, 2.02344, -2.52581], [0, 1, 0], [0, 0, 1]]),
    "deuteranopia": np.array([[1, 0, 0], [0.494207, 0, 1.24827], [0, 0, 1]]),
}
TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
WHITE = TO_XYZ.sum(axis=1)


def seen_lab(colour: str, vision: str) -> np.ndarray:
    """L*, a*, b* of a colour as somebody with this vision sees it."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.linalg.solve(TO_CONES, LOST[vision] @ TO_CONES @ linear), 0, 1)
    ratio = TO_XYZ @ seen / WHITE
    root = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.array([116 * root[1] - 16, 500 * (root[0] - root[1]), 200 * (root[1] - root[2])])


def distance(one: str, other: str, vision: str) -> float:
    """How far apart two colours are for this vision; 2.3 is the smallest difference that an eye can see."""
    return float(np.linalg.norm(seen_lab(one, vision) - seen_lab(other, vision)))
