# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of object, and shapes that shading normals do not suit."""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from lamina.addon.blender.versions import node_tree
from lamina.addon.rendering.geometry import plane_mesh, sphere_mesh
from lamina.addon.rendering.settings import add_object

from .case import case
from .files import refusal
from .materials import attribute, become, displaced
from .trial import BLUE, BRUSHED, GLAZE, LIVE, METAL, PAINT, Picture, Surface, Trial

NOISE = 0.03
ROUGHER = 0.01  # a roughness that looks like 0
BRIGHTEST = 1.005  # of 3 x 3 pixels in a white world: nothing reflects more than it receives
TOLERANCE = 0.04  # of a smooth stack beside the same one of roughness ROUGHER


def made(build, smooth: bool = True) -> bpy.types.Mesh:
    """A mesh that `build` fills."""
    form = bmesh.new()
    build(form)
    mesh = bpy.data.meshes.new("mesh")
    form.to_mesh(mesh)
    form.free()
    for polygon in mesh.polygons:
        polygon.use_smooth = smooth
    return mesh


def icosphere(subdivisions: int, flip: bool = False) -> bpy.types.Mesh:
    def build(form):
        bmesh.ops.create_icosphere(form, subdivisions=subdivisions, radius=1.0)
        if flip:
            bmesh.ops.reverse_faces(form, faces=form.faces)

    return made(build)


def cylinder(segments: int, caps: bool = True) -> bpy.types.Mesh:
    """Of radius 1 and height 2, along y, with one end turned a little to the camera."""

    def build(form):
        bmesh.ops.create_cone(form, segments=segments, radius1=1.0, radius2=1.0, depth=2.0, cap_ends=caps)
        bmesh.ops.rotate(form, verts=form.verts, matrix=Matrix.Rotation(0.5 * np.pi - 0.3 * caps, 3, "X"))

    return made(build)


def monkey() -> bpy.types.Mesh:
    """Suzanne, smooth-shaded, who looks at the camera."""

    def build(form):
        bmesh.ops.create_monkey(form)
        bmesh.ops.rotate(form, verts=form.verts, matrix=Matrix.Rotation(-0.5 * np.pi, 3, "X"))

    return made(build)


# shapes


def turned(label: str, told: str, prepare, quick: bool = False) -> None:
    """The ball after `prepare` changed it beside the plain ball, of paint and of brushed metal."""

    def shape(trial):
        for name, surface in (("paint", PAINT), ("metal", METAL)):
            expected = trial.plain(surface)
            item = trial.show(trial.material(surface))
            prepare(item)
            trial.compare_pictures(name, trial.picture(), expected, max(NOISE, trial.within))

    shape.__doc__, shape.__module__ = told, __name__
    case(label, quick=quick, osl_off=True)(shape)


def _scale(factor: float):
    def prepare(item):
        item.scale = (factor,) * 3
        camera = bpy.context.scene.camera
        camera.data.ortho_scale *= factor
        camera.location *= factor
        camera.data.clip_start, camera.data.clip_end = 0.1 * min(factor, 1.0), 100.0 * max(factor, 1.0)

    return prepare


def _mirror(item):
    item.scale.x = -1.0


def _flip(item):
    item.data.flip_normals()


def _subdivide(item):
    item.modifiers.new("Subdivision", "SUBSURF").levels = 1


turned("scaled to a ten-thousandth", "A ball and its camera, 1e-4 of the size: the same picture.", _scale(1e-4))
turned("scaled ten-thousandfold", "A ball and its camera, 1e4 of the size: the same picture.", _scale(1e4))
turned("negative scale", "A ball mirrored by its scale: the same picture.", _mirror, quick=True)
turned("flipped normals", "A ball with its faces inside out: the same picture.", _flip)
turned("subdivided by a modifier", "A ball with a subdivision modifier: the same picture.", _subdivide)


@case("negative scale, brushed metal", quick=False, osl_off=True)
def mirrored_brushed(trial):
    """Mirrored brushed metal: as bright as upright, to 5 %."""
    expected = trial.plain(BRUSHED)
    _mirror(trial.show(trial.material(BRUSHED)))
    trial.compare("mean", trial.picture().mean, expected.mean, 0.05)


def furnace(trial: Trial, surface: Surface, mesh: bpy.types.Mesh | None = None, bump: float = 0.0, osl: bool | None = None, samples: int = 64) -> Picture:
    """A mesh in a white world, (32, 32), with a bump by the displacement socket."""
    trial.stage(32, samples, max_bounces=1, furnace=True)
    material = trial.material(surface)
    if bump:
        displaced(trial, material, "BUMP", bump)
    trial.show(material, mesh() if mesh else None)
    return trial.picture(osl=osl)


@case("brushed metal without UVs", quick=False, osl_off=True)
def no_uv(trial):
    """An icosphere without a UV map in a white world: as bright as one with it, to 5 %, and not black anywhere. Which way it is brushed is Blender's choice."""
    expected = furnace(trial, BRUSHED)
    picture = furnace(trial, BRUSHED, lambda: icosphere(5))
    trial.compare("mean", picture.mean, expected.mean, 0.05)
    trial.require("nowhere black", picture.pixels.max(axis=1).min() > 0.01)


def brightest(picture: Picture) -> float:
    """The largest mean of 3 x 3 pixels that the object covers."""
    rgb, covered = picture.passed("Combined"), picture.covered
    rows, columns = (side - 2 for side in covered.shape)
    near = [(slice(i, i + rows), slice(j, j + columns)) for i in range(3) for j in range(3)]
    inside = np.all([covered[part] for part in near], axis=0)
    return float(np.mean([rgb[part] for part in near], axis=0)[inside].max())


SHAPES = {
    "16-sided cylinder": (lambda: cylinder(16), 0.0),
    "Suzanne": (monkey, 0.0),
    "bump .3": (None, 0.3),
    "bump 1": (None, 1.0),
}


def _smooth_case(label: str, mesh, bump: float) -> None:
    @case(f"exactly smooth glaze, {label}, smooth-shaded", quick=False, osl_off=True)
    def smooth(trial):
        """In a white world beside the same surface of roughness .01; and no 3 x 3 pixels above what they receive."""
        got = furnace(trial, GLAZE, mesh, bump)
        bright = brightest(furnace(trial, GLAZE, mesh, bump, samples=256))
        expected = furnace(trial, GLAZE.with_roughness(ROUGHER), mesh, bump, osl=True)
        trial.compare("mean", got.mean, expected.mean, max(TOLERANCE, trial.within))
        trial.require(f"brightest 3 x 3 pixels {bright:.3f}, at most {BRIGHTEST}", bright <= BRIGHTEST)


for _label, (_mesh, _bump) in SHAPES.items():
    _smooth_case(_label, _mesh, _bump)


@case("low-poly ball, rough paint", osl_off=True)
def low_poly(trial):
    """A smooth-shaded icosphere of 80 faces in a white world: as bright as the fine ball, to 8 %, and no pixels above what they receive."""
    expected = furnace(trial, PAINT, osl=True).mean
    got = furnace(trial, PAINT, lambda: icosphere(2))
    trial.compare("mean", got.mean, expected, 0.08)
    trial.require(f"brightest 3 x 3 pixels {brightest(got):.3f}", brightest(got) <= BRIGHTEST)


@case("terminator of a low-poly ball", quick=False, osl_off=True)
def terminator(trial):
    """A sun from the side on an icosphere of 320 faces: as bright as the fine ball, to 5 %."""

    def lit(mesh) -> np.ndarray:
        trial.stage().world = None
        bpy.data.objects["Sun"].rotation_euler = (0.0, 1.2, 0.0)
        trial.show(trial.material(), mesh())
        return trial.picture().passed("Combined").mean(axis=(0, 1))

    osl, trial.osl = trial.osl, True
    expected = lit(lambda: icosphere(6))
    trial.osl = osl
    trial.compare("mean", lit(lambda: icosphere(3)), expected, 0.05)


@case("inside a glass ball", quick=False, osl_off=True)
def in_glass(trial):
    """A small ball in the middle of a glass one of index 1 (and so unseen): its picture without the glass."""

    def shown(glass: bool) -> np.ndarray:
        trial.stage(samples=64, max_bounces=12)
        trial.show(trial.material()).scale = (0.5,) * 3
        if glass:
            clear = bpy.data.materials.new("glass")
            tree = node_tree(clear)
            shader = tree.nodes.new("ShaderNodeBsdfGlass")
            shader.inputs["IOR"].default_value, shader.inputs["Roughness"].default_value = 1.0, 0.0
            tree.links.new(shader.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
            trial.show(clear, name="glass").visible_shadow = False
            bpy.context.scene.cycles.transmission_bounces = 12
        picture = trial.picture(osl=None if glass else True)
        return picture.passed("Combined")[18:30, 18:30].mean(axis=(0, 1))

    trial.compare("middle", shown(True), shown(False), max(0.05, trial.within))


# kinds of objects


def _curves(trial: Trial, surface: Surface, shape: str) -> np.ndarray:
    scene = trial.stage(samples=32, furnace=True)
    strands = bpy.data.hair_curves.new("hair")
    strands.add_curves([8] * 5)
    places = np.zeros((5, 8, 3), np.float32)
    places[..., 0] = (np.arange(5)[:, None] - 2.0) * 0.44
    places[..., 1] = np.linspace(-2.0, 2.0, 8)
    strands.attributes["position"].data.foreach_set("vector", places.ravel())
    radius = strands.attributes.get("radius") or strands.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.full(40, 0.2, np.float32))
    scene.cycles_curves.shape = shape
    strands.materials.append(trial.material(surface))
    add_object(scene, "hair", strands)
    return trial.picture().mean


def _cylinders(trial: Trial, surface: Surface) -> np.ndarray:
    trial.stage(samples=32, furnace=True)
    material = trial.material(surface)
    for i in range(5):
        item = trial.show(material, cylinder(64, caps=False), f"cylinder {i}")
        item.scale, item.location.x = (0.2, 2.0, 0.2), (i - 2.0) * 0.44
    return trial.picture(osl=True).mean


def _hair_case(label: str, shape: str, surface: Surface, name: str) -> None:
    flat = "ribbons are flat, so strands reflect less into each other than round ones" if shape == "RIBBONS" else ""

    @case(f"hair as {label}, {name}", quick=name == "paint", osl_off=True, limit=flat)
    def hair(trial):
        """Hair curves in a white world beside cylinders of a mesh."""
        trial.compare("mean", _curves(trial, surface, shape), _cylinders(trial, surface), max(0.04, trial.within))


for _label, _shape in (("3D curves", "THICK"), ("ribbons", "RIBBONS")):
    for _name, _surface in (("paint", PAINT), ("metal", METAL)):
        _hair_case(_label, _shape, _surface, _name)


def with_nodes(build) -> bpy.types.Object:
    """An object whose geometry nodes `build(group)` fills; it returns the socket that goes out."""
    group = bpy.data.node_groups.new("nodes", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    group.links.new(build(group), group.nodes.new("NodeGroupOutput").inputs[0])
    item = add_object(bpy.context.scene, "item", bpy.data.meshes.new("empty"))
    item.modifiers.new("nodes", "NODES").node_group = group
    return item


def _set_material(group, geometry, material):
    node = group.nodes.new("GeometryNodeSetMaterial")
    node.inputs["Material"].default_value = material
    group.links.new(geometry, node.inputs["Geometry"])
    return node.outputs[0]


def _ball_of(group):
    ball, smooth = group.nodes.new("GeometryNodeMeshUVSphere"), group.nodes.new("GeometryNodeSetShadeSmooth")
    ball.inputs["Segments"].default_value, ball.inputs["Rings"].default_value = 64, 32
    group.links.new(ball.outputs["Mesh"], smooth.inputs[0])
    return smooth.outputs[0]


@case("point cloud", osl_off=True)
def points(trial):
    """One point of radius 1, by geometry nodes: the ball's picture."""
    expected = trial.plain()
    material = trial.material()

    def build(group):
        node = group.nodes.new("GeometryNodePoints")
        node.inputs["Count"].default_value, node.inputs["Radius"].default_value = 1, 1.0
        return _set_material(group, node.outputs[0], material)

    with_nodes(build)
    trial.compare_pictures("point", trial.picture(), expected, max(NOISE, trial.within))


@case("geometry nodes, Set Material", osl_off=True)
def set_material(trial):
    """A ball made by geometry nodes that get the material there."""
    expected = trial.plain()
    material = trial.material()
    with_nodes(lambda group: _set_material(group, _ball_of(group), material))
    trial.compare_pictures("ball", trial.picture(), expected, max(NOISE, trial.within))


@case("instances with an attribute of their own", osl_off=True)
def instancer(trial):
    """An instance's named color in the surface's color: the surface of that color."""
    expected = trial.plain(PAINT.with_color(BLUE))
    material = trial.material()
    material.node_tree.links.new(attribute("hue", "INSTANCER")(material.node_tree), trial.socket(material, "color"))
    trial.settle(material)

    def build(group):
        place, spread, store = (group.nodes.new(f"GeometryNode{n}") for n in ("Points", "InstanceOnPoints", "StoreNamedAttribute"))
        place.inputs["Count"].default_value = 1
        store.data_type, store.domain = "FLOAT_COLOR", "INSTANCE"
        store.inputs["Name"].default_value = "hue"
        next(s for s in store.inputs if s.name == "Value" and s.enabled).default_value = (*BLUE, 1.0)
        group.links.new(place.outputs[0], spread.inputs["Points"])
        group.links.new(_set_material(group, _ball_of(group), material), spread.inputs["Instance"])
        group.links.new(spread.outputs[0], store.inputs["Geometry"])
        return store.outputs[0]

    with_nodes(build)
    trial.excuse_textures(material)
    trial.compare_pictures("instance", trial.picture(), expected, LIVE)


@case("instances on vertices", osl_off=True)
def instances(trial):
    """A parent's vertex instances its child, the ball."""
    expected = trial.plain()
    ball = trial.show(trial.material())
    parent = add_object(bpy.context.scene, "parent", made(lambda form: form.verts.new((0.0, 0.0, 0.0))))
    parent.instance_type, ball.parent = "VERTS", parent
    trial.compare_pictures("instance", trial.picture(), expected, max(NOISE, trial.within))


@case("several material slots", quick=False, osl_off=True)
def slots(trial):
    """A second slot on half of a plane: each half as a plane of its own material."""

    def plane(surfaces, osl=None):
        trial.stage(32)
        mesh = bpy.data.meshes.new("plane")
        mesh.from_pydata([(-1, -1, 0), (0, -1, 0), (1, -1, 0), (-1, 1, 0), (0, 1, 0), (1, 1, 0)], [], [(0, 1, 4, 3), (1, 2, 5, 4)])
        for surface in surfaces[1:]:
            extra = trial.material(surface, "second")
        trial.show(trial.material(surfaces[0]), mesh)
        if surfaces[1:]:
            mesh.materials.append(extra)
            mesh.polygons[1].material_index = 1
        bpy.context.scene.camera.data.ortho_scale = 1.8
        rgb = trial.picture(osl=osl).passed("Combined")
        return np.array([rgb[:, :15].mean(axis=(0, 1)), rgb[:, 17:].mean(axis=(0, 1))])

    left, right = plane([PAINT], True)[0], plane([METAL], True)[1]
    trial.compare("left and right", plane([PAINT, METAL]), [left, right], max(NOISE, trial.within))


def _object_case(label: str, build, told: str) -> None:
    def kind(trial):
        trial.stage()
        item = build()
        item.data.materials.append(trial.material())
        got = trial.picture()
        shape = bpy.data.meshes.new_from_object(item.evaluated_get(bpy.context.evaluated_depsgraph_get()))
        item.hide_render = True
        trial.show(item.data.materials[0], shape, "mesh")
        trial.compare_pictures("as it is", got, trial.picture(osl=True), max(NOISE, trial.within))

    kind.__doc__, kind.__module__ = told, __name__
    case(label, quick=False, osl_off=True)(kind)


def _bevelled() -> bpy.types.Object:
    curve = bpy.data.curves.new("curve", "CURVE")
    curve.dimensions, curve.bevel_depth = "3D", 0.4
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    for point, x in zip(spline.points, (-0.8, 0.8)):
        point.co = (x, 0.0, 0.0, 1.0)
    return add_object(bpy.context.scene, "curve", curve)


def _text() -> bpy.types.Object:
    text = bpy.data.curves.new("text", "FONT")
    text.body, text.size, text.align_x, text.align_y, text.extrude = "OO", 1.6, "CENTER", "CENTER", 0.1
    return add_object(bpy.context.scene, "text", text)


def _meta() -> bpy.types.Object:
    meta = bpy.data.metaballs.new("meta")
    meta.render_resolution = meta.resolution = 0.1
    meta.elements.new().radius = 1.5
    return add_object(bpy.context.scene, "meta", meta)


_object_case("curve with a bevel", _bevelled, "A bevelled curve beside its mesh.")
_object_case("text", _text, "An extruded text beside its mesh.")
_object_case("metaball", _meta, "A metaball beside its mesh.")


@case("adaptive subdivision", quick=False, osl_off=True)
def adaptive(trial):
    """A ball under adaptive subdivision beside the plain ball."""
    expected = trial.plain()
    scene = bpy.context.scene
    item = trial.show(trial.material(), sphere_mesh("Ball", 64, 32))
    modifier = item.modifiers.new("Subdivision", "SUBSURF")
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    else:
        scene.cycles.feature_set = "EXPERIMENTAL"
        item.cycles.use_adaptive_subdivision = True
    scene.cycles.dicing_rate = 4.0
    trial.compare_pictures("subdivided", trial.picture(), expected, max(NOISE, trial.within))


@case("back of a plane", osl_off=True)
def back_face(trial):
    """A plane seen from behind beside one seen from the front, in a white world."""

    def seen(turn: float, osl=None) -> np.ndarray:
        trial.stage(16, 64, furnace=True).camera.data.ortho_scale = 0.5
        trial.show(trial.material(), plane_mesh("plane", 1.0)).rotation_euler.y = turn
        return trial.picture(osl=osl).mean

    trial.compare("back", seen(np.pi), seen(0.0, True), max(NOISE, trial.within))


def _refused(trial: Trial, what: str) -> None:
    """A preset on the active object is refused with a reason, and leaves engine and materials alone."""
    engine, before = bpy.context.scene.render.engine, len(bpy.data.materials)
    told = refusal(lambda: bpy.ops.lamina.apply_preset(preset="clean_copper"))
    trial.require(f"a preset on a {what} is refused with a reason", bool(told))
    trial.require("engine and materials stay", bpy.context.scene.render.engine == engine and len(bpy.data.materials) == before)
    trial.require("no material became layered", not any(m.lamina.is_layered for m in bpy.data.materials))


@case("preset on a Grease Pencil object", beside=False)
def grease_pencil(trial):
    """A surface cannot show on strokes, so a preset is refused with a reason."""
    bpy.ops.object.grease_pencil_add(type="STROKE")
    _refused(trial, "Grease Pencil object")


@case("preset on a Volume object", beside=False)
def volume_object(trial):
    """A surface cannot show on a Volume object, so a preset is refused with a reason."""
    bpy.ops.object.volume_add()
    _refused(trial, "Volume object")


@case("preset on a mesh with a volume", beside=False, osl_off=True)
def volume_mesh(trial):
    """A material that has only a volume gets a surface: the surface shows, the volume stays, Check finds nothing."""
    expected = trial.plain()
    material = bpy.data.materials.new("subject")
    tree = node_tree(material)
    tree.nodes.remove(Trial.principled(material))
    volume = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(volume.outputs[0], trial.output(material).inputs["Volume"])
    become(trial, material, PAINT)
    trial.show(material)
    trial.require("the volume stays", trial.output(material).inputs["Volume"].is_linked)
    trial.sound(material)
    trial.compare_pictures("surface", trial.picture(), expected, max(NOISE, trial.within))


@case("object without a material, then a preset", quick=False, beside=False)
def no_material(trial):
    """A preset on an object with an empty slot: a material is made, assigned and shows."""
    item = trial.show(None)
    bpy.ops.lamina.apply_preset(preset="glossy_plastic")
    material = item.active_material
    trial.require("a layered material", material is not None and material.lamina.is_layered)
    trial.settle(material)
    trial.sound(material)
    trial.require("a picture that is not black", trial.picture().mean.max() > 0.02)
