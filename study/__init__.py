# SPDX-License-Identifier: GPL-3.0-or-later
"""What measures the product: charts, costs, the paper's figures, stress, agreement. Not shipped; nothing imports it."""
