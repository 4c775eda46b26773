# SPDX-License-Identifier: GPL-3.0-or-later
"""A lobe set as the text of an OSL shader. One way: generate -> emit_* (-> analytic_layers) -> surface -> block -> parts -> the files of `osl/`."""
