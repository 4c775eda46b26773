# SPDX-License-Identifier: GPL-3.0-or-later
"""What exporters find follows beside Blender's window: its base color is solved in a process, one at a time, once values rest."""

from dataclasses import dataclass, field

import bpy

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.exchange import conversion_process
from ...reference_py.exchange import hand_over as solving
from ...reference_py.material.stack import Stack
from ..material import hand_over, principled_node, reading
from ..material import material as materials
from .process import Process, worker


class _Conversion(Process):
    """One base color in the making, in a process of its own."""

    def __init__(self, stack: Stack, textured: bool, key: str):
        super().__init__(Sentence("a conversion"), worker(conversion_process.MODULE), [conversion_process.request(stack, textured)])
        self.stack, self.textured, self.key = stack, textured, key


@dataclass
class _State:
    running: _Conversion | None = None
    debounced: dict[str, str] = field(default_factory=dict)
    failed: set[str] = field(default_factory=set)


_state = _State()


def follow(material: bpy.types.Material) -> bool:
    """Bring what exporters find of one material nearer to its values; whether there is more to do.

    Opening a file changes nothing: a material that has no hand-over yet waits for its next change or save.
    """
    if not hand_over.has_hand_over(material):
        return False
    try:
        stack = reading.stack_of(material)
    except LaminaError:
        return False  # Check names the value, and exporters find the last right ones
    if hand_over.is_handed_over(material, stack):
        _state.debounced.pop(material.name_full, None)
        return False
    textured = principled_node.has_linked_color(material)
    key = solving.key_of(stack, textured)
    if solving.cached_hand_over(stack, textured):
        materials.hand_over(material)
        return False
    is_debounced = _state.debounced.get(material.name_full) == key
    _state.debounced[material.name_full] = key
    if key in _state.failed:
        return False
    if is_debounced and _state.running is None:
        materials.hand_over(material)  # all but the base color, at once
        try:
            _state.running = _Conversion(stack, textured, key)
        except LaminaError as error:
            _fail(key, str(error))
    return True


def collect() -> bool:
    """Take what a process has solved; whether one is at work."""
    running = _state.running
    if running is None:
        return False
    if running.key not in _state.debounced.values():
        running.cancel()  # nobody wants it any more
    if not running.is_done:
        return True
    _state.running = None
    if running.result is not None:
        solving.put(running.stack, running.textured, running.result)
    elif running.key in _state.debounced.values():
        _fail(running.key, running.error)
    return False


def _fail(key: str, why: str) -> None:
    _state.failed.add(key)  # the panel says that the error is not known
    print(f"Lamina: exporters find the stack's own base color, as the right one is not solved: {why}")


def stop() -> None:
    """End what is at work."""
    if _state.running is not None:
        _state.running.cancel()
        _state.running = None
