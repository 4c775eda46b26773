# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina plot`: a stack and what a model says of it, as an SVG picture."""

from pathlib import Path

from ...reference_py.atomic import require_writable, write_text
from ...reference_py.errors import LaminaError
from ...reference_py.plots.stack_picture import picture
from .print_values import load_stack, model_of, view_angles


def plot(options) -> None:
    """Write the picture."""
    path = Path(options.output)
    if path.suffix != ".svg":
        raise LaminaError(f"-o {path}: unknown ending {path.suffix!r}; choose a name that ends in .svg")
    require_writable(path)
    views = view_angles(options.theta)
    model, _ = model_of(options)
    write_text(path, picture(load_stack(options.stack), model, views))
