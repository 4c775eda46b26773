# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against cost of every way to render a layered material in Cycles: `lamina chart pareto`.

`reflectance`, `appearance` and `draw` import without bpy; the other modules need it.
"""
