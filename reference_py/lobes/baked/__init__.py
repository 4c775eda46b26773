# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `baked`: closures fitted to the truth, as tables."""

from .bake import DEFAULT_GLOSSY, MAX_GLOSSY, Bake, BakedLobes, Baker, baked, described, is_bare_oren_nayar, pack_lobes, unpack_lobes
from .live import axes_of
