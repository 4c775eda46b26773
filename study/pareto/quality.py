# SPDX-License-Identifier: GPL-3.0-or-later
"""How much is spent on the chart. Does not need bpy."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Quality:
    """Rounds of timing; pixels a side and samples of renders; `slab_renders` of one sample per view; whether memory is measured."""

    rounds: int = 5
    time_size: int = 128
    time_samples: int = 16
    scene_size: int = 96
    scene_samples: int = 16
    picture_size: int = 64
    picture_samples: int = 256
    slab_samples: int = 1024
    noise_samples: int = 16
    slab_renders: int = 4
    memory: bool = True
