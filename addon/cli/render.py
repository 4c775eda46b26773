# SPDX-License-Identifier: GPL-3.0-or-later
"""Commands that render a stack or put it into a .blend file."""

import shutil
import tempfile
from pathlib import Path

from ...reference_py.atomic import replacing, require_writable
from ...reference_py.errors import LaminaError
from ...reference_py.lobes.cache import require_writable as require_writable_cache
from ...reference_py.lobes.methods import DEFAULT_METHOD, method_of
from ..material.backend import branches_here, notice
from ..material.limits import require_shader
from ..session import blender, say, tenths
from .print_values import load_stack, print_albedo, view_angles

SUN_THETA_DEG = 45.0
SIZE = {"sphere": 256, "ball": 256, "furnace": 32}


def render(options) -> None:
    """One stack in one scene, to a picture or, for the furnace, to numbers."""
    stack, tier = load_stack(options.stack), _tier(options)
    _refuse_what_has_no_effect(options)
    require_shader(stack, options.backend)
    options.size = options.size or SIZE[options.scene]
    if options.scene == "furnace":
        _furnace(options, stack, tier)
        return
    if not options.output:
        raise LaminaError(f"--scene {options.scene} needs -o FILE, a picture that ends in .exr or .png")
    output = Path(options.output)
    if output.suffix.lower() not in (".exr", ".png"):
        raise LaminaError(f"{output}: unknown picture format {output.suffix!r}; choose .exr or .png")
    require_writable(output)
    report = say("render")
    report(f"{stack.name or options.stack} in scene {options.scene}")
    with blender(report):
        require_writable_cache(report)
        material = _material(stack, tier, options.backend, report)
        (_sphere if options.scene == "sphere" else _ball)(material, output, options)
    report(f"wrote {output}")


def _refuse_what_has_no_effect(options) -> None:
    if options.scene == "furnace" and options.output:
        raise LaminaError(f"--scene furnace prints numbers and writes no picture: leave out -o {options.output}, or choose sphere or ball")
    if options.scene != "furnace" and (options.json or options.theta):
        given = "--json" if options.json else "--theta"
        raise LaminaError(f"{given} goes with --scene furnace, not with {options.scene}")


def _tier(options) -> str:
    return method_of(options.tier or DEFAULT_METHOD).name


def _material(stack, tier, backend, report):
    import bpy

    from ..material.material import apply_stack

    material = bpy.data.materials.new(stack.name or "Lamina")
    apply_stack(material, stack, tier, backend, settle=True, progress=tenths(report))
    if material.lamina.note:
        report(f"tier {tier}: {material.lamina.note}")
    if sentence := notice(backend):
        report(f"the material is {sentence}")
    return material


def _furnace(options, stack, tier) -> None:
    theta = view_angles(options.theta or [0.0, 30.0, 60.0])
    report = say("render")
    report(f"{stack.name or options.stack} in a white furnace, {len(theta)} angles")
    with blender(report):
        from ..rendering.measure import render_furnace

        value, stderr = render_furnace(_material(stack, tier, options.backend, report), theta, options.samples, options.size)
    report("measured")
    print_albedo(f"cycles:{tier}", theta, value, stderr, options.json)


def _sphere(material, output: Path, options) -> None:
    """A sphere in the sun of irradiance pi: a white Lambert sphere shows the cosine."""
    import numpy as np

    from ..blender.images import write_exr, write_png
    from ..rendering.measure import render_sun_sphere

    # a measurement has one sample; more samples are a finer picture, averaged down
    fine = max(int(round(options.samples**0.5)), 1)
    radiance = np.pi * render_sun_sphere(material, SUN_THETA_DEG, options.size * fine)["radiance"]
    radiance = radiance.reshape(options.size, fine, options.size, fine, 3).mean(axis=(1, 3))
    if output.suffix.lower() == ".exr":
        write_exr(output, {c: radiance[..., i] for i, c in enumerate("RGB")})
        return
    encoded = np.where(radiance <= 0.0031308, 12.92 * radiance, 1.055 * np.maximum(radiance, 1e-9) ** (1 / 2.4) - 0.055)
    write_png(output, (encoded.clip(0.0, 1.0) * 255.0 + 0.5).astype(np.uint8))


def _ball(material, output: Path, options) -> None:
    from ..rendering.settings import render_to
    from ..rendering.studio import build_ball_scene

    studio = build_ball_scene(material, options.size, options.samples)
    try:
        if output.suffix.lower() == ".exr":
            image = studio.scene.render.image_settings
            image.file_format, image.color_depth = "OPEN_EXR", "32"
        # only a finished picture goes beside the user's files
        with tempfile.TemporaryDirectory() as folder:
            picture = Path(folder, output.name)
            render_to(studio.scene, picture)
            with replacing(output) as temporary:
                shutil.copyfile(picture, temporary)
    finally:
        studio.remove()


def apply(options) -> None:
    """Open IN.blend, give the object a new material with the stack, and write OUT.blend."""
    stack, tier = load_stack(options.stack), _tier(options)
    require_shader(stack, options.backend)
    source, output = Path(options.input), Path(options.output)
    if output.suffix.lower() != ".blend":
        raise LaminaError(f"{output}: apply writes a Blender file; choose a name that ends in .blend")
    if not source.is_file():
        raise LaminaError(f"{source}: there is no such .blend file")
    require_writable(output)
    report = say("apply")
    report(f"open {source}")
    with blender(report):
        import bpy

        from ..blender.blend_files import open_file, refuse_missing, save_copy
        from ..blender.dependencies import missing
        from ..check.check import find
        from ..material.holders import give, holder_named, require_own, sharing, slots_of
        from ..material.material import make_renderable

        branches_here(options.backend)
        require_writable_cache(report)
        open_file(source)
        refuse_missing(source.name, missing(), options.allow_missing, report)
        try:
            target = holder_named(bpy.data.objects, options.object)
            require_own(target, options.single_user or options.object_level)
            slots = slots_of(target, options.slot)
        except LaminaError as error:
            raise LaminaError(f"{source}: {error}") from None
        material = _material(stack, tier, options.backend, report)
        notices = make_renderable(material, bpy.context.scene)
        if options.single_user:
            target.data = target.data.copy()
        elif not options.object_level and (others := sharing(target)):
            shown = ", ".join(others[:3]) + (f" and {len(others) - 3} more" if len(others) > 3 else "")
            notices.append(f"{shown} share the mesh {target.data.name} and show it too; --single-user or --object-level gives it to {target.name} alone")
        give(target, material, slots, options.object_level)
        notices += [finding.text() for finding in find(material, bpy.context.scene, bpy.context.preferences)]
        save_copy(output)
    for sentence in notices:
        report(sentence)
    report(f"wrote {output}: {options.object} has {stack.name or options.stack}, tier {tier}")
