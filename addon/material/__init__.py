# SPDX-License-Identifier: GPL-3.0-or-later
"""A stack in a material: nodes that hold its values, structure as properties, and the shader that is made of both."""
