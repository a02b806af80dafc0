#include <alpenglow/sky/horizon_filter.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

using Coefficients = std::array<glm::dvec3, 49>;

struct Error {
    double ringing, blur; // root mean square below and above the horizon, relative to the sky's above
};

Error error_of(const Coefficients& c, int bands, double theta, double turbidity) {
    const auto sky = make_preetham(glm::dvec3(std::sin(theta), 0.0, std::cos(theta)), turbidity);
    double below = 0.0;
    double above = 0.0;
    double norm = 0.0;
    const int n = 32;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const double z = (i + 0.5) / n;
            const double a = pi * (j + 0.5) / n;
            const double r = std::sqrt(1.0 - z * z);
            const glm::dvec3 up(r * std::cos(a), r * std::sin(a), z);
            const glm::dvec3 want = radiance(sky, up);
            const glm::dvec3 got = sh::evaluate(bands, c, up);
            const glm::dvec3 down = sh::evaluate(bands, c, glm::dvec3(up.x, up.y, -z));
            above += glm::dot(got - want, got - want);
            below += glm::dot(down, down);
            norm += glm::dot(want, want);
        }
    }
    return {std::sqrt(below / norm), std::sqrt(above / norm)};
}

TEST(HorizonFilter, WeightOneChangesNothing) {
    Coefficients c{};
    project_preetham(0.9, 3.0, 7, {12, 16}, c);
    Coefficients same = c;
    HorizonFilter(7, 1.0).apply(same);
    for (std::size_t i = 0; i < c.size(); ++i) {
        EXPECT_LT(glm::length(same[i] - c[i]), 1e-9 * glm::length(c[0]));
    }
}

// The weight whose filter blurs the sky above the horizon as much as the paper's does.
double weight_of_equal_blur(const Coefficients& plain, int bands, double theta, double blur) {
    double low = 0.0;
    double high = 6.0; // of the weight's logarithm
    for (int i = 0; i < 24; ++i) {
        const double middle = 0.5 * (low + high);
        Coefficients c = plain;
        HorizonFilter(bands, std::exp(middle)).apply(c);
        (error_of(c, bands, theta, 3.0).blur < blur ? low : high) = middle;
    }
    return std::exp(0.5 * (low + high));
}

// Against the paper's filter: at its own blur above the horizon, less ringing below; and one weight for all heights of
// the sun, 1.4, that rings less everywhere and with 7 bands is better in both.
TEST(HorizonFilter, BeatsTheSinc) {
    for (int bands : {3, 5, 7}) {
        for (double theta : {0.2, 0.9, 1.4}) {
            Coefficients plain{};
            project_preetham(theta, 3.0, bands, {16, 24}, plain);
            Coefficients sinc = plain;
            filter_zonal_sinc(bands, sinc);
            const Error none = error_of(plain, bands, theta, 3.0);
            const Error theirs = error_of(sinc, bands, theta, 3.0);
            const double weight = weight_of_equal_blur(plain, bands, theta, theirs.blur);
            Coefficients ours = plain;
            HorizonFilter(bands, weight).apply(ours);
            const Error equal = error_of(ours, bands, theta, 3.0);
            ours = plain;
            HorizonFilter(bands, 1.4).apply(ours);
            const Error fixed = error_of(ours, bands, theta, 3.0);
            std::printf("%d bands, theta %.1f: ringing / blur none %.3f / %.3f, sinc %.3f / %.3f, weight %.2f %.3f / "
                        "%.3f, weight 1.4 %.3f / %.3f\n",
                        bands, theta, none.ringing, none.blur, theirs.ringing, theirs.blur, weight, equal.ringing,
                        equal.blur, fixed.ringing, fixed.blur);
            // The optimum for its weight: no vector of these bands rings less at that blur.
            EXPECT_LE(equal.blur, 1.001 * theirs.blur);
            EXPECT_LT(equal.ringing, (bands == 3   ? 0.95
                                      : bands == 5 ? 0.88
                                                   : 0.8) *
                                         theirs.ringing)
                << bands << ' ' << theta;
            EXPECT_LT(fixed.ringing, 0.9 * none.ringing);
            EXPECT_LT(fixed.ringing, theirs.ringing) << bands << ' ' << theta;
            if (bands == 7) {
                EXPECT_LT(fixed.blur, theirs.blur) << theta;
            }
        }
    }
}

TEST(HorizonFilter, CommutesWithTheAzimuth) {
    Coefficients c{};
    project_preetham(0.9, 3.0, 7, {12, 16}, c);
    const glm::dvec3 to_sun(std::cos(2.0) * std::sin(0.9), std::sin(2.0) * std::sin(0.9), std::cos(0.9));
    Coefficients first = c;
    const HorizonFilter filter(7, 5.0);
    filter.apply(first);
    rotate_symmetric_sky(to_sun, 7, first);
    Coefficients second = c;
    rotate_symmetric_sky(to_sun, 7, second);
    filter.apply(second);
    for (std::size_t i = 0; i < c.size(); ++i) {
        EXPECT_LT(glm::length(first[i] - second[i]), 1e-9 * glm::length(c[0]));
    }
}

TEST(HorizonFilter, FilteredFitsGiveFilteredSkies) {
    const glm::vec3 to_sun = glm::normalize(glm::vec3(0.5F, -0.3F, 0.2F));
    for (int bands : {2, 3, 5, 7}) {
        const HorizonFilter filter(bands, 1.4);
        const SkyFit least_squares = filtered_fit(preetham_fit(), filter);
        const SkyFit sinc = filtered_fit_zonal_sinc(preetham_fit(), bands);
        for (float turbidity : {2.1F, 3.0F, 8.0F}) {
            const std::array others{turbidity};
            std::array<glm::vec3, 49> want{};
            std::array<glm::vec3, 49> got{};
            SkyFitEvaluator(preetham_fit()).evaluate_uncached(to_sun, others, bands, want);
            std::array<glm::vec3, 49> want_sinc = want;
            filter.apply(std::span<glm::vec3>(want));
            filter_zonal_sinc(bands, std::span<glm::vec3>(want_sinc));
            SkyFitEvaluator(least_squares).evaluate_uncached(to_sun, others, bands, got);
            for (std::size_t i = 0; i < static_cast<std::size_t>(bands * bands); ++i) {
                EXPECT_LT(glm::length(got[i] - want[i]), 3e-6F * glm::length(want[0])) << bands << ' ' << i;
            }
            SkyFitEvaluator(sinc).evaluate_uncached(to_sun, others, bands, got);
            for (std::size_t i = 0; i < static_cast<std::size_t>(bands * bands); ++i) {
                EXPECT_LT(glm::length(got[i] - want_sinc[i]), 3e-6F * glm::length(want[0])) << bands << ' ' << i;
            }
        }
    }
}

TEST(HorizonFilter, SincAsPrinted) {
    Coefficients c{};
    c.fill(glm::dvec3(1.0));
    filter_zonal_sinc(7, c);
    EXPECT_EQ(c[0], glm::dvec3(1.0));
    EXPECT_NEAR(c[6].x, std::sin(2.0 * pi / 7.0) / (2.0 * pi / 7.0), 1e-12);
    EXPECT_EQ(c[7], glm::dvec3(1.0)); // only zonal terms
}

} // namespace
} // namespace alpenglow::sky
