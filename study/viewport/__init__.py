# SPDX-License-Identifier: GPL-3.0-or-later
"""How Blender's viewport shows what Cycles renders: `lamina chart viewport`. `eevee_task` is the part that runs in another Blender."""
