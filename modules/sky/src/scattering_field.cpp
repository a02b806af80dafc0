#include "scattering_field.hpp"

#include "scattering_sweep.hpp"
#include "unit_quadrature.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/phase.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/exponential.hpp>

namespace alpenglow::sky {
namespace {

// From distance `near` to `far` along a ray of a given nearest distance to the Earth's centre (lengths from there).
template <class T>
CarryWeights<T> layer(const ScatteringAtmosphere& air, double nearest_km, double near, double far, double h_near,
                      double h_far, double forward) {
    constexpr int pieces = 4;
    CarryWeights<T> out{};
    glm::dvec3 through(1.0);
    glm::dvec3 sums[4]{};
    for (int i = 0; i < pieces; ++i) {
        const double s = near + (far - near) * (i + 0.5) / pieces;
        const double step = std::abs(far - near) / pieces;
        const double h = std::max(std::hypot(nearest_km, s) - air.ground_radius_km, 0.0);
        const AirSample sample = sample_air(air, h);
        const double u = std::clamp((h - h_near) / (h_far - h_near), 0.0, 1.0);
        for (int c = 0; c < 3; ++c) {
            const double depth = (sample.extinction[c] - forward * sample.mie[c]) * step;
            const double light = through[c] * (depth > 1e-9 ? -std::expm1(-depth) / depth : 1.0) * step;
            through[c] *= std::exp(-depth);
            sums[0][c] += light * sample.rayleigh[c] * (1.0 - u);
            sums[1][c] += light * sample.rayleigh[c] * u;
            sums[2][c] += light * sample.mie[c] * (1.0 - u);
            sums[3][c] += light * sample.mie[c] * u;
        }
    }
    for (int c = 0; c < 3; ++c) {
        out.left[c] = static_cast<T>(through[c]);
        out.rayleigh_near[c] = static_cast<T>(sums[0][c]);
        out.rayleigh_far[c] = static_cast<T>(sums[1][c]);
        out.mie_near[c] = static_cast<T>(sums[2][c]);
        out.mie_far[c] = static_cast<T>(sums[3][c]);
    }
    return out;
}

template <class T>
struct ShellRay {
    std::size_t lowest;                    // shell
    bool ground;                           // ends on the ground; else it is tangent to the lowest shell
    std::vector<double> mu;                // cosine to the zenith at the shells from the lowest on
    std::vector<double> weight;            // of its solid angle there, over 2 pi
    std::vector<double> angle;             // at the Earth's centre from one shell to the next
    std::vector<CarryWeights<T>> up, down; // looking up from a shell, down from the next
    std::vector<T> shapes;                 // Y_lm of the upward direction in the order of the field, for each shell
};

template <class T>
std::vector<ShellRay<T>> make_rays(const ScatteringAtmosphere& air, const std::vector<double>& heights, int zeniths,
                                   std::size_t all_tangents, double forward) {
    const std::size_t shells = heights.size();
    const double ground = air.ground_radius_km;
    std::vector<ShellRay<T>> rays;
    const auto add = [&](double nearest_height, double mu_ground, std::size_t lowest, bool meets) {
        ShellRay<T> ray;
        ray.lowest = lowest;
        ray.ground = meets;
        const double nearest = meets ? ground * std::sqrt(1.0 - mu_ground * mu_ground) : ground + nearest_height;
        std::vector<double> along;
        for (std::size_t i = lowest; i < shells; ++i) {
            const double r = ground + heights[i];
            // r^2 - nearest^2 without cancellation
            const double square = meets ? heights[i] * (r + ground) + ground * ground * mu_ground * mu_ground
                                        : (heights[i] - nearest_height) * (r + ground + nearest_height);
            along.push_back(std::sqrt(std::max(square, 0.0)));
            ray.mu.push_back(along.back() / r);
        }
        for (std::size_t k = 0; k + 1 < along.size(); ++k) {
            const double h0 = heights[lowest + k];
            const double h1 = heights[lowest + k + 1];
            ray.angle.push_back(std::atan2(along[k + 1], nearest) - std::atan2(along[k], nearest));
            ray.up.push_back(layer<T>(air, nearest, along[k], along[k + 1], h0, h1, forward));
            ray.down.push_back(layer<T>(air, nearest, along[k + 1], along[k], h1, h0, forward));
        }
        ray.weight.assign(along.size(), 0.0);
        rays.push_back(std::move(ray));
    };
    const UnitNodes nodes = unit_quadrature(zeniths);
    for (std::size_t k = 0; k < nodes.x.size(); ++k) {
        const double t = nodes.x[k];
        const double mu = t * t; // crowded towards the horizon
        add(0.0, mu, 0, true);
        ShellRay<T>& ray = rays.back();
        for (std::size_t i = 0; i < shells; ++i) {
            const double ratio = ground / (ground + heights[i]);
            ray.weight[i] = nodes.w[k] * 2.0 * t * ratio * ratio * mu / ray.mu[i];
        }
    }
    const std::size_t first = rays.size();
    for (std::size_t j = 0; j + 1 < shells; ++j) {
        if (j < all_tangents || j % 2 == 0) {
            add(heights[j], 0.0, j, false);
        }
    }
    // Between the horizon and the level of a shell: trapezoids over the rays that touch the shells below.
    for (std::size_t i = 1; i < shells; ++i) {
        for (std::size_t n = first; n < rays.size() && rays[n].lowest <= i; ++n) {
            const auto mu_of = [&](std::size_t ray) { return rays[ray].mu[i - rays[ray].lowest]; };
            const bool last = n + 1 == rays.size() || rays[n + 1].lowest > i;
            const double mu = mu_of(n);
            const double above = n > first ? mu_of(n - 1) : mu;
            const double below = last ? 0.0 : mu_of(n + 1);
            // The level one stands for both of its sides.
            rays[n].weight[i - rays[n].lowest] =
                rays[n].lowest == i ? above : 0.5 * (above - mu) + (last ? 1.0 : 0.5) * (mu - below);
        }
    }
    return rays;
}

} // namespace

void exact_sun_at(const ScatteringAtmosphere& air, double height_km, double sun_zenith_rad, glm::dvec3& light,
                  glm::dvec3& depth) {
    const double mu_s = std::cos(sun_zenith_rad);
    light = sun_transmittance(air, height_km, mu_s, 6);
    depth = glm::dvec3(0.0);
    if (light.x + light.y + light.z <= 0.0) {
        return;
    }
    // The same path through the aerosol alone.
    const double r = air.ground_radius_km + height_km;
    const double lowest = std::max(-r * mu_s, 0.0);
    const double nearest = r * std::sin(sun_zenith_rad);
    const double top = air.ground_radius_km + air.top_km;
    const double end = -r * mu_s + std::sqrt(std::max(top * top - nearest * nearest, 0.0));
    static const UnitNodes nodes = unit_quadrature(24);
    double column = 0.0;
    for (const double side : {0.0, end}) {
        const double length = side - lowest;
        for (std::size_t k = 0; k < nodes.x.size(); ++k) {
            const double t = nodes.x[k];
            const double s = lowest + length * t * t * t;
            const double square = s * (s + 2.0 * r * mu_s);
            const double h = height_km + square / (std::sqrt(std::max(r * r + square, 0.0)) + r);
            column += std::exp(-std::max(h, 0.0) / air.mie_height_km) * std::abs(length) * 3.0 * t * t * nodes.w[k];
        }
    }
    depth = air.mie_scattering_per_km * column;
}

void field_shapes(int bands, double z, double s, std::span<double> out) {
    // The recurrence's factors are the same for all directions.
    struct Factors {
        std::array<double, most_field_functions> a{}, b{};
        std::array<double, most_field_bands> diagonal{};
        Factors() {
            for (int m = 0; m < most_field_bands; ++m) {
                diagonal[static_cast<std::size_t>(m)] = m > 0 ? std::sqrt((2.0 * m + 1.0) / (2.0 * m)) : 0.0;
                for (int l = m + 1; l < most_field_bands; ++l) {
                    const auto at = static_cast<std::size_t>(l * (l + 1) / 2 + m);
                    const double k = l - 1;
                    a[at] = std::sqrt((4.0 * l * l - 1.0) / (l * l - m * m));
                    b[at] = l - 1 > m ? std::sqrt((k * k - m * m) / (4.0 * k * k - 1.0)) : 0.0;
                }
            }
        }
    };
    static const Factors factors;
    double diagonal = 0.28209479177387814;
    for (int m = 0; m < bands; ++m) {
        if (m > 0) {
            diagonal *= factors.diagonal[static_cast<std::size_t>(m)] * s;
        }
        const double scale = m > 0 ? 1.4142135623730951 : 1.0;
        double before = 0.0;
        double now = diagonal;
        for (int l = m; l < bands; ++l) {
            const auto at = static_cast<std::size_t>(l * (l + 1) / 2 + m);
            if (l > m) {
                const double next = factors.a[at] * (z * now - factors.b[at] * before);
                before = now;
                now = next;
            }
            out[at] = scale * now;
        }
    }
}

void cornette_shanks_bands(double g, int bands, std::span<double> out) {
    std::fill_n(out.begin(), bands + 1, 0.0);
    const UnitNodes nodes = unit_quadrature(64);
    for (std::size_t i = 0; i < nodes.x.size(); ++i) { // nodes crowd towards the peak
        const double t = nodes.x[i];
        const double c = std::copysign(1.0, g) * (1.0 - 2.0 * t * t);
        const double w = two_pi * 4.0 * t * nodes.w[i] * phase_cornette_shanks(c, g);
        double before = 0.0;
        double now = 1.0;
        for (int l = 0; l <= bands; ++l) {
            out[static_cast<std::size_t>(l)] += w * now;
            const double next = ((2.0 * l + 1.0) * c * now - l * before) / (l + 1.0);
            before = now;
            now = next;
        }
    }
    for (int l = bands; l >= 0; --l) {
        out[static_cast<std::size_t>(l)] /= out[0];
    }
}

namespace {

std::vector<double> shell_heights(const ScatteringAtmosphere& air, std::size_t shells) {
    std::vector<double> heights(shells);
    for (std::size_t i = 0; i < shells; ++i) {
        const double t = static_cast<double>(i) / static_cast<double>(shells - 1);
        heights[i] = air.top_km * t * t;
    }
    return heights;
}

template <class T>
void solve(const ScatteringAtmosphere& air, const FieldResolution& resolution, const std::vector<double>& heights,
           const std::vector<ShellRay<T>>& rays, const FieldAngles& angles, const SunAt& sun_at,
           ScatteredField<T>& out) {
    assert(resolution.heights >= 3 && resolution.zeniths >= 1 && resolution.azimuths >= 2 &&
           resolution.azimuths % 2 == 0 && resolution.orders >= 2);
    assert(static_cast<std::size_t>(resolution.azimuths) <= most_azimuths && angles.count % 16 == 0);
    const auto shells = static_cast<std::size_t>(resolution.heights);
    const auto azimuths = static_cast<std::size_t>(resolution.azimuths);
    const auto count = static_cast<std::size_t>(angles.count);
    assert(resolution.bands >= 3 && resolution.bands <= most_field_bands);
    const auto bands = static_cast<std::size_t>(resolution.bands);
    const std::size_t functions = bands * (bands + 1) / 2;
    out.angles = angles;
    out.heights = resolution.heights;
    out.bands = resolution.bands;
    std::array<double, most_field_bands + 1> all_bands{};
    cornette_shanks_bands(air.mie_g, resolution.bands, all_bands);
    std::copy_n(all_bands.begin(), bands, out.phase_bands.begin());
    const double forward = out.forward = all_bands[bands];
    const std::array<double, most_field_bands>& beta = out.phase_bands;
    const double mean = beta[1];

    // The sun.
    std::vector<T> cosine(count);
    std::vector<T> sine(count);
    std::vector<std::array<double, most_field_functions>> sun_shape(count);
    for (std::size_t j = 0; j < count; ++j) {
        const double theta = angles.low_rad + angles.step_rad * static_cast<double>(j);
        cosine[j] = static_cast<T>(std::cos(theta));
        sine[j] = static_cast<T>(std::sin(theta)); // below 0 beyond the zenith
        field_shapes(resolution.bands, std::cos(theta), std::sin(theta), sun_shape[j]);
    }
    out.sun.assign(shells * 3 * count, T(0));
    out.aureole.assign(shells * 3 * count, T(0));
    for (std::size_t i = 0; i < shells; ++i) {
        for (std::size_t j = 0; j < count; ++j) {
            glm::dvec3 light;
            glm::dvec3 depth;
            sun_at(heights[i], std::abs(angles.low_rad + angles.step_rad * static_cast<double>(j)), light, depth);
            for (std::size_t c = 0; c < 3; ++c) {
                const double x = light[static_cast<int>(c)];
                const double d = depth[static_cast<int>(c)];
                out.sun[(i * 3 + c) * count + j] = static_cast<T>(x);
                // Scattered forward once, with the share that goes straight on left in the ray.
                out.aureole[(i * 3 + c) * count + j] = static_cast<T>(
                    x > 0.0 ? x * (forward > 1e-6 ? std::expm1(std::min(forward * d, 80.0)) / forward : d) : 0.0);
            }
        }
    }

    SweepShape<T> shape{};
    shape.count = count;
    shape.row = count + 2 * row_pad;
    shape.g = static_cast<T>(air.mie_g);
    shape.twice = static_cast<T>(mean * mean);
    shape.forward = static_cast<T>(forward);
    // Rows of one ray: [azimuth][channel], padded.
    const std::size_t all = azimuths * 3 * shape.row;
    std::vector<T> light(all, T(0));
    std::vector<T> rest(all, T(0));
    std::vector<T> scratch(shape.row, T(0));
    std::array<std::vector<T>, 2> rayleigh{std::vector<T>(all, T(0)), std::vector<T>(all, T(0))};
    std::array<std::vector<T>, 2> mie = rayleigh;
    const std::size_t level = functions * 3 * count; // of one shell
    std::vector<T> source_r(shells * level);         // what molecules and aerosol scatter, weighted by their bands
    std::vector<T> source_m(shells * level);
    std::vector<T> order(shells * level);
    std::vector<T> before(shells * level);
    std::vector<T> ground_now(3 * count); // irradiance that the ground reflects in this order
    std::vector<T> ground_next(3 * count);
    out.field.assign(shells * level, T(0));
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t j = 0; j < count; ++j) {
            ground_now[c * count + j] = out.sun[c * count + j] * std::max(cosine[j], T(0));
        }
    }
    out.ground = ground_now;

    // Y_lm of a ray's direction at a shell, times a factor; downward directions mirror the upward ones.
    std::array<T, most_field_functions> y{};
    const auto shapes_of = [&](const ShellRay<T>& ray, std::size_t k, bool up, double factor) {
        const T* from = ray.shapes.data() + k * functions;
        const T flip = up ? T(1) : T(-1);
        std::size_t f = 0;
        for (std::size_t m = 0; m < shape.bands; ++m) {
            T sign = static_cast<T>(factor);
            const T* row = from + field_function(resolution.bands, m, m);
            for (std::size_t l = m; l < shape.bands; ++l, ++f) {
                y[f] = sign * row[l - m];
                sign *= flip;
            }
        }
    };
    // From the third order on light is smooth: fewer bands and azimuths.
    const auto set_shape = [&](int with_bands, int with_azimuths) {
        shape.bands = static_cast<std::size_t>(with_bands);
        shape.azimuths = static_cast<std::size_t>(with_azimuths);
        for (std::size_t n = 0; n < shape.azimuths; ++n) {
            for (std::size_t m = 0; m < shape.bands; ++m) {
                shape.cosine[n][m] = static_cast<T>(
                    std::cos(static_cast<double>(m) * pi * (static_cast<double>(n) + 0.5) / with_azimuths));
            }
        }
    };
    set_shape(resolution.bands, resolution.azimuths);
    std::size_t level_before = level;
    for (int sweep = 1; sweep <= resolution.orders; ++sweep) {
        const std::size_t level_now = shape.bands * (shape.bands + 1) / 2 * 3 * count;
        std::fill(order.begin(), order.end(), T(0));
        std::fill(ground_next.begin(), ground_next.end(), T(0));
        // The source at a shell towards a direction, into one of the two ends.
        const auto fill_source = [&](std::size_t end, const ShellRay<T>& ray, std::size_t k, bool up) {
            const std::size_t i = ray.lowest + k;
            const double mu = up ? ray.mu[k] : -ray.mu[k];
            const auto z = static_cast<T>(mu);
            const auto s = static_cast<T>(std::sqrt(std::max(1.0 - mu * mu, 0.0)));
            T* r = rayleigh[end].data() + row_pad;
            T* a = mie[end].data() + row_pad;
            if (sweep == 1) {
                single_source(shape, z, s, cosine.data(), sine.data(), out.sun.data() + i * 3 * count, r, a);
                return;
            }
            shapes_of(ray, k, up, 1.0);
            field_source(shape, y.data(), source_r.data() + i * level_now, source_m.data() + i * level_now, r, a);
            if (sweep == 2) {
                aureole_source(shape, z, s, cosine.data(), sine.data(), out.aureole.data() + i * 3 * count, a);
            }
        };
        // Carries light one layer on, to the near end.
        const auto carry = [&](const CarryWeights<T>& through, double angle, std::size_t near) {
            const double shift = -angle / angles.step_rad;
            assert(std::abs(shift) < static_cast<double>(row_pad) - 3.0);
            const std::size_t far = 1 - near;
            carry_light(shape, through, shift, rayleigh[near].data() + row_pad, mie[near].data() + row_pad,
                        rayleigh[far].data() + row_pad, mie[far].data() + row_pad, light.data() + row_pad,
                        scratch.data());
        };
        // Adds the light that arrives at a shell to the field.
        const auto gather = [&](const ShellRay<T>& ray, std::size_t k, bool up) {
            const std::size_t i = ray.lowest + k;
            const double mu = up ? ray.mu[k] : -ray.mu[k];
            const double weight = ray.weight[k];
            if (weight == 0.0) {
                return;
            }
            const double w = weight * two_pi / static_cast<double>(shape.azimuths);
            const T* from = light.data() + row_pad;
            if (sweep == 1) {
                // The aureole stands apart: it is taken out as if the sky were all around as it is towards the sun.
                without_aureole(shape, static_cast<T>(mu), static_cast<T>(std::sqrt(std::max(1.0 - mu * mu, 0.0))),
                                cosine.data(), sine.data(), out.aureole.data() + i * 3 * count, from,
                                rest.data() + row_pad);
                from = rest.data() + row_pad;
            }
            shapes_of(ray, k, up, w);
            gather_light(shape, y.data(), from, order.data() + i * level_now,
                         i == 0 && mu > 0.0 ? static_cast<T>(w * mu) : T(0), ground_next.data());
        };

        for (const ShellRay<T>& ray : rays) {
            const std::size_t last = ray.mu.size() - 1;
            std::fill(light.begin(), light.end(), T(0));
            std::size_t near = 0;
            fill_source(1, ray, last, true);
            gather(ray, last, true);
            for (std::size_t k = last; k-- > 0;) {
                fill_source(near, ray, k, true);
                carry(ray.up[k], ray.angle[k], near);
                gather(ray, k, true);
                near = 1 - near;
            }
            if (ray.ground) {
                for (std::size_t n = 0; n < shape.azimuths; ++n) {
                    for (std::size_t c = 0; c < 3; ++c) {
                        T* to = light.data() + (n * 3 + c) * shape.row + row_pad;
                        const auto albedo = static_cast<T>(air.ground_albedo[static_cast<int>(c)] / pi);
                        for (std::size_t j = 0; j < count; ++j) {
                            to[j] = albedo * ground_now[c * count + j];
                        }
                    }
                }
            }
            if (ray.ground) {
                fill_source(1, ray, 0, false);
                gather(ray, 0, false);
            } else {
                // At the tangent point the ray goes on level: what comes from beyond is what came from there.
                fill_source(1, ray, 0, true);
            }
            near = 0;
            for (std::size_t k = 1; k <= last; ++k) {
                fill_source(near, ray, k, false);
                carry(ray.down[k - 1], ray.angle[k - 1], near);
                gather(ray, k, false);
                near = 1 - near;
            }
        }
        if (sweep == 1) {
            // The aureole on the ground, by the bands of the clamped cosine: (2 l + 1) times the integral of z P_l over
            // 0 .. 1, over 2.
            constexpr std::array<double, 9> clamped{0.25, 0.5,        0.3125, 0.0,         -0.09375,
                                                    0.0,  0.05078125, 0.0,    -0.033203125};
            for (std::size_t j = 0; j < count; ++j) {
                const auto z = static_cast<double>(cosine[j]);
                double share = 0.0;
                double before_l = 0.0;
                double now = 1.0;
                for (std::size_t l = 0; l < std::min<std::size_t>(clamped.size(), bands); ++l) {
                    share += clamped[l] * beta[l] * now;
                    const auto n = static_cast<double>(l);
                    const double next = ((2.0 * n + 1.0) * z * now - n * before_l) / (n + 1.0);
                    before_l = now;
                    now = next;
                }
                for (std::size_t c = 0; c < 3; ++c) {
                    ground_next[c * count + j] += out.aureole[c * count + j] * static_cast<T>(std::max(share, 0.0));
                }
            }
        }
        // The rest of the series from the ratio of the last two orders.
        if (sweep == resolution.orders) {
            for (std::size_t i = 0; i < shells; ++i) {
                for (std::size_t c = 0; c < 3; ++c) {
                    for (std::size_t j = 0; j < count; ++j) {
                        const double a = static_cast<double>(before[i * level_before + c * count + j]);
                        const double b = static_cast<double>(order[i * level_now + c * count + j]);
                        const double ratio = a > 0.0 ? std::clamp(b / a, 0.0, 0.9) : 0.0;
                        const T scale = static_cast<T>(1.0 / (1.0 - ratio));
                        for (std::size_t f = 0; f < level_now / (3 * count); ++f) {
                            order[i * level_now + (f * 3 + c) * count + j] *= scale;
                        }
                        if (i == 0) {
                            ground_next[c * count + j] *= scale;
                        }
                    }
                }
            }
        }
        for (std::size_t i = 0; i < shells; ++i) {
            const T* from = order.data() + i * level_now;
            for (std::size_t m = 0; m < shape.bands; ++m) {
                const std::size_t run = (shape.bands - m) * 3 * count; // functions of one m stand together
                T* to = out.field.data() + i * level + field_function(resolution.bands, m, m) * 3 * count;
                for (std::size_t k = 0; k < run; ++k) {
                    to[k] += from[k];
                }
                from += run;
            }
        }
        for (std::size_t k = 0; k < ground_next.size(); ++k) {
            out.ground[k] += ground_next[k];
        }
        if (sweep == resolution.orders) {
            break;
        }
        ground_now = ground_next;
        const std::size_t bands_now = shape.bands;
        if (sweep == 2) {
            set_shape(std::min(resolution.late_bands, resolution.bands),
                      std::min(resolution.late_azimuths, resolution.azimuths));
        }
        const std::size_t level_next = shape.bands * (shape.bands + 1) / 2 * 3 * count;
        // The next source. Rayleigh's bands are 1, 0, 1/10.
        for (std::size_t i = 0; i < shells; ++i) {
            for (std::size_t m = 0; m < shape.bands; ++m) {
                for (std::size_t l = m; l < shape.bands; ++l) {
                    const std::size_t f = field_function(static_cast<int>(bands_now), l, m);
                    const std::size_t g = field_function(static_cast<int>(shape.bands), l, m);
                    const auto molecules = static_cast<T>(l == 0 ? 1.0 : l == 2 ? 0.1 : 0.0);
                    const auto aerosol = static_cast<T>(beta[l]);
                    const auto lack = static_cast<T>(beta[l] * beta[l] - std::pow(mean, 2.0 * static_cast<double>(l)));
                    const auto less = static_cast<T>(beta[l] - forward);
                    for (std::size_t c = 0; c < 3; ++c) {
                        const std::size_t at = i * level_now + (f * 3 + c) * count;
                        const std::size_t to = i * level_next + (g * 3 + c) * count;
                        for (std::size_t j = 0; j < count; ++j) {
                            T of_molecules = order[at + j];
                            T of_aerosol = order[at + j] * less;
                            if (sweep == 1) {
                                const T peak = out.aureole[(i * 3 + c) * count + j] *
                                               static_cast<T>(sun_shape[j][l * (l + 1) / 2 + m]);
                                of_molecules += peak * aerosol;
                                // What Henyey-Greenstein's function of the squared mean lacks of the true one.
                                of_aerosol += peak * lack;
                            }
                            source_r[to + j] = of_molecules * molecules;
                            source_m[to + j] = of_aerosol;
                        }
                    }
                }
            }
        }
        level_before = level_now;
        std::swap(before, order);
    }
}

} // namespace

template <class T>
void build_scattered_field(const ScatteringAtmosphere& air, const FieldResolution& resolution,
                           std::span<const FieldAngles> angles, const SunAt& sun_at, std::span<ScatteredField<T>> out) {
    const std::vector<double> heights = shell_heights(air, static_cast<std::size_t>(resolution.heights));
    std::array<double, most_field_bands + 1> phase{};
    cornette_shanks_bands(air.mie_g, resolution.bands, phase);
    std::vector<ShellRay<T>> rays =
        make_rays<T>(air, heights, resolution.zeniths, static_cast<std::size_t>(resolution.all_tangents),
                     phase[static_cast<std::size_t>(resolution.bands)]);
    const auto bands = static_cast<std::size_t>(resolution.bands);
    std::array<double, most_field_functions> shapes{};
    for (ShellRay<T>& ray : rays) {
        ray.shapes.reserve(ray.mu.size() * bands * (bands + 1) / 2);
        for (const double mu : ray.mu) {
            field_shapes(resolution.bands, mu, std::sqrt(std::max(1.0 - mu * mu, 0.0)), shapes);
            for (std::size_t m = 0; m < bands; ++m) {
                for (std::size_t l = m; l < bands; ++l) {
                    ray.shapes.push_back(static_cast<T>(shapes[l * (l + 1) / 2 + m]));
                }
            }
        }
    }
    for (std::size_t k = 0; k < angles.size(); ++k) {
        solve(air, resolution, heights, rays, angles[k], sun_at, out[k]);
    }
}

template void build_scattered_field(const ScatteringAtmosphere&, const FieldResolution&, std::span<const FieldAngles>,
                                    const SunAt&, std::span<ScatteredField<float>>);
template void build_scattered_field(const ScatteringAtmosphere&, const FieldResolution&, std::span<const FieldAngles>,
                                    const SunAt&, std::span<ScatteredField<double>>);

} // namespace alpenglow::sky
