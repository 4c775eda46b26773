# SPDX-License-Identifier: GPL-3.0-or-later
"""What measures Lamina and finds its constants; a checkout has it, the extension does not."""
