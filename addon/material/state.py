# SPDX-License-Identifier: GPL-3.0-or-later
"""What each branch of a material was made for, and whether that still is what its sockets say."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import bpy

from ...reference_py.errors import LaminaError
from ...reference_py.lobes import methods
from ...reference_py.lobes.cache import ALWAYS_LIVE, stack_key
from ...reference_py.lobes.made import DEFAULT_TOLERANCE, Made
from ...reference_py.lobes.methods import bake_process
from ...reference_py.lobes.tabulate import without_metals
from ...reference_py.material.place import Place
from ...reference_py.material.stack import Stack
from ..blender.versions import HAS_DIELECTRIC
from ..shader.inputs import PRIMARIES
from ..shader.nodes.node_groups import is_in_working_space as group_is_in_working_space
from ..shader.working_space import REC709, is_current, working_space
from .backend import NODES, OSL, branches_here
from .eevee_output import is_off
from .limits import require_shader
from .live_values import live_in_nodes, live_values
from .reading import stack_of
from .roles import node_with
from .shader_node import backend_of, shader_of, surface_of

# Of a branch's node: a hash of the values that it holds, empty where it reads them, and what it was computed for in
# tiers that compute first, empty until that is done.
HELD_VALUES, SETTLED = "lamina_told", "lamina_settled"


@dataclass(frozen=True)
class Wanted:
    """The lobe set that a material's tier stands for, before it is made."""

    stack: Stack
    method: str
    live: tuple[Place, ...] = ()
    tolerance: float = DEFAULT_TOLERANCE

    @property
    def key(self) -> str:
        return methods.key_of(self.stack, self.method, live=self.live, tolerance=self.tolerance)

    def is_cached(self) -> bool:
        return methods.is_cached(self.stack, self.method, live=self.live, tolerance=self.tolerance)

    def make(self, progress: Callable[[float], None] | None = None) -> Made:
        made = methods.make_lobe_set(self.stack, self.method, live=self.live, tolerance=self.tolerance, progress=progress)
        return made if HAS_DIELECTRIC else without_metals(made)

    def request(self) -> str:
        """What a process is asked for it."""
        return bake_process.request(self.stack, self.method, self.live, self.tolerance)

    def put(self, packed: list[dict]) -> None:
        """Keep what another process computed."""
        methods.put(self.key, self.stack, self.method, packed, self.live)


def wanted_lobes(material: bpy.types.Material) -> Wanted:
    """What a material's tier, of those that compute first, wants for its present values. Raises LaminaError for bad values and too many layers."""
    lamina = material.lamina
    stack = stack_of(material)
    require_shader(stack, lamina.backend)
    live = live_values(material) if OSL in branches_here(lamina.backend) else live_in_nodes(material, stack)
    return Wanted(stack, lamina.tier, live, 0.01 * lamina.tolerance)


def wanted_stock(material: bpy.types.Material) -> Wanted | None:
    """What the stock nodes beside a script stand for, of a tier that computes first: a bake that follows what they can, and holds what their sockets have of the rest.

    None of other tiers. Raises LaminaError as `wanted_lobes`.
    """
    if not methods.holds_values(material.lamina.tier):
        return None
    wanted = wanted_lobes(material)
    return replace(wanted, live=live_in_nodes(material, wanted.stack))


def note_of(node: bpy.types.Node | None, name: str, material: bpy.types.Material) -> str:
    """HELD_VALUES or SETTLED of a branch's node. Files of schema 1 and 2 have them on the material."""
    if node is None:
        return ""
    return node[name] if name in node else {HELD_VALUES: material.lamina.told, SETTLED: material.lamina.settled}[name]


def is_stale(material: bpy.types.Material) -> bool:
    """Whether what this Blender renders holds values that are no longer those of the sockets."""
    node = shader_of(material)
    if node is not None and not is_in_working_space(node):
        return True
    held_values = note_of(node, HELD_VALUES, material)
    if not held_values:
        return False
    stack = stack_of(material)
    return held_values != stack_key(stack, live_values(material) if node == node_with(material, OSL) else live_in_nodes(material, stack))


def is_in_working_space(node: bpy.types.Node) -> bool:
    """Whether a branch's colors are in the file's working space. Those of older files are in Rec.709."""
    if node.bl_idname == "ShaderNodeGroup":
        return node.node_tree is None or group_is_in_working_space(node.node_tree)
    if not all(name in node.inputs for name in PRIMARIES):
        return working_space() == REC709
    return all(is_current(node.inputs[name].default_value[:3], i) for i, name in enumerate(PRIMARIES))


def is_settled(material: bpy.types.Material) -> bool:
    """Whether what this Blender renders is what the material's tier stands for, and not what stands in for it."""
    if not methods.holds_values(material.lamina.tier):
        return True
    return note_of(shader_of(material), SETTLED, material) == wanted_lobes(material).key


def is_followed(material: bpy.types.Material, place: Place) -> bool:
    """Whether what Cycles shows here follows what is linked to a value of a shown layer or the base; else it shows the mean. Raises LaminaError for bad values."""
    return place.name in ALWAYS_LIVE or backend_of(material) == OSL or place in live_in_nodes(material, stack_of(material))


def is_final(material: bpy.types.Material) -> bool:
    """Whether what this Blender renders was computed for the present values. Raises LaminaError for bad ones."""
    return methods.holds_values(material.lamina.tier) and is_settled(material)


def to_compute(material: bpy.types.Material) -> list[Wanted]:
    """What a material wants computed, both branches of it. Raises LaminaError as `wanted_lobes`."""
    return [w for w in (wanted_lobes(material), wanted_stock(material)) if w is not None] if methods.holds_values(material.lamina.tier) else []


def lacks_branch(material: bpy.types.Material) -> bool:
    """Whether a branch that the material should have here is not there: it comes from an older file, or a Blender without OSL."""
    return any(node_with(material, role) is None for role in branches_here(material.lamina.backend))


def lags(material: bpy.types.Material) -> bool:
    """Whether the stock nodes beside a script are behind it, or one of the two is not there.

    They stay what they are while a socket holds what the schema does not allow, which Check names.
    """
    if lacks_branch(material) or is_off(material, surface_of(material)):
        return True
    stock = node_with(material, NODES)
    if stock is None or stock == shader_of(material):
        return False
    try:
        stack = stack_of(material)
        followed = live_in_nodes(material, stack)
        now = stack_key(stack, followed)
    except LaminaError:
        return False
    if note_of(stock, HELD_VALUES, material) != now or not is_in_working_space(stock):
        return True
    if not methods.holds_values(material.lamina.tier):
        return False
    wanted = wanted_stock(material)
    return note_of(stock, SETTLED, material) != ("" if wanted is None else wanted.key)
