// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The layers for light from below: polynomials through the nodes of light that may escape and of trapped light.
// See `Below` in reference_py/lobes/analytic/base.py. Coefficients have names, as OSL does not fold what is written to an array.
struct Below {
    float least;
    float n_base;
    float critical2;
    color escaping_back_0;
    color escaping_back_1;
    color escaping_back_2;
    color escaping_back_3;
    color escaping_out_0;
    color escaping_out_1;
    color escaping_out_2;
    color escaping_out_3;
    color trapped_back_0;
    color trapped_back_1;
    color trapped_back_2;
    color trapped_out_0;
    color trapped_out_1;
    color trapped_out_2;
};

void start_below(output Below b, float least, float n_base, float critical2)
{
    b.least = least;
    b.n_base = n_base;
    b.critical2 = critical2;
    b.escaping_back_0 = color(0.0);
    b.escaping_back_1 = color(0.0);
    b.escaping_back_2 = color(0.0);
    b.escaping_back_3 = color(0.0);
    b.escaping_out_0 = color(0.0);
    b.escaping_out_1 = color(0.0);
    b.escaping_out_2 = color(0.0);
    b.escaping_out_3 = color(0.0);
    b.trapped_back_0 = color(0.0);
    b.trapped_back_1 = color(0.0);
    b.trapped_back_2 = color(0.0);
    b.trapped_out_0 = color(0.0);
    b.trapped_out_1 = color(0.0);
    b.trapped_out_2 = color(0.0);
}

// A node of which the share `back` returns and `out` escapes; what its value adds to each coefficient.
void add_node(output Below b, color back, color out,
              float escaping_0, float escaping_1, float escaping_2, float escaping_3, float trapped_0, float trapped_1, float trapped_2)
{
    b.escaping_back_0 += escaping_0 * back;
    b.escaping_back_1 += escaping_1 * back;
    b.escaping_back_2 += escaping_2 * back;
    b.escaping_back_3 += escaping_3 * back;
    b.escaping_out_0 += escaping_0 * out;
    b.escaping_out_1 += escaping_1 * out;
    b.escaping_out_2 += escaping_2 * out;
    b.escaping_out_3 += escaping_3 * out;
    b.trapped_back_0 += trapped_0 * back;
    b.trapped_back_1 += trapped_1 * back;
    b.trapped_back_2 += trapped_2 * back;
    b.trapped_out_0 += trapped_0 * out;
    b.trapped_out_1 += trapped_1 * out;
    b.trapped_out_2 += trapped_2 * out;
}

void shares_below(Below b, float p, float width, output color back, output color out)
{
    float u = sqrt(max(1.0 - (p / b.least) * (p / b.least), 0.0));
    back = clamp(((b.escaping_back_3 * u + b.escaping_back_2) * u + b.escaping_back_1) * u + b.escaping_back_0, color(0.0), color(1.0));
    out = clamp(((b.escaping_out_3 * u + b.escaping_out_2) * u + b.escaping_out_1) * u + b.escaping_out_0, color(0.0), color(1.0));
    if (b.critical2 > 0.0) {
        float v = sqrt(clamp((1.0 - (p / b.n_base) * (p / b.n_base)) / b.critical2, 0.0, 1.0));
        float beyond = clamp(0.5 + (p - b.least) / max(width, 1e-4), 0.0, 1.0);
        back += beyond * (clamp((b.trapped_back_2 * v + b.trapped_back_1) * v + b.trapped_back_0, color(0.0), color(1.0)) - back);
        out += beyond * (clamp((b.trapped_out_2 * v + b.trapped_out_1) * v + b.trapped_out_0, color(0.0), color(1.0)) - out);
    }
}
