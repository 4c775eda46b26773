#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# mitsuba 3.9.1, its plugin `measured`: of a .bsdf file's tables, luminance and rgb must be square; vndf may have any shape.
# Expected: the file says each table's shape, so a table of f with more columns than rows, as azimuth needs more than elevation, is read.
# Seen: "Incompatible array sizes" (or the like) for luminance and rgb of 8 x 16; the same file with 16 x 16 is read, with a vndf of 8 x 16 too.
# Output of 2026-11-29:
#   all square: read     vndf 8 x 16: read     luminance and rgb 8 x 16: refused
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
cat >"$work/measure.py" <<'PYTHON'
import struct
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
changed = []


def tables(f_shape, vndf_shape):
    """A grey Lambertian surface."""
    theta, phi = np.linspace(0.0, np.pi / 2, 4, dtype=np.float32), np.zeros(1, np.float32)
    flat = np.ones((1, 4), np.float32)
    return {
        "description": np.frombuffer(b"grey", np.uint8), "jacobian": np.array([0], np.uint8), "phi_i": phi, "theta_i": theta,
        "sigma": np.ones((8, 8), np.float32), "ndf": np.ones((8, 8), np.float32), "vndf": np.ones((1, 4, *vndf_shape), np.float32),
        "luminance": np.ones((1, 4, *f_shape), np.float32), "rgb": np.ones((1, 4, 3, *f_shape), np.float32),
    }  # fmt: skip


def write(path, fields):
    """A tensor file: a head that names each field's kind, place and shape, then the fields."""
    kinds, at = {"uint8": 1, "float32": 10}, 18 + sum(2 + len(name) + 11 + 8 * field.ndim for name, field in fields.items())
    head, body = b"tensor_file\0" + struct.pack("<2BI", 1, 0, len(fields)), b""
    for name, field in fields.items():
        body += b"\0" * (-(at + len(body)) % 8)
        head += struct.pack(f"<H{len(name)}sHBQ{field.ndim}Q", len(name), name.encode(), field.ndim, kinds[field.dtype.name], at + len(body), *field.shape)
        body += field.tobytes()
    path.write_bytes(head + body)


for name, shapes, expected in (("all square", ((16, 16), (16, 16)), True), ("vndf 8 x 16", ((16, 16), (8, 16)), True), ("f 8 x 16", ((8, 16), (16, 16)), False)):
    path = Path(f"{name.replace(' ', '_')}.bsdf")
    write(path, tables(*shapes))
    try:
        mi.load_dict({"type": "measured", "filename": str(path)})
        read = True
    except RuntimeError as error:
        read = False
        print("   ", " ".join(str(error).split())[:120])
    print(f"  {name}: {'read' if read else 'refused'}")
    if read != expected:
        changed.append(name)
sys.exit(3 if changed else 0)
PYTHON
packages mitsuba==3.9.1 numpy==1.26.4
