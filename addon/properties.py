# SPDX-License-Identifier: GPL-3.0-or-later
"""Structure of a Lamina material: which layers, in which order, of which kind. Values live in node sockets."""

from collections.abc import Iterator
from contextlib import contextmanager

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, PointerProperty, StringProperty

from ..reference_py.network import DEFAULT_TIER, TIERS
from ..reference_py.schema import SCHEMA, SCHEMA_VERSION, Kind

_quiet = False


@contextmanager
def quietly() -> Iterator[None]:
    """Set properties without regenerating the shader after each of them."""
    global _quiet
    before, _quiet = _quiet, True
    try:
        yield
    finally:
        _quiet = before


def _structure_changed(element, _context) -> None:
    if not _quiet:
        from . import material

        material.structure_changed(element.id_data)


def all_kinds() -> tuple[Kind, ...]:
    return (*SCHEMA.layers.values(), *SCHEMA.bases.values())


def given_choices(kind: Kind) -> list[str]:
    """Names of a kind's alternatives, such as "metal" and "eta+k"."""
    return ["+".join(group) for group in kind.alternatives]


def _enum(choices, label: str, help_text: str, default: str | None = None) -> EnumProperty:
    items = [(c, c.replace("_", " ").replace("+", " and ").capitalize(), "") for c in choices]
    return EnumProperty(name=label, description=help_text, items=items, default=default or choices[0], update=_structure_changed)


def _structure_annotations() -> dict:
    """One enum per structural parameter of the schema, and one that says which alternative is given."""
    annotations = {p.name: _enum(p.choices, p.label, p.help, p.default) for kind in all_kinds() for p in kind.structure}
    given = [choice for kind in all_kinds() for choice in given_choices(kind)]
    annotations["given"] = _enum(given, "Given By", "Which parameters describe the metal")
    annotations["kind"] = _enum([k.name for k in all_kinds()], "Kind", "What this layer or base is")
    return annotations


class LaminaElement(bpy.types.PropertyGroup):
    """A layer or the base. `name` is the user's label, `node` the name of its group node, which never changes."""

    node: StringProperty()
    visible: BoolProperty(
        name="Visible", description="Let this layer take part in the material", default=True, update=_structure_changed
    )
    unknown: StringProperty(description="JSON of the keys that this version does not know")


LaminaElement.__annotations__.update(_structure_annotations())


class LaminaMaterial(bpy.types.PropertyGroup):
    """Structure of one material; empty `base.node` means that it is not a Lamina material."""

    layers: CollectionProperty(type=LaminaElement)
    active_layer: IntProperty(name="Active Layer")
    base: PointerProperty(type=LaminaElement)
    tier: EnumProperty(
        name="Tier",
        description="How the stack is told to Cycles",
        items=[(name, name.replace("_", " ").title(), "") for name in TIERS],
        default=DEFAULT_TIER,
        update=_structure_changed,
    )
    stack_name: StringProperty(name="Name", description="Name of the stack")
    source: StringProperty(name="Source", description="Where the stack's numbers come from")
    unknown: StringProperty(description="JSON of the keys that this version does not know")
    schema_version: IntProperty(default=SCHEMA_VERSION)
    shader_node: StringProperty(description="Name of the Script node")

    @property
    def is_layered(self) -> bool:
        return bool(self.base.node)


CLASSES = (LaminaElement, LaminaMaterial)
