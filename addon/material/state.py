# SPDX-License-Identifier: GPL-3.0-or-later
"""What each branch of a material was made for, and whether that still is what its sockets say."""

from collections.abc import Callable
from dataclasses import dataclass

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import content
from ...reference_py.lobes.methods import HOLD_VALUES, TIERS, AutoLobes
from ...reference_py.lobes.methods.auto import DEFAULT_TOLERANCE
from ...reference_py.material.stack import Stack
from ..shader.inputs import PRIMARIES
from ..shader.nodes.node_groups import is_in_working_space as group_is_in_working_space
from ..shader.working_space import REC709, is_current, working_space
from .backend import NODES, OSL, branches_here
from .limits import require_shader
from .live_values import live_values
from .reading import stack_of
from .roles import node_with
from .shader_node import shader_of

# Of a branch's node: a hash of the values that it holds, empty where it reads them, and what it was computed for in
# tiers that compute first, empty until that is done.
TOLD, SETTLED = "lamina_told", "lamina_settled"


@dataclass(frozen=True)
class Wanted:
    """The lobe set that a material's tier stands for, before it is made."""

    stack: Stack
    tier: str
    live: tuple[tuple[int, str], ...] = ()
    tolerance: float = DEFAULT_TOLERANCE

    @property
    def _options(self) -> dict:
        return {"live": self.live} | ({"tolerance": self.tolerance} if self.tier == AutoLobes.tier else {})

    @property
    def key(self) -> str:
        return TIERS[self.tier].key(self.stack, **self._options)

    def is_known(self) -> bool:
        return TIERS[self.tier].is_known(self.stack, **self._options)

    def make(self, progress: Callable[[float], None] | None = None):
        return TIERS[self.tier](self.stack, progress=progress, **self._options)


def wanted_lobes(material: bpy.types.Material) -> Wanted:
    """What a material's tier, one of HOLD_VALUES, wants for its present values. Raises LaminaError for bad values and too many layers."""
    lamina = material.lamina
    stack = stack_of(material)
    require_shader(stack, lamina.backend)
    live = live_values(material) if OSL in branches_here(lamina.backend) else ()
    return Wanted(stack, lamina.tier, live, 0.01 * lamina.tolerance)


def note_of(node: bpy.types.Node | None, name: str, material: bpy.types.Material) -> str:
    """TOLD or SETTLED of a branch's node. Files of schema 1 and 2 have them on the material."""
    if node is None:
        return ""
    return node[name] if name in node else {TOLD: material.lamina.told, SETTLED: material.lamina.settled}[name]


def is_stale(material: bpy.types.Material) -> bool:
    """Whether what this Blender renders holds values that are no longer those of the sockets."""
    node = shader_of(material)
    if node is not None and not is_in_working_space(node):
        return True
    told = note_of(node, TOLD, material)
    if not told:
        return False
    return told != content(stack_of(material), live_values(material) if node == node_with(material, OSL) else ())


def is_in_working_space(node: bpy.types.Node) -> bool:
    """Whether a branch's colors are in the file's working space. Those of older files are in Rec.709."""
    if node.bl_idname == "ShaderNodeGroup":
        return node.node_tree is None or group_is_in_working_space(node.node_tree)
    if not all(name in node.inputs for name in PRIMARIES):
        return working_space() == REC709
    return all(is_current(node.inputs[name].default_value[:3], i) for i, name in enumerate(PRIMARIES))


def is_settled(material: bpy.types.Material) -> bool:
    """Whether what this Blender renders is what the material's tier stands for, and not what stands in for it."""
    if material.lamina.tier not in HOLD_VALUES:
        return True
    return note_of(shader_of(material), SETTLED, material) == wanted_lobes(material).key


def lacks_branch(material: bpy.types.Material) -> bool:
    """Whether a branch that the material should have here is not there: it comes from an older file, or a Blender without OSL."""
    return any(node_with(material, role) is None for role in branches_here(material.lamina.backend))


def lags(material: bpy.types.Material) -> bool:
    """Whether the stock nodes beside a script are behind it, or one of the two is not there.

    They stay what they are while a socket holds what the schema does not allow, which Check names.
    """
    if lacks_branch(material):
        return True
    script, stock = node_with(material, OSL), node_with(material, NODES)
    if stock is None or stock == shader_of(material):
        return False
    try:
        now = content(stack_of(material))
    except LaminaError:
        return False
    told, settled = note_of(stock, TOLD, material), note_of(stock, SETTLED, material)
    expected = "" if live_values(material) else note_of(script, SETTLED, material)
    return told != now or not is_in_working_space(stock) or (material.lamina.tier in HOLD_VALUES and settled != expected)
