# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set as stock nodes, for Blenders and devices without OSL; `stock_nodes` is the way in."""
