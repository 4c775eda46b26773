# SPDX-License-Identifier: GPL-3.0-or-later
"""The files and objects that a render of the open .blend reads, and what is missing of them and of linked data.

A farm's bundle has a copy of this file along. So it needs nothing else of Lamina.
"""

import os
import re
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import bpy

_TILE = re.compile(r"<UDIM>|<UVTILE>")
# The number of a frame, in a file's name without its ending, which may have digits too (.jp2).
_NUMBER = re.compile(r"\d+(?=\D*$)")
_SHOWN = 5


def files_read() -> list[str]:
    """Absolute paths, sorted: libraries, theirs too, pictures, sequences, tiles, caches, volumes, fonts. A file that is missing is among them.

    Not what no render reads: sounds and texts, which have their text in the .blend; nor what is packed.
    """
    caches = _cache_folders()
    unread = {absolute(block, block.filepath) for block in (*bpy.data.sounds, *bpy.data.texts) if block.filepath}
    sequences = _sequences()
    found: set[str] = set()
    for path in map(os.path.normpath, bpy.utils.blend_paths(absolute=True, packed=True, local=False)):
        if path in unread or path in caches or _is_blenders_own(path):
            continue
        several = _tiles(path) if _TILE.search(path) else _frames(path) if path in sequences else []
        found.update(several or [path])
    for folder in caches:
        found.update(str(file) for file in Path(folder).rglob("*") if file.is_file())
    return sorted(found)


def missing(frames: Iterable[int] = ()) -> list[str]:
    """One phrase for each file and each linked data-block that the open .blend asks for and that is not there, or of a later Blender than this one.

    Of sequences it asks for the pictures of these frames.
    """
    files = [(path, _why(path)) for path in sorted({*files_read(), *_pictures_at(set(frames))})]
    lost = [f"{path} {why}" for path, why in files if why]
    without = {path for path, why in files if why}
    for name in (p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION"):
        for block in getattr(bpy.data, name):
            if getattr(block, "is_missing", False) and block.library and (library := _library_path(block.library)) not in without:
                lost.append(f"{block.id_type.lower()} {block.name} of {library} is not there")
    return [*_newer(), *lost]


def _is_blenders_own(path: str) -> bool:
    """Whether it is one of the brushes and assets that Blender brings, whose paths a moved file resolves wrongly."""
    return os.path.join("datafiles", "assets", "") in path


def _newer() -> Iterator[str]:
    """Blender opens a file of a later version without what it does not know."""
    here = bpy.app.version[:2]
    for path, version in [(bpy.data.filepath, bpy.data.version), *((_library_path(library), library.version) for library in bpy.data.libraries)]:
        if path and tuple(version[:2]) > here:
            yield f"{path} was written by Blender {version[0]}.{version[1]}, later than this {here[0]}.{here[1]}"


def shown_objects(scene) -> set:
    """The scene's objects, and those of the collections that they instance, to any depth."""
    shown, waiting, seen = set(scene.objects), list(scene.objects), set()
    while waiting:
        collection = waiting.pop().instance_collection
        if collection is not None and collection not in seen:
            seen.add(collection)
            shown.update(collection.all_objects)
            waiting.extend(collection.all_objects)
    return shown


def named(phrases: Sequence[str]) -> str:
    """The first of many phrases, and how many more there are."""
    return "; ".join(phrases[:_SHOWN]) + (f"; and {len(phrases) - _SHOWN} more" if len(phrases) > _SHOWN else "")


def files_at(image: bpy.types.Image, user: bpy.types.ImageUser, frame: int) -> list[str]:
    """The files that an image shows at a frame; none of one that reads none, as it is made or rendered."""
    if image.source == "TILED":
        return tile_files(image)
    if image.source == "SEQUENCE":
        return [frame_file(image, user, frame)]
    return [absolute(image, image.filepath)] if image.source in ("FILE", "MOVIE") else []


def tile_files(image: bpy.types.Image) -> list[str]:
    """The file of each tile of a UDIM image, by number or by u and v."""
    path, files = absolute(image, image.filepath), []
    for tile in image.tiles:
        u, v = (tile.number - 1001) % 10, (tile.number - 1001) // 10
        files.append(path.replace("<UDIM>", str(tile.number)).replace("<UVTILE>", f"u{u + 1}_v{v + 1}"))
    return files


def frame_file(image: bpy.types.Image, user: bpy.types.ImageUser, frame: int) -> str:
    """The file of a sequence at a frame of the scene; its own where its name has no number.

    `user.frame_current` lags behind in what no object shows. Before its start a sequence shows the picture before its first
    (BKE_image_user_frame_get).
    """
    folder, name = os.path.split(absolute(image, image.filepath))
    length, at = user.frame_duration, frame - user.frame_start + 1
    if length:
        at = (at - 1) % length + 1 if user.use_cyclic else min(max(at, 0), length)
    shown = at + user.frame_offset if length else 0
    stem, ending = os.path.splitext(name)
    return os.path.join(folder, _NUMBER.sub(lambda found: f"{shown:0{len(found[0])}}", stem) + ending)


def absolute(block, path: str) -> str:
    """A path of a data-block, in full."""
    return os.path.normpath(bpy.path.abspath(path, library=block.library))


def _why(path: str) -> str:
    if os.path.isdir(path):
        return "is a folder and no file"
    if not os.path.exists(path):
        return "is not there"
    return "" if os.access(path, os.R_OK) else "cannot be read"


def _library_path(library) -> str:
    return os.path.normpath(bpy.path.abspath(library.filepath))


def _sequences() -> set[str]:
    """Paths that stand for files of the same name with other numbers."""
    blocks = [i for i in (*bpy.data.images, *bpy.data.movieclips) if i.source == "SEQUENCE"]
    blocks += [b for b in (*bpy.data.volumes, *bpy.data.cache_files) if b.is_sequence]
    return {absolute(block, block.filepath) for block in blocks if block.filepath}


def _frames(path: str) -> list[str]:
    folder, name = os.path.split(path)
    number = _NUMBER.search(os.path.splitext(name)[0])
    if number is None:
        return []
    pattern = re.compile(re.escape(name[: number.start()]) + r"\d+" + re.escape(name[number.end() :]))
    return _matching(folder, pattern) + ([] if os.path.exists(path) else [path])


def _pictures_at(frames: set[int]) -> set[str]:
    """The pictures of sequences that nodes show at frames, whether they are there or not."""
    holders = (*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights)
    trees = [*bpy.data.node_groups, *(holder.node_tree for holder in holders if holder.node_tree is not None)]
    found = set()
    for node in [node for tree in trees for node in tree.nodes if node.bl_idname in ("ShaderNodeTexImage", "ShaderNodeTexEnvironment")]:
        image, user = node.image, node.image_user
        if image is None or image.source != "SEQUENCE" or not image.filepath or image.packed_files or not user.use_auto_refresh or user.frame_duration < 1:
            continue
        found.update(frame_file(image, user, frame) for frame in frames)
    return found


def _tiles(path: str) -> list[str]:
    """The tiles that the pictures of this path have."""
    return [file for image in bpy.data.images if image.source == "TILED" and absolute(image, image.filepath) == path for file in tile_files(image)]


def _matching(folder: str, pattern: re.Pattern) -> list[str]:
    try:
        return [os.path.join(folder, name) for name in os.listdir(folder) if pattern.fullmatch(name)]
    except OSError:
        return []


def _cache_folders() -> set[str]:
    """Folders of simulations, each whole; one that is not there has nothing baked."""
    found = set()
    if bpy.data.filepath:
        own = Path(bpy.data.filepath)
        found.add(str(own.with_name(f"blendcache_{own.stem}")))
    for item in bpy.data.objects:
        for modifier in item.modifiers:
            settings = getattr(modifier, "domain_settings", None) if modifier.type == "FLUID" else None
            paths = [getattr(settings, "cache_directory", "")]
            paths += [getattr(modifier, name, "") for name in {"OCEAN": ("filepath",), "NODES": ("bake_directory",)}.get(modifier.type, ())]
            found.update(absolute(item, path) for path in paths if path)
    return found
