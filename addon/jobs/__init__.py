# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that takes time: bakes, conversions and fits beside Blender's window, and what a save needs first."""
