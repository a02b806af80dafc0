#include <alpenglow/sky/horizon_filter.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

using Coefficients = std::array<glm::dvec3, 49>;

struct Error {
    double ringing, blur; // root mean square below and above the horizon, relative to the sky's above
};

Error error_of(const Coefficients& c, double theta, double turbidity) {
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
            const glm::dvec3 got = sh::evaluate(7, c, up);
            const glm::dvec3 down = sh::evaluate(7, c, glm::dvec3(up.x, up.y, -z));
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

// Against the paper's filter: with no more blur above the horizon, much less ringing below it.
TEST(HorizonFilter, BeatsTheSinc) {
    for (double theta : {0.2, 0.9, 1.4}) {
        Coefficients plain{};
        project_preetham(theta, 3.0, 7, {16, 24}, plain);
        Coefficients sinc = plain;
        filter_zonal_sinc(7, sinc);
        Coefficients ours = plain;
        HorizonFilter(7, 1.4).apply(ours);
        const Error none = error_of(plain, theta, 3.0);
        const Error theirs = error_of(sinc, theta, 3.0);
        const Error mine = error_of(ours, theta, 3.0);
        EXPECT_LT(mine.ringing, 0.9 * none.ringing);
        EXPECT_LT(mine.ringing, theirs.ringing) << theta;
        EXPECT_LT(mine.blur, theirs.blur) << theta;
        std::printf("theta %.1f: ringing / blur none %.3f / %.3f, sinc %.3f / %.3f, ours %.3f / %.3f\n", theta,
                    none.ringing, none.blur, theirs.ringing, theirs.blur, mine.ringing, mine.blur);
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
