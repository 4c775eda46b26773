# SPDX-License-Identifier: GPL-3.0-or-later
"""What differs between Blenders, and Blender's files, folders and pictures. Nothing of Lamina's materials."""
