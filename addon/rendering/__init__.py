# SPDX-License-Identifier: GPL-3.0-or-later
"""Rendering with Cycles: measurements exact enough for tests, and studio pictures of materials.

`images` and `environment` import without bpy; the other modules need it.
"""
