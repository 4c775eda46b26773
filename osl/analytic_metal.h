// SPDX-License-Identifier: GPL-3.0-or-later
// A metal base: its lobe at a few directions from its visible facets, each carried out through the layers.
// See reference_py/network/analytic/base.py. `reflected` and `escaped` are the layers' for uniform light from below.
color metal_energy(float table[], float n[], float alpha[], int kind[], int beckmann[], color tau[], int count,
                   float p, float variance, float base_alpha, int base_kind, int base_beckmann, int spread_beckmann,
                   color eta, color k, color reflected, color escaped)
{
@LOBE_NODES@
@MEAN_NODES@
    float n_base = n[count];
    float c = cosine(p, n_base);
    float s = min(p / n_base, 1.0);
    float widened = sqrt(variance * EXIT_SPREAD) / (2.0 * n_base * c);
    float total_alpha = min(sqrt(base_alpha * base_alpha + widened * widened), 1.0);
    float node_width = NODE_SPREAD * 2.0 * n_base * c * total_alpha;
    float all_seen = 0.0;
    float all_hidden = 0.0;
    color once = color(0.0);
    color again = color(0.0);
    color first = color(0.0);
    color returned = color(0.0);
    color out_again = color(0.0);
    color back_again = color(0.0);
    for (int q = 0; q < @LOBE_COUNT@; ++q) {
        float u = lobe_u[q];
        float ggx = sqrt(u / (1.0 - u));
        float gauss = sqrt(-log(1.0 - u));
        float own = base_beckmann ? gauss : ggx;
        float above = widened * (spread_beckmann ? gauss : ggx);
        float stretch = base_alpha * own / ggx;
        float apart = sqrt(base_alpha * base_alpha * own * own + above * above) - base_alpha * own;
        float size = sqrt(stretch * stretch * s * s + c * c);
        float ax = stretch * s / size;
        float az = c / size;
        float hz = (1.0 - u) * (1.0 + az);
        float ring = sqrt(max(1.0 - (hz - az) * (hz - az), 0.0));
        float hx = stretch * (ring * lobe_x[q] + ax);
        float hy = stretch * ring * lobe_y[q];
        size = sqrt(hx * hx + hy * hy + hz * hz);
        hx /= size;
        hy /= size;
        hz /= size;
        float cos_om = s * hx + c * hz;
        float iz = 2.0 * cos_om * hz - c;
        float lambda_o = smith_lambda(c, stretch, 0);
        float seen = iz > 0.0 ? (1.0 + lambda_o) / (1.0 + lambda_o + smith_lambda(max(iz, LEAST_COS), stretch, 0)) : 0.0;
        float ix = 2.0 * cos_om * hx - s + 2.0 * c * apart * lobe_x[q];
        float iy = 2.0 * cos_om * hy + 2.0 * c * apart * lobe_y[q];
        color fresnel = fresnel_conductor(min(cos_om, 1.0), eta, k);
        float hidden = lobe_w[q] * (1.0 - seen);
        seen *= lobe_w[q];
        all_seen += seen;
        all_hidden += hidden;
        again += hidden * fresnel;
        color share = seen * fresnel;
        once += share;
        if (count > 0) {
            color back, out;
            float p_out = n_base * min(sqrt(ix * ix + iy * iy), MOST_LOBE_SHARE);
            send_from_base(table, n, alpha, kind, beckmann, tau, count, p_out, node_width * node_width, back, out);
            first += share * out;
            returned += share * back;
            out_again += share * back * out;
            back_again += share * back * back;
        }
    }
    // the nodes know the lobe's shape, the table its energy
    float energy = closure_energy(table, base_kind, c, base_alpha);
    float keep = energy / all_seen;
    color mean = color(0.0);
    for (int q = 0; q < @MEAN_COUNT@; ++q)
        mean += mean_w[q] * fresnel_conductor(mean_c[q], eta, k);
    float lost = BASE_LOSS * base_alpha * base_alpha / (1.0 + (1.0 + BASE_LOSS) * base_alpha * base_alpha);
    color facets = again * (1.0 - energy) / max(all_hidden, 1e-9) * mean * (1.0 - lost) / (1.0 - mean * lost);
    once = once * keep + facets;
    if (count == 0)
        return once;
    color scale = max(returned, color(1e-12));
    out_again /= scale;
    back_again /= scale;
    float roughest = 0.0;
    for (int j = 0; j < count; ++j)
        roughest = max(roughest, n[j] != n[j + 1] ? alpha[j] : 0.0);
    color kept = out_again * (1.0 - KEPT_ORDER * roughest / (roughest + KEPT_SCALE));
    back_again += out_again - kept;
    float stirred = total_alpha / (total_alpha + STIR_SCALE);
    out_again = mix(kept, escaped, stirred);
    back_again = mix(back_again, reflected, stirred);
    color later = (returned * keep + facets * reflected) * once * out_again / (1.0 - once * back_again);
    return first * keep + facets * escaped + later;
}
