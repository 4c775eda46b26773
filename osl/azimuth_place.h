// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// Filled in from reference_py (addon/shader/osl/osl_files.py).
#define AZIMUTH_1 0.2
#define AZIMUTH_2 0.4
#define AZIMUTH_3 0.6
#define AZIMUTH_4 0.8

// Where the sheets of tables over the view's azimuth from an axis are read: the sheet below, and the way to the next. `side` is the
// part of the view in the plane of the normal; along the normal all sheets are alike.
void azimuth_place(vector side, vector axis, output int sheet, output float between)
{
    float cos_phi = min(abs(dot(side, axis)) / max(length(side), 1e-6), 1.0);
    float low = 0.0;
    float high = AZIMUTH_1;
    sheet = 0;
    if (cos_phi > AZIMUTH_4) {
        sheet = 4;
        low = AZIMUTH_4;
        high = 1.0;
    } else if (cos_phi > AZIMUTH_3) {
        sheet = 3;
        low = AZIMUTH_3;
        high = AZIMUTH_4;
    } else if (cos_phi > AZIMUTH_2) {
        sheet = 2;
        low = AZIMUTH_2;
        high = AZIMUTH_3;
    } else if (cos_phi > AZIMUTH_1) {
        sheet = 1;
        low = AZIMUTH_1;
        high = AZIMUTH_2;
    }
    between = (cos_phi - low) / (high - low);
}
