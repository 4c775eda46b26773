# SPDX-License-Identifier: GPL-3.0-or-later
"""`lamina info`: what a picture's header says of its origin, and whether its pixels are those that were written."""

import json

from ..session import blender, say

WHOLE, CHANGED = "as they were written", "NOT those that were written"


def info(options) -> None:
    """Print every text of the header, Lamina's first."""
    with blender(say("info")):
        from ..batch.task import pixel_hash
        from ..blender.images import read_exr

        channels, texts = read_exr(options.picture)
        if "lamina:pixels" in texts:
            same = all(name in channels for name in "RGBA") and pixel_hash(channels) == texts["lamina:pixels"]
            texts["pixels"] = WHOLE if same else CHANGED
    if options.json:
        print(json.dumps(texts, ensure_ascii=False))
        return
    for name in sorted(texts, key=lambda n: (not n.startswith("lamina:"), n)):
        print(f"{name}: {texts[name]}")
    if not texts:
        print("no texts in the header")
