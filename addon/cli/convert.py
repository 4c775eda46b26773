# SPDX-License-Identifier: GPL-3.0-or-later
"""Command that converts a stack, or an object's material, to Principled or a surface of MaterialX, and a MaterialX file to a stack."""

from pathlib import Path

from ...reference_py.atomic import require_writable, write_text
from ...reference_py.errors import LaminaError
from ...reference_py.exchange import SUFFIX
from ...reference_py.exchange.materialx import AnyMaterial, load_mtlx
from ...reference_py.exchange.report import shown
from ...reference_py.exchange.targets import TARGETS, convert_to, suffix_of, text_of
from ...reference_py.material.stack import Stack
from ..session import blender, say
from .print_values import load_stack


def convert(options) -> None:
    """Values or a file, and the report on stdout."""
    if options.output:
        require_writable(options.output)
    if Path(options.source).suffix.lower() == SUFFIX:
        _import(options)
        return
    if not options.to:
        raise LaminaError(f"convert {options.source}: give --to {', '.join(TARGETS)}; only a {SUFFIX} file needs none")
    _require_suffix(options.output, suffix_of(options.to))
    stack, notes = _source(options)
    converted = convert_to(options.to, stack)
    text = text_of(options.to, converted, stack.name)
    for name, value in converted.values.items():
        print(f"{name:30} {shown(value)}")
    print(*notes, sep="\n", end="\n" if notes else "")
    _print(converted.report)
    if options.output:
        write_text(options.output, text)
        say("convert")(f"wrote {options.output}")


def _source(options) -> tuple[Stack, list[str]]:
    """The stack to convert, and what its material loses on the way."""
    is_blend = Path(options.source).suffix.lower() == ".blend"
    if is_blend != bool(options.object):
        raise LaminaError("IN.blend and --object NAME go together")
    if not is_blend:
        return load_stack(options.source), []
    if not Path(options.source).is_file():
        raise LaminaError(f"{options.source}: there is no such .blend file")
    with blender(say("convert")):
        import bpy

        from ..blender.blend_files import open_file
        from ..exchange.materialx_import import lost_textures
        from ..material.reading import measured_stack

        open_file(options.source)
        item = bpy.data.objects.get(options.object)
        if item is None:
            raise LaminaError(f"--object {options.object}: {options.source} has {', '.join(o.name for o in bpy.data.objects)[:300] or 'no object'}")
        material = item.active_material
        if material is None or not material.lamina.is_layered:
            raise LaminaError(f"object {item.name}: {'its material ' + material.name if material else 'it'} has no Lamina stack")
        stack = measured_stack(material)
        return stack, lost_textures(material)


def _import(options) -> None:
    if options.to:
        raise LaminaError(f"--to {options.to}: a {SUFFIX} file becomes a stack; leave out --to")
    if not options.output:
        raise LaminaError(f"{options.source}: give -o STACK.json, the stack file to write")
    _require_suffix(options.output, ".json")
    material = _chosen(load_mtlx(options.source), options)
    material, notes = _with_means(material)
    converted = material.to_stack(without=frozenset(material.images))
    print(*notes, sep="\n", end="\n" if notes else "")
    _print(converted.report)
    converted.stack.save(options.output)
    say("convert")(f"wrote {options.output}")


def _with_means(material: AnyMaterial) -> tuple[AnyMaterial, list[str]]:
    """A material with the means of its images as values, as a stack file has no textures, and what no image gave."""
    files = [given for given, image in material.images.items() if image.files and not image.is_normal]
    notes = [f"lost: {given} image {image.file}: there is no such file" for given, image in material.images.items() if not image.files]
    if not files:
        return material, notes
    with blender(say("convert")):
        from ..exchange.image_means import with_means

        material, unread = with_means(material, files)
    return material, [*notes, *(f"lost: {error}" for error in unread)]


def _chosen(materials: list, options):
    """The material that --material names, or the first."""
    names = [material.name for material in materials]
    if options.material and options.material not in names:
        raise LaminaError(f"--material {options.material}: {options.source} has {', '.join(names)[:300]}")
    chosen = materials[names.index(options.material) if options.material else 0]
    if len(materials) > 1:
        say("convert")(f"{chosen.name}, one of {len(materials)} materials; --material takes another: {', '.join(n for n in names if n != chosen.name)[:300]}")
    return chosen


def _print(report) -> None:
    print(*report.lines(), sep="\n")


def _require_suffix(path: str | None, suffix: str) -> None:
    if path and Path(path).suffix.lower() != suffix:
        raise LaminaError(f"-o {path}: unknown ending {Path(path).suffix!r}; choose a name that ends in {suffix}")
