# SPDX-License-Identifier: GPL-3.0-or-later
"""Every string of Lamina that Blender shows and translates. Presets' names and sources are names and citations: they stay."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import bpy

import lamina
from lamina.addon import registration
from lamina.addon.check import check
from lamina.addon.library.preset_catalogues import CATALOGUES, OWN
from lamina.addon.material import seen_color
from lamina.addon.material.mask_groups import BAKED, USE_BAKED
from lamina.addon.material.properties import choice_label
from lamina.addon.ui.value_notes import UNITS
from lamina.reference_py.material import ready_layers
from lamina.reference_py.material.masks import GENERATORS
from lamina.reference_py.material.schema import SCHEMA

ADDON = Path(lamina.__file__).parent / "addon"
REFERENCE = ADDON.parent / "reference_py"
# Folders whose sources show text in Blender's window.
_SHOWN = ("check", "exchange", "jobs", "library", "material", "operators", "ui")
# Those whose errors come to an operator's report or the panel. Not so a command line's, and of the reference models, spectra and writers of tables.
TELLING = {
    ADDON: (*_SHOWN, "blender", "rendering", "shader"),
    REFERENCE: ("", "exchange", "fit", "fit/readers", "lobes", "lobes/methods", "material", "material/presets", "material/ready_layers", "optics"),
}
# In these folders, what scripts call and no operator does.
_NOT_TOLD = {"api", "distribution", "frame", "live_grid", "measure", "microfacet", "microsurface", "registry", "sheet", "spectral", "truth"}
_SENTENCES = {"LaminaError", "Sentence"}
# What makes a line of a conversion's report, or of why one is made.
_REPORTING = {"Loss", "_say", "_lose", "lost_if", "noted", "_Neither", "Unread", "_stronger"}
_TRANSLATING = {"iface_", "rpt_", "tip_", "data_", "translated"}


def strings() -> set[str]:
    """All of them."""
    found = {
        *_of_schema(),
        *_of_classes(),
        *_of_checks(),
        *CATALOGUES,
        OWN,
        *(BAKED, USE_BAKED),
        *(group.title() for group in ready_layers.GROUPS),
        *UNITS.values(),
    }
    seen = bpy.types.ShaderNodeGroup.bl_rna.properties[seen_color.NAME]
    found |= {seen.name, seen.description}
    for folder in _SHOWN:
        for path in sorted((ADDON / folder).glob("*.py")):
            found |= set(_of_source(path))
    found |= {template for path in telling() for template, _ in told(path) if template is not None}
    return {text for text in found if any(c.isalpha() for c in re.sub(r"\{\w+[^}]*\}", "", text))}


def telling() -> list[Path]:
    """The sources whose errors an artist may read."""
    folders = [root / name for root, names in TELLING.items() for name in names]
    return sorted(path for folder in folders for path in folder.glob("*.py") if path.stem not in _NOT_TOLD)


def told(path: Path) -> Iterator[tuple[str | None, ast.Call]]:
    """Every error and sentence that a source makes, with its template; None where that is no literal."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in _SENTENCES and node.args:
            given = node.args[0]
            yield (given.value if isinstance(given, ast.Constant) else None), node


def of_reports() -> set[str]:
    """What conversions report, and fits in the text that they leave."""
    sources = [path for folder in (REFERENCE / "exchange", ADDON / "exchange", REFERENCE / "fit") for path in folder.glob("*.py")]
    return {template for path in sources for template, _ in told(path) if template is not None}


def reported() -> Iterator[tuple[ast.expr, str]]:
    """What a conversion's report is told with, and where that is: the last argument of all that makes a line of it."""
    for path in sorted([*(REFERENCE / "exchange").glob("*.py"), *(ADDON / "exchange").glob("*.py"), ADDON / "material" / "principled_node.py"]):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) in _REPORTING and node.args:
                yield node.args[-1], f"{path.name}:{node.lineno}"


def _of_schema() -> Iterator[str]:
    for kind in (*SCHEMA.layers.values(), *SCHEMA.bases.values()):
        for thing in (kind, *kind.features):
            yield from (thing.label, thing.help)
        for parameter in kind.all_parameters:
            yield from (parameter.label, parameter.tooltip, parameter.unit)
        yield from (choice_label(c) for p in kind.structure for c in p.choices)
    for generator in GENERATORS.values():
        for thing in (generator, *generator.parameters):
            yield from (thing.label, thing.help)


def _of_classes() -> Iterator[str]:
    for cls in registration.CLASSES:
        yield from (getattr(cls, name, "") for name in ("bl_label", "bl_description"))
        for prop in shown_properties(cls):
            yield from (prop.name, prop.description)
            if prop.type == "ENUM" and prop.identifier != "preset":
                yield from (text for item in prop.enum_items for text in (item.name, item.description))


def shown_properties(cls) -> list:
    """Those that Lamina gave a registered class and that have a name: others are never shown."""
    rna = getattr(bpy.types, cls.__name__, cls).bl_rna if issubclass(cls, (bpy.types.PropertyGroup, bpy.types.AddonPreferences)) else None
    if rna is None and issubclass(cls, bpy.types.Operator):
        group, name = cls.bl_idname.split(".")
        rna = getattr(getattr(bpy.ops, group), name).get_rna_type()
    given = [prop for prop in rna.properties if prop.identifier in _annotated(cls)] if rna else []
    # Blender's own `name` stands beside that of a property group.
    return [prop for prop in given if prop.name != prop.identifier and not prop.description.startswith("Unique name used in the code")]


def _annotated(cls) -> set[str]:
    """The properties that Lamina gave a class: those of Blender's mixins are Blender's to translate."""
    ours = [base for base in cls.__mro__ if base.__module__.startswith("lamina.")]
    return {name for base in ours for name in getattr(base, "__annotations__", {})}


def _of_checks() -> Iterator[str]:
    for _level, template, mending in check.CODES.values():
        yield from (template, mending)


def _of_source(path: Path) -> Iterator[str]:
    """Literals that a source hands to a translating function, and those that layouts show."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        name = getattr(node.func, "id", getattr(node.func, "attr", ""))
        shown = list(node.args[:1]) if name in _TRANSLATING else []
        shown += [k.value for k in node.keywords if k.arg == "text"] + (list(node.args[1:2]) if name == "draw_fact" else [])
        for value in shown:
            yield from _literals(value)


def _literals(value: ast.expr) -> Iterator[str]:
    if isinstance(value, ast.Constant) and isinstance(value.value, str):
        yield value.value
    elif isinstance(value, ast.IfExp):
        yield from (*_literals(value.body), *_literals(value.orelse))
