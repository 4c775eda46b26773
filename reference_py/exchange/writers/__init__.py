# SPDX-License-Identifier: GPL-3.0-or-later
"""Writers: a stack in the formats of other people's renderers and measurements, as tables of the truth or as explicit layers.

What a format cannot hold is refused in one line. Every table is read back and compared with the truth (`error`).
"""
