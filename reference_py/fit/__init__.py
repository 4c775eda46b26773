# SPDX-License-Identifier: GPL-3.0-or-later
"""From a measurement to a layer stack: the fit that Weidlich07 leaves as work to do.

    measurement = read("paint.binary")              # readers: MERL, RGL, tables; or a model's own samples
    chosen = select(measurement)                    # the fewest layers that the data support
    chosen.best.stack.save("paint.json")

A stack is fitted by bounded least squares (`solve`) of a compressed residual (`metric`). Needs numpy alone, so that it
runs inside Blender.
"""

# For layers and base: what the data support.
AUTO = "auto"
