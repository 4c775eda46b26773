# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set as a shader: OSL text (`osl`) and stock nodes (`nodes`)."""
