# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated shader in a material: a Text datablock, its Script node, and the proof that it compiled."""

import hashlib
import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

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
    if text is not None and text.library is None and not text.users and is_untouched(text.as_string()):
        bpy.data.texts.remove(text)


def is_untouched(text: str) -> bool:
    """Whether a shader's text still has the hash that its name states."""
    match = re.search(r"\bshader (lamina_([0-9a-f]{12}))\(", text)
    return bool(match) and hashlib.sha256(text.replace(match[1], "@SHADER@").encode()).hexdigest().startswith(match[2])


def holds(node: bpy.types.ShaderNodeScript, shader: Shader) -> bool:
    """Whether a Script node has this very shader, compiled, with all its sockets."""
    text = node.script
    present = {socket.identifier for socket in (*node.inputs, *node.outputs)}
    return text is not None and text.as_string() == shader.text and bool(node.bytecode) and _needed(shader) <= present


def set_script(node: bpy.types.ShaderNodeScript, shader: Shader) -> None:
    """Give a new Script node the shader, compiled. Raises LaminaError when that fails: Cycles would render such a node white without an error."""
    compiled = compile_shader(shader)
    node.mode = "INTERNAL"
    with _not_compiled_again():
        node.script = text_of(shader)
    for is_output, kind, name, default in compiled.sockets:
        sockets = node.outputs if is_output else node.inputs
        socket = sockets.get(name) or sockets.new(kind, name, identifier=name)
        if default is not None:
            socket.default_value = default
    node.bytecode, node.bytecode_hash = compiled.bytecode, compiled.bytecode_hash


@contextmanager
def _not_compiled_again() -> Iterator[None]:
    """While the scene renders with Cycles, Blender compiles a text as soon as a node gets it, through this function of Cycles' add-on."""
    import cycles.osl

    before = cycles.osl.update_script_node
    cycles.osl.update_script_node = lambda *_: False
    try:
        yield
    finally:
        cycles.osl.update_script_node = before


@dataclass(frozen=True)
class _Compiled:
    """What a Script node gets of a shader: its bytecode, and its sockets as (of the outputs, type, name, default)."""

    bytecode: str
    bytecode_hash: str
    sockets: tuple[tuple, ...]


# By their texts: materials that share a shader compile it once. The latest ones only.
_MOST_COMPILED = 32
_compiled: dict[str, _Compiled] = {}


def compile_shader(shader: Shader) -> _Compiled:
    """A shader as Blender's compiler makes it, at once where it did so before. Raises LaminaError when sockets are missing."""
    if shader.text not in _compiled:
        made = _compile(shader)
        if len(_compiled) >= _MOST_COMPILED:
            _compiled.pop(next(iter(_compiled)))
        _compiled[shader.text] = made
    return _compiled[shader.text]


def _compile(shader: Shader) -> _Compiled:
    """What `cycles.osl.update_script_node` does, without a node: so a shader can be compiled before there is one, and no temporary file stays behind."""
    import _cycles
    import oslquery
    from cycles.osl import shader_param_type_default

    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, f"{shader.name}.osl"), Path(folder, f"{shader.name}.oso")
        source.write_text(shader.text, encoding="utf-8")
        is_compiled = _cycles.osl_compile(str(source), str(target))
        code = _anonymous(target.read_text(encoding="utf-8")) if is_compiled else ""
        parameters = oslquery.OSLQuery(str(target)).parameters if is_compiled else ()
        rows = [(p.isoutput, p.name, *shader_param_type_default(p, False)) for p in parameters if p.type.arraylen == 0]
    missing = sorted(_needed(shader) - {name for _, name, _, _ in rows})
    if missing:
        raise LaminaError(
            "the shader {shader} did not compile, sockets missing: {missing}; the console says why", shader=shader.name, missing=", ".join(missing)
        )
    return _Compiled(code, hashlib.md5(code.encode(), usedforsecurity=False).hexdigest(), tuple((of, kind, name, value) for of, name, kind, value in rows))


def _anonymous(code: str) -> str:
    """A compiled shader without the compiler's remarks: they hold folders of this machine, and the file may travel."""
    return re.sub(r"%(?:filename|line)\{[^}]*\} ?", "", re.sub(r"\n#[^\n]*", "", "\n" + code)[1:])


def _needed(shader: Shader) -> set[str]:
    """The sockets that a node of the shader has, by identifier."""
    return {"BSDF", *shader.others, *(i.osl_name for i in shader.inputs)}
