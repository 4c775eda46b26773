# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated shader in a material: a Text datablock, its Script node, and the proof that it compiled."""

import hashlib
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import bpy

from ...reference_py.errors import LaminaError
from ..shader.osl.generate import Shader


def text_of(shader: Shader) -> bpy.types.Text:
    """The Text datablock that holds the shader. A text of its name that somebody edited is left alone."""
    name = f"{shader.name}.osl"
    for text in bpy.data.texts:
        if text.library is None and text.name.startswith(name) and text.as_string() == shader.text:
            return text
    text = bpy.data.texts.new(name)
    text.use_fake_user = False  # it goes with the last material that uses it
    text.from_string(shader.text)
    return text


def drop_text(text: bpy.types.Text | None) -> None:
    """Remove a generated text that no node uses any more. A text edited by hand stays."""
    if text is None or text.library is not None or not is_untouched(text.as_string()):
        return
    if not bpy.data.user_map(subset={text})[text]:
        bpy.data.texts.remove(text)


def is_untouched(text: str) -> bool:
    """Whether a shader's text still has the hash that its name states."""
    match = re.search(r"\bshader (lamina_([0-9a-f]{12}))\(", text)
    return bool(match) and hashlib.sha256(text.replace(match[1], "@SHADER@").encode()).hexdigest().startswith(match[2])


def holds(node: bpy.types.ShaderNodeScript, shader: Shader) -> bool:
    """Whether a Script node has this very shader, compiled, with all its sockets."""
    text = node.script
    return text is not None and text.as_string() == shader.text and bool(node.bytecode) and not _missing(node, shader)


def set_script(node: bpy.types.ShaderNodeScript, shader: Shader) -> None:
    """Give a new Script node the shader and compile it into the node.

    Raises LaminaError with the compiler's words when sockets are missing afterwards: Cycles would render such a
    node white without an error.
    """
    log: list[str] = []
    node.mode = "INTERNAL"
    with _compiler_leftovers_removed():
        node.script = text_of(shader)  # compiles it only while the window's scene renders with Cycles
        if _missing(node, shader) and shader.name in _compiled:
            _compiled[shader.name].give(node)
            return
        if _missing(node, shader):
            import cycles.osl

            cycles.osl.update_script_node(node, lambda level, message: log.append(message))
    missing = _missing(node, shader)
    if missing:
        said = " ".join(log) or "the compiler said nothing"
        raise LaminaError("the shader {shader} did not compile, sockets missing: {missing}; {said}", shader=shader.name, missing=", ".join(missing), said=said)
    _anonymise(node)
    if len(_compiled) >= _MOST_COMPILED:
        _compiled.pop(next(iter(_compiled)))
    _compiled[shader.name] = _Compiled.of(node)


@dataclass(frozen=True)
class _Compiled:
    """What compiling gave a node: its bytecode, and its sockets as (of the outputs, type, name, identifier, default)."""

    bytecode: str
    bytecode_hash: str
    sockets: tuple[tuple, ...]

    @classmethod
    def of(cls, node) -> "_Compiled":
        rows = []
        for sockets in (node.inputs, node.outputs):
            for s in sockets:
                default = getattr(s, "default_value", None)
                rows.append((s.is_output, s.bl_idname, s.name, s.identifier, default if isinstance(default, (int, float, str, type(None))) else tuple(default)))
        return cls(node.bytecode, node.bytecode_hash, tuple(rows))

    def give(self, node) -> None:
        for is_output, kind, name, identifier, default in self.sockets:
            socket = (node.outputs if is_output else node.inputs).new(kind, name, identifier=identifier)
            if default is not None:
                socket.default_value = default
        node.bytecode, node.bytecode_hash = self.bytecode, self.bytecode_hash


# By shader name, which is a hash of its text: materials that share a shader compile it once. The latest ones only.
_MOST_COMPILED = 32
_compiled: dict[str, _Compiled] = {}


@contextmanager
def _compiler_leftovers_removed() -> Iterator[None]:
    """Blender leaves a temporary file of up to some megabytes behind for each compilation of a text."""
    before = tempfile.tempdir
    with tempfile.TemporaryDirectory() as folder:
        tempfile.tempdir = folder
        try:
            yield
        finally:
            tempfile.tempdir = before


def _anonymise(node) -> None:
    """Drop the compiler's remarks from the compiled shader: they hold folders of this machine, and the file may travel."""
    code = re.sub(r"\n#[^\n]*", "", "\n" + node.bytecode)[1:]
    node.bytecode = re.sub(r"%(?:filename|line)\{[^}]*\} ?", "", code)
    node.bytecode_hash = hashlib.md5(node.bytecode.encode(), usedforsecurity=False).hexdigest()


def _missing(node, shader: Shader) -> list[str]:
    """Sockets that the shader needs and the node has not."""
    present = {socket.identifier for socket in (*node.inputs, *node.outputs)}
    return sorted({"BSDF", *shader.others, *(i.osl_name for i in shader.inputs)} - present)
