# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: `lamina ...` outside Blender, `blender [FILE] --command lamina ...` inside, same arguments."""
