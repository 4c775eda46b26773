# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes: closures fitted to the truth, as tables."""

from .bake import DEFAULT_GLOSSY, MAX_GLOSSY, Bake, Baker
from .bake_stack import baked, best_of, pack_lobes, unpack_lobes
from .brushed_bake import brushed, is_brushed, level
from .live import follows, in_tables
from .ramped import RampBaker
