# SPDX-License-Identifier: GPL-3.0-or-later
"""What buttons and menus do. Each operator is one undo step."""
