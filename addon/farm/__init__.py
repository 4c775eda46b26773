# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs for render farms: everything that is rendered in files that need no Lamina, and templates for two engines."""
