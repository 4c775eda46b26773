// SPDX-License-Identifier: GPL-3.0-or-later
// A beam through the layers: adding of scalars. It has a transverse momentum p = n sin(theta), which smooth interfaces
// keep, and a variance of p, to which every rough crossing adds. See reference_py/network/analytic/beam.py.
float cosine(float p, float n)
{
    return sqrt(max(1.0 - (p / n) * (p / n), 0.0) + LEAST_COS2);
}

// Reflectance for a beam: that of a rougher interface, towards that of uniform light when it is wide.
float widened_reflectance(float table[], int kind, float cos_theta, float variance, float n_own, float eta, float alpha)
{
    if (eta == 1.0)
        return 0.0;
    float spread = SPREAD_INCIDENCE * variance / (n_own * n_own * cos_theta * cos_theta);
    float wide = spread / (spread + SPREAD_HALF);
    float alpha_wide = min(sqrt(alpha * alpha + spread / (1.0 + spread / SPREAD_LIMIT)), 1.0);
    float narrow = rough_reflectance(table, kind, cos_theta, alpha_wide, eta);
    return variance > 0.0 ? mix(narrow, diffuse_reflectance(table, kind, alpha, eta), wide * wide) : narrow;
}

// Share that one crossing of a medium leaves of a beam: the mean of its two sides.
color attenuation(color tau, float p, float variance, float n)
{
    float step = TAU_SPREAD * sqrt(variance);
    float low = cosine(abs(p - step), n);
    float high = cosine(min(p + step, max(p, TAU_SHARE * n)), n);
    return 0.5 * (exp(-tau / low) + exp(-tau / high));
}

// A beam after a rough interface refracted it; the facets that it sees lean towards it.
void refract_beam(int beckmann, float alpha, float n1, float n2, output float p, output float variance)
{
    float c1 = cosine(p, n1);
    float turn = (n2 * cosine(p, n2) - n1 * c1) * alpha;
    float t = alpha * sqrt(max(1.0 / (c1 * c1) - 1.0, 0.0));
    float lean = turn * (beckmann ? LEAN_BECKMANN_0 * t / (1.0 + LEAN_BECKMANN_1 * alpha + LEAN_BECKMANN_2 * t)
                                  : LEAN_GGX_0 * t / (1.0 + LEAN_GGX_1 * alpha + LEAN_GGX_2 * t * alpha));
    float spread = turn / (1.0 + SPREAD_GRAZING * t);
    variance += LOBE_SPREAD * spread * spread;
    if (alpha > 0.0)
        p = min(p, MOST_SHARE * n2);
    float room = max(MOST_SHARE * n2 - p, 1e-3);
    p = lean > 0.0 ? p + room * (1.0 - exp(-lean / room)) : max(p + lean, 0.0);
    p = min(p, 0.9999 * n2);
}

// Send a beam down from vacuum, or up from the base. Energies per unit that arrives: `transmitted`, reflected by the
// `first` interface and by the `inner` ones; `spread` is the inner energy times its variance of p outside.
void send(float table[], float n[], float alpha[], int kind[], int beckmann[], color tau[], int count, int up,
          output float p, output float variance,
          output color transmitted, output color first, output color inner, output float spread)
{
    transmitted = color(1.0);
    first = inner = color(0.0);
    spread = 0.0;
    color back = color(0.0);
    color out = color(1.0);
    // the last interface that is there, what is already known of the light that comes back to it, and the media since
    int before = -1;
    color around = color(0.0);
    color out_before = color(1.0);
    color left = color(1.0);
    for (int step = 0; step < count; ++step) {
        int j = up ? count - 1 - step : step;
        float n1 = up ? n[j + 1] : n[j];
        float n2 = up ? n[j] : n[j + 1];
        float eta = n2 / n1;
        if (eta != 1.0) {
            float c1 = cosine(p, n1);
            float r12 = widened_reflectance(table, kind[j], c1, variance, n1, eta, alpha[j]);
            float slope = 2.0 * n1 * c1 * alpha[j];
            if (before >= 0) {
                // what this interface turns back meets the one before from behind, widened
                float eta_back = (up ? n[before + 1] : n[before]) / (up ? n[before] : n[before + 1]);
                float wider = variance + BACK_SPREAD * slope * slope;
                float r21 = widened_reflectance(table, kind[before], c1, wider, n1, eta_back, alpha[before]);
                if (eta < 1.0) {
                    float total = clamp((r12 - fresnel_dielectric(c1, eta)) / max(r12, 1e-9), 0.0, 1.0);
                    float trapped_cos = TRAPPED_COS * sqrt(1.0 - eta * eta);
                    float trapped = widened_reflectance(table, kind[before], trapped_cos, TRAPPED_SPREAD * wider, n1, eta_back, alpha[before]);
                    r21 += total * max(trapped - r21, 0.0);
                }
                back = (r21 + (1.0 - r21) * around) * left * left;
                out = (1.0 - r21) * out_before * left;
            }
            color trips = 1.0 / (1.0 - back * r12);
            color lobe = transmitted * r12 * out * trips;
            if (step == 0) {
                first = lobe;
            } else {
                inner += lobe;
                spread += (lobe[0] + lobe[1] + lobe[2]) / 3.0 * (2.0 * variance + slope * slope);
            }
            transmitted *= (1.0 - r12) * trips;
            around = (1.0 - r12) * trips * back;
            out_before = out * trips;
            left = color(1.0);
            refract_beam(beckmann[j], alpha[j], n1, n2, p, variance);
            before = j;
        }
        color behind = up ? (j > 0 ? tau[j - 1] : color(0.0)) : tau[j];
        if (max(behind[0], max(behind[1], behind[2])) > 0.0) {
            color once = attenuation(behind, p, variance, n2);
            transmitted *= once;
            if (before >= 0)
                left *= once;
            else
                out *= once;
        }
    }
}

// Send a beam up from the base, its medium included: what comes back to the base and what escapes.
void send_from_base(float table[], float n[], float alpha[], int kind[], int beckmann[], color tau[], int count,
                    float p_base, float variance_base, output color reflected, output color escaped)
{
    float p = p_base;
    float variance = variance_base;
    color first, inner;
    float spread;
    color left = attenuation(tau[count - 1], p_base, 0.0, n[count]);
    send(table, n, alpha, kind, beckmann, tau, count, 1, p, variance, escaped, first, inner, spread);
    reflected = (first + inner) * left * left;
    escaped *= left;
}

// Reflectance and transmittance of the layers for uniform light from below; see reference_py/network/analytic/base.py.
void uniform_below(float table[], float n[], float alpha[], int kind[], int beckmann[], color tau[], int count,
                   output color reflected, output color escaped)
{
@ESCAPING_NODES@
@TRAPPED_NODES@
    color inner, first, back, out;
    float spread, p, variance;
    float n_base = n[count];
    escaped = color(0.0);
    for (int q = 0; q < @ESCAPING@; ++q) {
        p = sqrt(1.0 - escaping_u[q] * escaping_u[q]);
        variance = 0.0;
        send(table, n, alpha, kind, beckmann, tau, count, 0, p, variance, out, first, inner, spread);
        escaped += 2.0 * escaping_w[q] * escaping_u[q] / (n_base * n_base) * out;
    }
    reflected = 1.0 - escaped;
    float least = 1.0;
    float thickest = 0.0;
    for (int j = 0; j < count; ++j) {
        least = min(least, n[j]);
        thickest = max(thickest, max(tau[j][0], max(tau[j][1], tau[j][2])));
    }
    if (thickest == 0.0)
        return;
    color absorbed = color(0.0);
    float share = least / n_base;
    float critical = sqrt(max(1.0 - share * share, 0.0));
    for (int q = 0; q < @ESCAPING@ + @TRAPPED@; ++q) {
        float weight;
        if (q < @ESCAPING@) {
            p = least * sqrt(1.0 - escaping_u[q] * escaping_u[q]);
            weight = 2.0 * escaping_w[q] * escaping_u[q] * share * share;
        } else {
            float c = critical * trapped_u[q - @ESCAPING@];
            p = n_base * sqrt(1.0 - c * c);
            weight = 2.0 * trapped_w[q - @ESCAPING@] * critical * c;
        }
        if (weight > 0.0) {
            send_from_base(table, n, alpha, kind, beckmann, tau, count, p, 0.0, back, out);
            absorbed += weight * (1.0 - back - out);
        }
    }
    reflected = max(reflected - max(absorbed, color(0.0)), color(0.0));
}
