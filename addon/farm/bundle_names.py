# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the files in a bundle, for those who write it and those who describe it. Needs no bpy."""

FILES, ITEMS, SCRIPT = "files", "items.json", "render_items.py"
