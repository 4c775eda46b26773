# SPDX-License-Identifier: GPL-3.0-or-later
"""Structure of a Lamina material: which layers, in which order, of which kind. Values live in node sockets.

No property here can be animated: an f-curve moves a property without calling its update function, so the shader
would not follow.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty, StringProperty

from ...reference_py.errors import LaminaError, Sentence
from ...reference_py.material.qualities import DEFAULT_METHOD, DEFAULT_TOLERANCE, QUALITIES
from ...reference_py.material.schema import SCHEMA, SCHEMA_VERSION, Feature, Kind, Schema
from .backend import AUTO, BACKENDS, DEFAULT_BACKEND, NODES, OSL
from .selection import select_layer, selected_layer

_NOT_ANIMATABLE: set[str] = set()
_ACRONYMS = {"ggx": "GGX"}
_BACKEND_LABELS = {AUTO: "Automatic", OSL: "OSL", NODES: "Stock Nodes"}
# The methods as artists know them.
QUALITY_LABELS = {"weidlich_wilkie": "Paper of 2007", "analytic": "Preview", "baked": "Final", "auto": "Automatic"}

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


def _update(name: str) -> Callable:
    """An update function that tells which property was set."""

    def update(group, _context) -> None:
        if not _quiet:
            from .material import structure_changed  # which needs these properties itself

            structure_changed(group, name)

    return update


def choice_label(choice: str) -> str:
    """How a choice of the schema reads in a menu."""
    return _ACRONYMS.get(choice, choice.replace("_", " ").title())


def _enum(name: str, items: list[tuple[str, str]], label: str, help_text: str, default: str) -> EnumProperty:
    return EnumProperty(
        name=label,
        description=help_text,
        items=[(item, text, "") for item, text in items],
        default=default,
        options=_NOT_ANIMATABLE,
        update=_update(name),
    )


def structure_annotations(schema: Schema) -> dict:
    """One enum per structural parameter of the schema, one switch per feature, and `given`, the alternative that describes a kind."""
    kinds = (*schema.layers.values(), *schema.bases.values())
    annotations = {p.name: _enum(p.name, [(c, choice_label(c)) for c in p.choices], p.label, p.tooltip, p.default) for kind in kinds for p in kind.structure}
    for feature in {f.name: f for kind in kinds for f in kind.features}.values():
        name = f"use_{feature.name}"
        annotations[name] = BoolProperty(name=feature.label, description=feature.help, options=_NOT_ANIMATABLE, update=_update(name))
        annotations |= _given(f"given_{feature.name}", [feature])
    annotations |= _given("given", kinds)
    return annotations


def _given(name: str, owners: Iterable[Kind | Feature]) -> dict:
    given = [(choice, owner.given_label(choice)) for owner in owners for choice in owner.given_choices]
    return {name: _enum(name, given, "Given By", "What describes this material", given[0][0])} if given else {}


class LaminaElement(bpy.types.PropertyGroup):
    """A layer or the base. `name` is the user's label, `node` the name of its group node, which never changes."""

    name: StringProperty(name="Name", description="Name of this layer; double-click to change it", update=_update("name"))
    node: StringProperty()
    kind: StringProperty(description="A layer or base kind of the schema")
    visible: BoolProperty(
        name="Visible",
        description="Let this layer take part in the material",
        default=True,
        options=_NOT_ANIMATABLE,
        update=_update("visible"),
    )
    was_given: StringProperty(description="The value of `given` that the sockets were last written for")
    unknown: StringProperty(description="JSON of the keys that this version does not know")


LaminaElement.__annotations__.update(structure_annotations(SCHEMA))


def quality_property(**options) -> EnumProperty:
    """The choice of a quality, of a material or of new ones."""
    return EnumProperty(
        name="Quality",
        description="How exactly the layers are rendered, and at what cost",
        items=[(name, QUALITY_LABELS[name], text) for name, text in QUALITIES.items()],
        default=DEFAULT_METHOD,
        **options,
    )


def backend_property(**options) -> EnumProperty:
    """The choice of a backend, of a material or of new ones."""
    return EnumProperty(
        name="Backend",
        description="What the shader is made of",
        items=[(name, _BACKEND_LABELS[name], text) for name, text in BACKENDS.items()],
        default=DEFAULT_BACKEND,
        **options,
    )


class LaminaMaterial(bpy.types.PropertyGroup):
    """Structure of one material; empty `base.node` means that it is not a Lamina material."""

    layers: CollectionProperty(type=LaminaElement)
    solo: StringProperty(description="Node of the layer that alone is shown over the base; empty where all visible ones are")
    base: PointerProperty(type=LaminaElement)
    tier: quality_property(options=_NOT_ANIMATABLE, update=_update("tier"))
    backend: backend_property(options=_NOT_ANIMATABLE, update=_update("backend"))
    tolerance: FloatProperty(
        name="Tolerance",
        description="The largest error that the quality Automatic may show, as a share of the reflected light: 2 % is hard to see",
        min=0.1,
        max=100.0,
        default=100.0 * DEFAULT_TOLERANCE,
        subtype="PERCENTAGE",
        options=_NOT_ANIMATABLE,
        update=_update("tolerance"),
    )
    stack_name: StringProperty(name="Name", description="Name of the stack", update=_update("stack_name"))
    source: StringProperty(name="Source", description="Where the stack's numbers come from")
    unknown: StringProperty(description="JSON of the keys that this version does not know")
    schema_version: IntProperty(default=SCHEMA_VERSION)
    shader_node: StringProperty(description="Of files of schema 1 and 2: name of the node that is the shader")
    told: StringProperty(description="Of files of schema 1 and 2: hash of the values that the shader holds; empty where it reads them")
    settled: StringProperty(description="Of files of schema 1 and 2: what the shader was computed for, in tiers that compute first; empty until it is done")
    stamp: StringProperty(description="Which copy of this structure the node tree has, see `record`")
    note: StringProperty(description="What was chosen, and why")
    error: FloatProperty(default=-1.0, description="Estimated error of what was chosen, in percent; negative where there is no estimate")
    handed: StringProperty(description="Hash of the values and links that exporters find; empty until the base color is solved for them")
    hand_over_error: FloatProperty(default=-1.0, description="Error of what exporters find, in percent; negative until it is known")
    viewport: FloatVectorProperty(size=5, description="Viewport color, metallic and roughness as they were set last")
    cost: FloatProperty(description="Estimated render time, over that of a plain glossy node; 0 before the first shader")
    lobe_count: IntProperty(description="Lobes of the generated shader")
    problem: StringProperty(description="Why the shader does not follow the structure, in English", options={"SKIP_SAVE"})
    packed_problem: StringProperty(description="JSON of that sentence with its words apart; older versions write none", options={"SKIP_SAVE"})

    @property
    def active_layer(self) -> int:
        """Index of the layer that is shown below the list, see `selection`."""
        return selected_layer(self.id_data)

    @active_layer.setter
    def active_layer(self, index: int) -> None:
        select_layer(self.id_data, index)

    @property
    def problem_sentence(self) -> Sentence:
        """Why the shader does not follow the structure, to be told in any language; empty if it does. What has no words apart is told as it is."""
        with suppress(ValueError, KeyError, TypeError, AttributeError):
            sentence = Sentence.unpacked(json.loads(self.packed_problem))
            if sentence == self.problem:  # an older version changes that alone
                return sentence
        return Sentence(self.problem)

    def keep_problem(self, error: LaminaError | None) -> None:
        """Keep why the shader does not follow the structure; None where it does."""
        self.problem = str(error) if error else ""
        self.packed_problem = json.dumps(error.sentence.packed()) if error else ""

    @property
    def is_layered(self) -> bool:
        return bool(self.base.node)

    def shows(self, layer: LaminaElement) -> bool:
        """Whether a layer takes part in the material: it is visible, and none or itself is soloed."""
        return layer.node == self.solo if self.solo else layer.visible

    @property
    def shown_layers(self) -> list[LaminaElement]:
        """The layers that take part in the material, from the top."""
        return [layer for layer in self.layers if self.shows(layer)]


CLASSES = (LaminaElement, LaminaMaterial)
