#include "bench.hpp"
#include "sky_support.hpp"

#include <alpenglow/components/celestial.hpp>
#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sky/aerial_perspective.hpp>
#include <alpenglow/sky/dome.hpp>
#include <alpenglow/sky/fit_sky.hpp>
#include <alpenglow/sky/horizon_filter.hpp>
#include <alpenglow/sky/night_sky.hpp>
#include <alpenglow/sky/preetham.hpp>
#include <alpenglow/sky/sky_fit.hpp>
#include <alpenglow/sky/sky_sh.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/sky/sun_light.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

const Case radiance_case("sky/preetham radiance", [](const Context& context) {
    const std::vector<glm::vec3> directions = hemisphere(4096);
    const glm::vec3 to_sun = glm::normalize(glm::vec3(0.5F, 0.3F, 0.6F));
    const auto reference = sky::make_preetham(glm::dvec3(to_sun), 2.5);
    const auto model = sky::make_preetham(to_sun, 2.5F);
    Row row{.module = "sky",
            .name = "preetham radiance",
            .method = "double, the reference",
            .error_metric = "max relative RGB, 4096 directions",
            .reference = "double libm",
            .items = static_cast<double>(directions.size())};
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(sky::radiance(reference, glm::dvec3(v)));
        }
    });
    row.method = "float scalar";
    for (const glm::vec3& v : directions) {
        row.error =
            std::max(row.error, relative(glm::dvec3(sky::radiance(model, v)), sky::radiance(reference, glm::dvec3(v))));
    }
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(sky::radiance(model, v));
        }
    });
    sky::DomeParameters parameters;
    parameters.to_sun = to_sun;
    const auto dome = sky::make_dome<float>(parameters);
    std::vector<float> x, y, z;
    for (const glm::vec3& v : directions) {
        x.push_back(v.x);
        y.push_back(v.y);
        z.push_back(v.z);
    }
    std::vector<float> r(x.size()), g(x.size()), b(x.size());
    sky::radiance(dome, {x, y, z}, {r, g, b});
    row.method = "float batch";
    row.error = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        row.error = std::max(
            row.error, relative(glm::dvec3(r[i], g[i], b[i]), sky::radiance(reference, glm::dvec3(directions[i]))));
    }
    context.run(row, [&] {
        sky::radiance(dome, {x, y, z}, {r, g, b});
        keep(r[0]);
    });
});

// The paper's own form: monomials theta^i tau^j of degrees 13 and 7, least squares in double precision over a dense
// grid (Habel et al. 2008, eq. 1), evaluated with all products of powers made once.
class PaperFit {
public:
    PaperFit() {
        // Least squares over Chebyshev-spaced samples is interpolation in a Chebyshev basis of those degrees, turned
        // into monomials of theta and tau exactly as far as double goes.
        constexpr int ni = 32, nj = 24;
        std::vector<double> values(ni * nj * 84);
        const sky::SkyBlackBox box = sky::preetham_black_box(48, 60);
        for (int i = 0; i < ni; ++i) {
            for (int j = 0; j < nj; ++j) {
                std::array<glm::dvec3, 49> c{};
                const double theta = 0.25 * pi * (1.0 + std::cos(pi * (i + 0.5) / ni));
                const double tau = 4.25 + 1.75 * std::cos(pi * (j + 0.5) / nj);
                static_cast<void>(box(std::array{theta, tau}, 7, c));
                double* to = &values[static_cast<std::size_t>((i * nj + j) * 84)];
                for (int l = 0; l < 7; ++l) {
                    for (int m = 0; m <= l; ++m, to += 3) {
                        const glm::dvec3& v = c[static_cast<std::size_t>(l * (l + 1) + m)];
                        to[0] = v.x;
                        to[1] = v.y;
                        to[2] = v.z;
                    }
                }
            }
        }
        const auto pi_theta = powers(13, 0.25 * pi, 0.25 * pi);
        const auto pj_tau = powers(7, 4.25, 1.75);
        for (int p = 0; p <= 13; ++p) {
            for (int q = 0; q <= 7; ++q) {
                std::array<double, 84> c{};
                for (int i = 0; i < ni; ++i) {
                    for (int j = 0; j < nj; ++j) {
                        const double w = std::cos(pi * p * (i + 0.5) / ni) * std::cos(pi * q * (j + 0.5) / nj) *
                                         (p == 0 ? 1.0 : 2.0) * (q == 0 ? 1.0 : 2.0) / (ni * nj);
                        for (std::size_t f = 0; f < 84; ++f) {
                            c[f] += w * values[static_cast<std::size_t>((i * nj + j) * 84) + f];
                        }
                    }
                }
                for (std::size_t a = 0; a <= 13; ++a) {
                    for (std::size_t b = 0; b <= 7; ++b) {
                        const double k =
                            pi_theta[static_cast<std::size_t>(p)][a] * pj_tau[static_cast<std::size_t>(q)][b];
                        for (std::size_t f = 0; f < 84; ++f) {
                            coefficients_[f * 112 + a * 8 + b] += k * c[f];
                        }
                    }
                }
            }
        }
    }

    // As the paper says: the matrix of products once, then for each coefficient a component-wise product and sum; all
    // 49 coefficients, the sine terms being fitted like the others.
    void evaluate(double theta, double tau, int bands, std::span<glm::dvec3> out) const {
        std::array<double, 112> products;
        double x = 1.0;
        for (std::size_t a = 0; a < 14; ++a, x *= theta) {
            double y = x;
            for (std::size_t b = 0; b < 8; ++b, y *= tau) {
                products[a * 8 + b] = y;
            }
        }
        for (int l = 0; l < bands; ++l) {
            for (int m = -l; m <= l; ++m) {
                const int f = 3 * (l * (l + 1) / 2 + std::abs(m));
                glm::dvec3 sum(0.0);
                for (int q = 0; q < 3; ++q) {
                    const double* c = &coefficients_[static_cast<std::size_t>(f + q) * 112];
                    double s = 0.0;
                    for (std::size_t k = 0; k < 112; ++k) {
                        s += c[k] * products[k];
                    }
                    sum[q] = m < 0 ? 0.0 * s : s;
                }
                out[static_cast<std::size_t>(l * (l + 1) + m)] = sum;
            }
        }
    }

private:
    // Chebyshev polynomials of (x - centre) / half in powers of x.
    static std::vector<std::vector<double>> powers(int degree, double centre, double half) {
        std::vector<std::vector<double>> t{{1.0}, {-centre / half, 1.0 / half}};
        for (int k = 2; k <= degree; ++k) {
            const auto n = static_cast<std::size_t>(k);
            std::vector<double> next(n + 1, 0.0);
            for (std::size_t i = 0; i < n; ++i) {
                next[i] -= 2.0 * centre / half * t[n - 1][i];
                next[i + 1] += 2.0 / half * t[n - 1][i];
            }
            for (std::size_t i = 0; i + 1 < n; ++i) {
                next[i] -= t[n - 2][i];
            }
            t.push_back(next);
        }
        for (auto& row : t) {
            row.resize(static_cast<std::size_t>(degree + 1), 0.0);
        }
        return t;
    }
    std::vector<double> coefficients_ = std::vector<double>(84 * 112, 0.0);
};

const Case fit_case("sky/preetham to SH by fits", [](const Context& context) {
    const sky::SkyBlackBox box = sky::preetham_black_box(48, 60);
    const sky::SkyFit& fit = sky::preetham_fit();
    sky::SkyFitEvaluator evaluator(fit);
    const PaperFit paper;
    std::vector<std::array<double, 2>> points; // the paper's domain: theta 0 .. 90 degrees, turbidity 2.5 .. 6
    const int count = context.quick() ? 40 : 300;
    for (int i = 0; i < count; ++i) {
        points.push_back({0.5 * pi * std::fmod(0.618034 * i, 1.0), 2.5 + 3.5 * std::fmod(0.754878 * i, 1.0)});
        points.push_back({0.5 * pi * (1.0 - 1e-3 * (i % 10)), 2.5 + 3.5 * i / count}); // the horizon, the worst place
    }
    std::vector<std::array<glm::dvec3, 49>> exact(points.size());
    std::vector<double> least(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        least[i] = box(points[i], 7, exact[i]);
    }
    for (const int bands : {3, 5, 7}) {
        const auto used = static_cast<std::size_t>(bands * bands);
        std::array<glm::dvec3, 49> got{};
        const auto worst = [&](const auto& evaluate) {
            double e_mean = 0.0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                evaluate(points[i]);
                glm::dvec3 squares(0.0);
                for (std::size_t k = 0; k < used; ++k) {
                    squares += (got[k] - exact[i][k]) * (got[k] - exact[i][k]);
                }
                e_mean = std::max(e_mean, std::sqrt(std::max({squares.x, squares.y, squares.z})) / least[i]);
            }
            return e_mean;
        };
        Row row{.module = "sky",
                .name = "preetham to SH, " + std::to_string(bands) + " bands, fits",
                .method = "the paper's monomials 13 x 7, double",
                .error_metric = "worst E_mean (eq. 3), L_min least luminance, turbidity 2.5 to 6",
                .reference = "quadrature 2 x 48 x 60"};
        std::array<glm::vec3, 49> fast{};
        std::size_t at = 0;
        std::vector<glm::vec3> suns;
        std::vector<float> turbidities;
        for (std::size_t i = 0; i < 256; ++i) {
            turbidities.push_back(static_cast<float>(points[i % points.size()][1]));
            const double theta = points[i % points.size()][0];
            const double azimuth = static_cast<double>(i);
            suns.emplace_back(
                glm::dvec3(std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth), std::cos(theta)));
        }
        const auto by_paper = [&](const std::array<double, 2>& p) { paper.evaluate(p[0], p[1], bands, got); };
        row.error = worst(by_paper);
        row.bytes = 8.0 * 112 * 3 * static_cast<double>(used);
        context.run(row, [&] {
            by_paper(points[++at % points.size()]);
            sky::rotate_symmetric_sky(glm::dvec3(suns[at % 256]), bands, got);
            keep(got);
        });
        row.bytes = static_cast<double>(fit.bytes());
        row.method = "table, double reference";
        const auto by_reference = [&](const std::array<double, 2>& p) { sky::evaluate_fit(fit, p, bands, got); };
        row.error = worst(by_reference);
        context.run(row, [&] {
            by_reference(points[++at % points.size()]);
            keep(got);
        });
        const auto by_table = [&](const std::array<double, 2>& p) {
            const glm::vec3 sun(glm::dvec3(std::sin(p[0]), 0.0, std::cos(p[0])));
            evaluator.evaluate_uncached(sun, std::array{static_cast<float>(p[1])}, bands, fast);
            std::copy_n(fast.begin(), used, got.begin());
        };
        row.error = worst(by_table);
        row.method = "table, SIMD";
        context.run(row, [&] {
            ++at;
            evaluator.evaluate_uncached(suns[at % 256], std::span(&turbidities[at % 256], 1), bands, fast);
            keep(fast);
        });
        row.method = "table, SIMD, turbidity unchanged";
        context.run(row, [&] {
            evaluator.evaluate(suns[++at % 256], std::array{2.7F}, bands, fast);
            keep(fast);
        });
        for (const auto& [elevations, azimuths] : {std::pair{10, 14}, {16, 24}, {24, 32}}) {
            const auto by_quadrature = [&, n = elevations, m = azimuths](const std::array<double, 2>& p) {
                sky::project_preetham(p[0], p[1], bands, {n, m}, got);
            };
            row.method = "quadrature 2 x " + std::to_string(elevations) + " x " + std::to_string(azimuths);
            row.bytes = 0.0;
            row.error = worst(by_quadrature);
            context.run(row, [&] {
                by_quadrature(points[++at % points.size()]);
                keep(got);
            });
        }
    }
});

const Case quadrature_case("sky/preetham to SH by quadrature", [](const Context& context) {
    std::array<glm::dvec3, 49> exact{};
    std::array<glm::dvec3, 49> got{};
    const std::array<double, 4> thetas{0.05, 0.6, 1.2, 0.5 * pi};
    for (const auto& [elevations, azimuths] :
         {std::pair{4, 6}, {6, 8}, {8, 12}, {12, 16}, {16, 24}, {24, 32}, {40, 56}}) {
        Row row{.module = "sky",
                .name = "preetham to SH, 7 bands",
                .method = "quadrature 2 x " + std::to_string(elevations) + " x " + std::to_string(azimuths),
                .error_metric = "max |c' - c| / |c|, 4 sun heights, turbidity 2.5",
                .reference = "quadrature 2 x 128 x 160"};
        for (const double theta : thetas) {
            sky::project_preetham(theta, 2.5, 7, {128, 160}, exact);
            sky::project_preetham(theta, 2.5, 7, {elevations, azimuths}, got);
            double difference = 0.0;
            double norm = 0.0;
            for (std::size_t i = 0; i < exact.size(); ++i) {
                difference += glm::dot(got[i] - exact[i], got[i] - exact[i]);
                norm += glm::dot(exact[i], exact[i]);
            }
            row.error = std::max(row.error, std::sqrt(difference / norm));
        }
        context.run(row, [&, n = elevations, m = azimuths] {
            sky::project_preetham(0.6, 2.5, 7, {n, m}, got);
            keep(got);
        });
    }
});

const Case direct_case("sky/sun and state", [](const Context& context) {
    Row row{.module = "sky",
            .name = "direct light",
            .method = "sun, spectral",
            .error_metric = "is the reference",
            .reference = ""};
    context.run(row, [] { keep(sky::sun_illuminance_lux(0.5, 4.65e-3, 1.0, {})); });
    const sky::AirColumn aloft{.observer_height_m = 12e3};
    row.method = "sun, spectral, 12 km up, below the horizontal";
    context.run(row, [&] { keep(sky::sun_illuminance_lux(-0.05, 4.65e-3, 1.0, aloft)); });
    CelestialState celestial;
    celestial.to_sun = glm::normalize(glm::vec3(0.5F, 0.3F, 0.6F));
    const Atmosphere atmosphere;
    row.name = "sky state";
    row.method = "make_sky_state";
    context.run(row, [&] { keep(sky::make_sky_state(celestial, atmosphere)); });
    SkyState state = sky::make_sky_state(celestial, atmosphere);
    state.revision = 1;
    row.method = "drift_bound: the check that skips it";
    context.run(row, [&] { keep(sky::drift_bound(state, celestial, atmosphere)); });
});

const Case night_case("sky/night", [](const Context& context) {
    const glm::vec3 to_moon = glm::normalize(glm::vec3(0.8F, 0.0F, 0.6F));
    const sky::NightSky night = sky::make_night_sky(to_moon, 3.844e8F, 0.3F, 2.5F);
    const std::vector<glm::vec3> directions = hemisphere(1024);
    Row row{.module = "sky",
            .name = "moonlit night",
            .method = "radiance, a direction",
            .error_metric = "is the reference",
            .reference = "",
            .items = static_cast<double>(directions.size())};
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(sky::night_radiance(night, v));
        }
    });
    row.items = 1.0;
    row.method = "make_night_sky";
    context.run(row, [&] { keep(sky::make_night_sky(to_moon, 3.844e8F, 0.3F, 2.5F)); });
    std::array<glm::dvec3, 49> exact{};
    sky::project_symmetric_sky(
        [&](const glm::dvec3& v) { return glm::dvec3(sky::night_radiance(night, glm::vec3(v))); },
        std::acos(static_cast<double>(to_moon.z)), 7, {24, 32}, exact);
    row.name = "moonlit night to SH, 7 bands";
    row.error_metric = "|c' - c| / |c|";
    row.reference = "quadrature 2 x 24 x 32";
    const auto error_of = [&](const auto& got) {
        double difference = 0.0;
        double norm = 0.0;
        for (std::size_t i = 0; i < exact.size(); ++i) {
            const glm::dvec3 d = glm::dvec3(got[i]) - exact[i];
            difference += glm::dot(d, d);
            norm += glm::dot(exact[i], exact[i]);
        }
        return std::sqrt(difference / norm);
    };
    std::array<glm::vec3, 49> c{};
    sky::project_night_sky(night, 7, c);
    row.method = "series about the moon";
    row.error = error_of(c);
    context.run(row, [&] {
        sky::project_night_sky(night, 7, c);
        keep(c);
    });
    std::array<glm::dvec3, 49> coarse{};
    const auto quadrature = [&] {
        sky::project_symmetric_sky(
            [&](const glm::dvec3& v) { return glm::dvec3(sky::night_radiance(night, glm::vec3(v))); },
            std::acos(static_cast<double>(to_moon.z)), 7, {6, 8}, coarse);
    };
    quadrature();
    row.method = "quadrature 2 x 6 x 8";
    row.error = error_of(coarse);
    context.run(row, [&] {
        quadrature();
        keep(coarse);
    });
});

const Case filter_case("sky/horizon filter", [](const Context& context) {
    const double theta = 1.2;
    const auto model = sky::make_preetham(glm::dvec3(std::sin(theta), 0.0, std::cos(theta)), 3.0);
    const std::vector<glm::vec3> directions = hemisphere(2000);
    for (const int bands : {3, 5, 7}) {
        std::array<glm::dvec3, 49> plain{};
        sky::project_preetham(theta, 3.0, bands, {24, 32}, plain);
        Row row{.module = "sky",
                .name = "horizon filter, " + std::to_string(bands) + " bands",
                .method = "",
                .error_metric = "",
                .reference = "the sky above, 0 below"};
        const auto run = [&](const std::string& method, const auto& filter) {
            std::array<glm::dvec3, 49> c = plain;
            filter(c);
            double below = 0.0;
            double above = 0.0;
            double norm = 0.0;
            for (const glm::vec3& v : directions) {
                const glm::dvec3 up(v);
                const glm::dvec3 want = sky::radiance(model, up);
                const glm::dvec3 blur = sh::evaluate(bands, c, up) - want;
                const glm::dvec3 ringing = sh::evaluate(bands, c, glm::dvec3(up.x, up.y, -up.z));
                below += glm::dot(ringing, ringing);
                above += glm::dot(blur, blur);
                norm += glm::dot(want, want);
            }
            row.method = method;
            row.error = std::sqrt(below / norm);
            row.error_metric =
                "ringing below the horizon, RMS over the sky's; blur above " + std::to_string(std::sqrt(above / norm));
            std::array<glm::dvec3, 49> again{};
            context.run(row, [&] {
                again = plain;
                filter(again);
                keep(again);
            });
        };
        run("none", [](auto&) {});
        run("zonal sinc, eq. 5", [&](auto& c) { sky::filter_zonal_sinc(bands, c); });
        for (const double weight : {1.4, 3.0}) {
            const sky::HorizonFilter filter(bands, weight);
            run("least squares, weight " + std::to_string(weight).substr(0, 3), [&](auto& c) { filter.apply(c); });
        }
    }
});

const Case aerial_case("sky/aerial perspective", [](const Context& context) {
    const sky::Air air = sky::make_air(2.5F);
    const glm::vec3 sun = glm::normalize(glm::vec3(0.3F, 0.7F, 0.5F));
    const glm::vec3 lux(9e4F, 8.5e4F, 7.5e4F);
    const glm::vec3 ambient(3000.0F, 4000.0F, 6000.0F);
    std::vector<glm::vec4> paths; // direction, distance: from 1500 m height
    for (float rise : {-0.1F, -0.05F, 0.0F, 0.03F, 0.1F}) {
        for (float azimuth = 0.0F; azimuth < 6.2F; azimuth += 0.7F) {
            for (float distance : {200.0F, 1000.0F, 3000.0F, 10000.0F, 14000.0F}) {
                const float level = std::sqrt(1.0F - rise * rise);
                paths.emplace_back(level * std::cos(azimuth), level * std::sin(azimuth), rise, distance);
            }
        }
    }
    Row row{.module = "sky",
            .name = "aerial perspective",
            .method = "closed form, scalar",
            .error_metric = "max relative L_in, landscape paths to 14 km",
            .reference = "march of 4000 steps, double",
            .items = static_cast<double>(paths.size())};
    const auto error = [&](const auto& evaluate) {
        double worst = 0.0;
        for (const glm::vec4& p : paths) {
            const auto want = sky::march_aerial_perspective(air, 1500.0F, glm::vec3(p), p.w, sun, lux, ambient, 4000);
            worst = std::max(worst, relative(glm::dvec3(evaluate(p).in_scatter), glm::dvec3(want.in_scatter)));
        }
        return worst;
    };
    const auto closed = [&](const glm::vec4& p) {
        return sky::aerial_perspective(air, 1500.0F, glm::vec3(p), p.w, sun, lux, ambient);
    };
    row.error = error(closed);
    context.run(row, [&] {
        for (const glm::vec4& p : paths) {
            keep(closed(p));
        }
    });
    // An image's pixels: the same paths over and over, so that the whole works on more than a vector.
    std::array<std::vector<float>, 4> in;
    for (std::size_t i = 0; i < 16 * paths.size(); ++i) {
        for (int k = 0; k < 4; ++k) {
            in[static_cast<std::size_t>(k)].push_back(paths[i % paths.size()][k]);
        }
    }
    std::array<std::vector<float>, 6> out;
    out.fill(std::vector<float>(in[0].size()));
    const auto batch = [&] {
        sky::aerial_perspective(air, 1500.0F, sun, lux, ambient, {in[0], in[1], in[2], in[3]},
                                {out[0], out[1], out[2], out[3], out[4], out[5]});
    };
    batch();
    std::size_t at = 0;
    row.method = "closed form, batch";
    row.error = error([&](const glm::vec4&) {
        const std::size_t i = at++;
        return sky::AerialPerspective{{out[0][i], out[1][i], out[2][i]}, {out[3][i], out[4][i], out[5][i]}};
    });
    row.items = static_cast<double>(in[0].size());
    context.run(row, batch);
    row.items = static_cast<double>(paths.size());
    for (int steps : {4, 16, 64}) {
        const auto march = [&](const glm::vec4& p) {
            return sky::march_aerial_perspective(air, 1500.0F, glm::vec3(p), p.w, sun, lux, ambient, steps);
        };
        row.method = "march, " + std::to_string(steps) + " steps";
        row.error = error(march);
        context.run(row, [&] {
            for (const glm::vec4& p : paths) {
                keep(march(p));
            }
        });
    }
});

} // namespace
} // namespace alpenglow::bench
