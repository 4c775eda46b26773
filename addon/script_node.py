# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated shader in a material: a Text datablock, its Script node, and the proof that it compiled."""

import bpy

from ..reference_py.errors import LaminaError
from .network.osl import Shader
from .rendering.environment import osl_available


def require_osl() -> None:
    """Raise LaminaError where Script nodes cannot work, before anything is changed."""
    available, reason = osl_available()
    if not available:
        raise LaminaError(
            f"Lamina needs Cycles with OSL, and {reason}; use a Blender from blender.org, with CPU or OptiX rendering"
        )


def enable_osl(scene: bpy.types.Scene) -> list[str]:
    """Switch a scene to Cycles with OSL. Returns one sentence per thing that was changed, for the user to see."""
    notices = []
    if scene.render.engine != "CYCLES":
        notices.append(f"render engine of {scene.name} set to Cycles (was {scene.render.engine})")
        scene.render.engine = "CYCLES"
    if not scene.cycles.shading_system:
        notices.append(f"Open Shading Language switched on in {scene.name}")
        scene.cycles.shading_system = True
    return notices


def text_of(shader: Shader) -> bpy.types.Text:
    """The Text datablock that holds the shader. A text of that name edited by hand is left alone, a new one is made."""
    name = f"{shader.name}.osl"
    text = bpy.data.texts.get(name)
    if text is None or text.library is not None or text.as_string() != shader.text:
        text = bpy.data.texts.new(name)
        text.from_string(shader.text)
    return text


def set_script(node: bpy.types.ShaderNodeScript, shader: Shader) -> None:
    """Give a Script node the shader and compile it into the node.

    Raises LaminaError with the compiler's words when sockets are missing afterwards: Cycles would render such a
    node white without an error.
    """
    import cycles.osl

    log: list[str] = []
    node.mode = "INTERNAL"
    node.script = text_of(shader)
    cycles.osl.update_script_node(node, lambda level, message: log.append(message))
    wanted = {i.osl_name for i in shader.inputs}
    missing = sorted(wanted - {socket.identifier for socket in node.inputs})
    if missing or "BSDF" not in {socket.identifier for socket in node.outputs}:
        said = " ".join(log) or "the compiler said nothing"
        raise LaminaError(f"the shader {shader.name} did not compile, sockets missing: {', '.join(missing) or 'BSDF'}; {said}")
    for socket in [s for s in node.inputs if s.identifier not in wanted]:
        node.inputs.remove(socket)
