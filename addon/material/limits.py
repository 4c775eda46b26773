# SPDX-License-Identifier: GPL-3.0-or-later
"""What refuses a stack whatever its values, told before any work. Does not need bpy."""

from ...reference_py.errors import LaminaError
from ...reference_py.material.coverage import patches
from ...reference_py.material.stack import Stack
from ..shader.inputs import shader_inputs
from .backend import NODES


def require_shader(stack: Stack, backend: str) -> None:
    """Raise LaminaError for a stack that no shader can have, with the count and the limit.

    The parameters of a live OSL shader count in every tier, though a bake needs none of them: it is shown by the tier
    analytic until it is done, and a texture makes it live again. Stock nodes have no such limit.
    """
    patches(stack)
    if backend == NODES:
        return
    try:
        shader_inputs(stack)
    except LaminaError as error:
        raise LaminaError("{error}, or the backend {backend}", error=error, backend=NODES) from None
