# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets as Blender's assets, and those that users save."""
