# SPDX-License-Identifier: GPL-3.0-or-later
"""Colors between the model, which computes in linear Rec.709, and the open file's working space, in which sockets and shaders are.

Blender has one working space before 5.0, and three from then on. It converts colors of sockets, ramps and nodes when a
file is converted, or something is appended or linked from a file of another space; numbers in a text or a vector stay.
"""

import bpy
import numpy as np
from mathutils import Color

REC709 = "Linear Rec.709"
# What float32 and 5 digits of a matrix leave out in Blender's color configuration.
_TOLERANCE = 1e-4


def working_space() -> str:
    """The name of the open file's working space."""
    colorspace = getattr(bpy.data, "colorspace", None)
    return colorspace.working_space if colorspace is not None else REC709


def primaries() -> np.ndarray:
    """Rec.709's red, green and blue in the working space, as rows (3, 3)."""
    if working_space() == REC709:
        return np.eye(3)
    return np.array([Color(row).from_rec709_linear_to_scene_linear() for row in np.eye(3)])


def into_working(colors) -> np.ndarray:
    """Colors (..., 3) of the model as the working space has them."""
    return np.asarray(colors, float) @ primaries()


def out_of_working(colors) -> np.ndarray:
    """Colors (..., 3) of the working space as the model has them; some lie outside Rec.709, with components below 0 or above 1."""
    if working_space() == REC709:
        return np.asarray(colors, float)
    return np.asarray(colors, float) @ np.linalg.inv(primaries())


def is_current(color, primary: int) -> bool:
    """Whether a color (3,) of a file is what the working space has for a primary of Rec.709 (0 red, 1 green, 2 blue)."""
    return bool(np.allclose(color, primaries()[primary], atol=_TOLERANCE))
