# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work that runs in a process beside Blender's window."""
