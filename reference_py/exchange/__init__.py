# SPDX-License-Identifier: GPL-3.0-or-later
"""From other people's materials to stacks and back: Blender's Principled BSDF, OpenPBR, MaterialX files.

Both have one coat over one gloss over a base (`slots`). A conversion keeps the energy: the base color is solved such
that the mean albedo is that of what is converted (`matching`), and a report says what became of every parameter and
which error remains (`report`).
"""

# of MaterialX files
SUFFIX = ".mtlx"
