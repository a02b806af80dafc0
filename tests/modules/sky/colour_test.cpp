#include <alpenglow/sky/colour.hpp>

#include <gtest/gtest.h>

#include <algorithm>

namespace alpenglow::sky {
namespace {

// The tables integrate to the illuminants that the literature prints.
TEST(Colour, DaylightSpectrumReturnsItsChromaticity) {
    // D65, D55, D75 and two skies off the locus.
    for (const glm::dvec2 xy : {glm::dvec2(0.3127, 0.3290), glm::dvec2(0.3324, 0.3474), glm::dvec2(0.2990, 0.3149),
                                glm::dvec2(0.26, 0.27), glm::dvec2(0.38, 0.38)}) {
        const glm::dvec3 xyz = spectrum_to_xyz(daylight_spectrum(xy));
        const double sum = xyz.x + xyz.y + xyz.z;
        EXPECT_NEAR(xyz.x / sum, xy.x, 1.5e-3);
        EXPECT_NEAR(xyz.y / sum, xy.y, 1.5e-3);
    }
}

TEST(Colour, D65IsWhite) {
    const glm::dvec3 rgb = yxy_to_rec709(glm::dvec3(100.0, 0.3127, 0.3290));
    EXPECT_NEAR(rgb.x, 100.0, 0.02);
    EXPECT_NEAR(rgb.y, 100.0, 0.02);
    EXPECT_NEAR(rgb.z, 100.0, 0.02);
}

TEST(Colour, RecLuminanceIsY) {
    for (double x = 0.2; x < 0.5; x += 0.05) {
        for (double y = 0.2; y < 0.5; y += 0.05) {
            EXPECT_NEAR(luminance(yxy_to_rec709(glm::dvec3(1.0, x, y))), 1.0, 3e-4) << x << ' ' << y;
        }
    }
}

TEST(Colour, EqualEnergySpectrumLooksEqual) {
    Spectrum flat;
    flat.fill(1.0);
    const glm::dvec3 xyz = spectrum_to_xyz(flat);
    EXPECT_NEAR(xyz.x / xyz.y, 1.0, 2e-3);
    EXPECT_NEAR(xyz.z / xyz.y, 1.0, 2e-3);
}

TEST(Colour, GamutRuleKeepsLuminanceAndReachesTheBorder) {
    const glm::dvec3 out(-0.5, 1.0, 0.3);
    const glm::dvec3 in = into_gamut(out);
    EXPECT_NEAR(luminance(in), luminance(out), 1e-12);
    EXPECT_EQ(std::min({in.x, in.y, in.z}), 0.0);
    const glm::dvec3 inside(0.2, 0.4, 0.1);
    EXPECT_EQ(into_gamut(inside), inside);
    EXPECT_EQ(into_gamut(glm::dvec3(-1.0, -1.0, -1.0)), glm::dvec3(0.0));
    EXPECT_EQ(yxy_to_rec709(glm::dvec3(1.0, 0.3, 0.0)), glm::dvec3(0.0));
}

} // namespace
} // namespace alpenglow::sky
