# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials from Principled nodes and to them, MaterialX files, and textures for game engines."""
