# SPDX-License-Identifier: GPL-3.0-or-later
"""One module per chart of `lamina chart`; each has `chart(folder, report)`."""
