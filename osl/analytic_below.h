// SPDX-License-Identifier: GPL-3.0-or-later
// The layers for light from below: polynomials through the nodes of light that may escape and of trapped light.
// See `Below` in reference_py/lobes/analytic/base.py.
struct Below {
    float least;
    float n_base;
    float critical2;
@FIELDS@
};

void shares_below(Below b, float p, float width, output color back, output color out)
{
    float u = sqrt(max(1.0 - (p / b.least) * (p / b.least), 0.0));
    back = clamp(@ESCAPING_BACK@, color(0.0), color(1.0));
    out = clamp(@ESCAPING_OUT@, color(0.0), color(1.0));
    if (b.critical2 > 0.0) {
        float v = sqrt(clamp((1.0 - (p / b.n_base) * (p / b.n_base)) / b.critical2, 0.0, 1.0));
        float beyond = clamp(0.5 + (p - b.least) / max(width, 1e-4), 0.0, 1.0);
        back += beyond * (clamp(@TRAPPED_BACK@, color(0.0), color(1.0)) - back);
        out += beyond * (clamp(@TRAPPED_OUT@, color(0.0), color(1.0)) - out);
    }
}
