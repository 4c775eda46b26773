# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures through OpenImageIO, which ships with Blender. Arrays have the top row first.

Stands alone: a farm's render script takes a copy of this file along. So it needs nothing else of Lamina.
"""

import contextlib
import os

import numpy as np

MISSING = "Python cannot import OpenImageIO, which Blender from blender.org and the bpy wheel bring along (Debian: apt-get install python3-openimageio)"
# What OpenImageIO adds itself: what says when, or how a file was packed.
_OWN = ("DateTime", "compression", "Software")

# A broken header may claim any size, and memory is asked for by it. 16384 x 16384 pixels of four floats take 4300.
_MOST_MEGABYTES = 8192


def module():
    """The module OpenImageIO. Raises ImportError with what to do."""
    try:
        import OpenImageIO
    except ImportError:
        raise ImportError(MISSING) from None
    return OpenImageIO


@contextlib.contextmanager
def _quiet():
    """OpenEXR and libpng say on stderr, past OpenImageIO, what is wrong with a file."""
    stderr, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 2)
    try:
        yield
    finally:
        os.dup2(stderr, 2)
        os.close(stderr)
        os.close(sink)


def read(path: str | os.PathLike, kind: str = "float") -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """All channels of all parts, name -> (h, w), and the texts in the first part's header.

    Raises OSError for what cannot be opened, ValueError for what is no whole picture.
    """
    with open(path, "rb"):
        pass  # the system's own words for what is missing or forbidden
    oiio = module()
    oiio.attribute("limits:imagesize_MB", _MOST_MEGABYTES)
    as_stored = oiio.ImageSpec()
    as_stored.attribute("oiio:UnassociatedAlpha", 1)
    with _quiet():
        return _channels(oiio, os.fspath(path), as_stored, kind)


def _channels(oiio, path: str, as_stored, kind: str) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    source = oiio.ImageInput.open(path, as_stored)
    if source is None:
        raise ValueError(oiio.geterror() or "unknown format")
    try:
        first, channels, part = source.spec(), {}, 0
        while source.seek_subimage(part, 0):
            spec = source.spec()
            pixels = source.read_image(kind)
            if pixels is None:
                raise ValueError(source.geterror() or "its pixels cannot be read")
            channels |= {name: pixels[..., i] for i, name in enumerate(spec.channelnames)}
            part += 1
        texts = dict(_texts(first))
    finally:
        source.close()
        source.geterror()  # an error that nobody asked for is printed when the reader goes
    return channels, texts


def _texts(spec):
    """(name, text) of a header, without what OpenImageIO adds itself."""
    for attribute in spec.extra_attribs:
        try:
            value = attribute.value
        except UnicodeDecodeError:  # Blender 4.5 cuts a long note within a character
            continue
        if isinstance(value, str) and attribute.name not in _OWN and ":" not in attribute.name.removeprefix("lamina:"):
            yield attribute.name, value


def pieces(path: str | os.PathLike, floats: int):
    """The pixels of a picture's first part as (n, 1, 3 or 4) float arrays of about `floats` numbers each, from the top down.

    Raises OSError for what cannot be opened, ValueError for what is no whole picture of such channels.
    """
    oiio = module()
    with open(path, "rb"):
        pass
    as_stored = oiio.ImageSpec()
    as_stored.attribute("oiio:UnassociatedAlpha", 1)
    with _quiet():
        source = oiio.ImageInput.open(os.fspath(path), as_stored)
        if source is None:
            raise ValueError(oiio.geterror() or "unknown format")
        try:
            spec = source.spec()
            if tuple(spec.channelnames) not in (("Y",), ("I",), ("R", "G", "B"), ("R", "G", "B", "A")):
                raise ValueError(f"channels {', '.join(spec.channelnames)}")
            step = max(floats // (spec.width * spec.nchannels), spec.tile_height, 1)
            step -= step % max(spec.tile_height, 1)
            for top in range(spec.y, spec.y + spec.height, step):
                bottom = min(top + step, spec.y + spec.height)
                if spec.tile_width:
                    pixels = source.read_tiles(spec.x, spec.x + spec.width, top, bottom, 0, 1, 0, spec.nchannels, "float")
                else:
                    pixels = source.read_scanlines(top, bottom, 0, 0, spec.nchannels, "float")
                if pixels is None:
                    raise ValueError(source.geterror() or "its pixels cannot be read")
                yield pixels.reshape(-1, spec.nchannels)
        finally:
            source.close()
            source.geterror()  # an error that nobody asked for is printed when the reader goes


def write(path: str | os.PathLike, channels: dict[str, np.ndarray], texts: dict[str, str]) -> None:
    """Write (h, w) channels, uint8 or as float32, with texts in the header, and read them again.

    Raises OSError; then the file may be half-written.
    """
    oiio = module()
    pixels = np.stack(list(channels.values()), axis=-1)
    if pixels.dtype != np.uint8:
        pixels = pixels.astype(np.float32)
    height, width, depth = pixels.shape
    spec = oiio.ImageSpec(width, height, depth, oiio.UINT8 if pixels.dtype == np.uint8 else oiio.FLOAT)
    spec.channelnames = tuple(channels)
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "")  # else the time of day: the same picture is the same file
    for name, text in texts.items():
        spec.attribute(name, text)
    target = oiio.ImageOutput.create(os.fspath(path))
    if target is None:
        raise OSError(oiio.geterror())
    if not (target.open(os.fspath(path), spec) and target.write_image(np.ascontiguousarray(pixels)) and target.close()):
        raise OSError(target.geterror())
    try:
        written, _ = read(path, "uint8" if pixels.dtype == np.uint8 else "float")
        same = all(np.array_equal(written[name], pixels[..., i], equal_nan=pixels.dtype != np.uint8) for i, name in enumerate(channels))
    except (ValueError, KeyError):
        same = False
    if not same:  # OpenImageIO says nothing of a PNG on a full disk
        raise OSError("what was written cannot be read again; is the disk full?")
