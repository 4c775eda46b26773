# SPDX-License-Identifier: GPL-3.0-or-later
"""Tier `baked`: closures fitted to the truth, as tables."""

from .bake import DEFAULT_GLOSSY, MAX_GLOSSY, Bake, BakedNetwork, Baker, baked, described, is_bare_oren_nayar, pack_network, unpack_network
from .live import axes_of
