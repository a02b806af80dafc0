#include <alpenglow/sky/dome.hpp>

#include <alpenglow/core/constants.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

glm::dvec3 towards(double altitude_deg, double azimuth_deg) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return {std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a)};
}

constexpr std::array models{DomeModel::preetham,     DomeModel::perez,    DomeModel::cie_clear,
                            DomeModel::cie_overcast, DomeModel::asrc_cie, DomeModel::cie_general};

std::vector<DomeParameters> many() {
    std::vector<DomeParameters> out;
    for (const DomeModel model : models) {
        for (double altitude : {0.0, 3.0, 20.0, 55.0, 90.0}) {
            for (float clearness : {1.0F, 1.03F, 1.1F, 1.3F, 1.7F, 2.3F, 3.5F, 5.0F, 8.0F}) {
                for (int type : {1, 5, 12, 15}) {
                    DomeParameters p;
                    p.model = model;
                    p.to_sun = glm::vec3(towards(altitude, 70.0));
                    p.clearness = clearness;
                    p.brightness = clearness > 3.0F ? 0.12F : 0.3F;
                    p.cie_type = type;
                    out.push_back(p);
                    if (model != DomeModel::cie_general) {
                        break;
                    }
                }
                if (model != DomeModel::perez && model != DomeModel::asrc_cie) {
                    break;
                }
            }
        }
    }
    return out;
}

double diffuse_lux(const SkyDome<double>& dome) {
    double sum = 0.0;
    const int n = 40;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < 2 * n; ++j) {
            const double z = (i + 0.5) / n;
            const double a = pi * (j + 0.5) / n;
            const double r = std::sqrt(1.0 - z * z);
            sum += z * luminance_chromaticity(dome, glm::dvec3(r * std::cos(a), r * std::sin(a), z)).x;
        }
    }
    return sum * two_pi / (2.0 * n * n);
}

TEST(Dome, PreethamIsPreetham) {
    DomeParameters p;
    p.to_sun = glm::vec3(towards(40.0, 100.0));
    p.turbidity = 3.5F;
    const auto dome = make_dome<double>(p);
    const auto sky = make_preetham(glm::dvec3(p.to_sun), 3.5);
    for (double altitude : {-5.0, 0.0, 10.0, 60.0, 90.0}) {
        const glm::dvec3 v = towards(altitude, 31.0);
        EXPECT_LT(glm::length(radiance(dome, v) - radiance(sky, v)), 1e-9 * glm::length(radiance(sky, v)));
    }
}

// Relative to the zenith, as printed (course 2003): overcast horizon a third, clear by hand.
TEST(Dome, CieSkiesAsPrinted) {
    DomeParameters p;
    p.model = DomeModel::cie_overcast;
    p.to_sun = glm::vec3(towards(30.0, 0.0));
    auto dome = make_dome<double>(p);
    const glm::dvec3 up(0, 0, 1);
    EXPECT_NEAR(luminance_chromaticity(dome, towards(0.0, 5.0)).x / luminance_chromaticity(dome, up).x, 1.0 / 3.0,
                1e-3);
    EXPECT_NEAR(luminance_chromaticity(dome, towards(30.0, 5.0)).x / luminance_chromaticity(dome, up).x, 2.0 / 3.0,
                1e-9);
    p.model = DomeModel::cie_clear;
    dome = make_dome<double>(p);
    // Element 30 degrees high in the sun's azimuth: gamma 0, theta 60, theta_s 60 degrees.
    const double ts = 60.0 * degree_rad;
    const double want = (0.91 + 10.0 + 0.45) * (1.0 - std::exp(-0.64)) /
                        ((0.91 + 10.0 * std::exp(-3.0 * ts) + 0.45 * 0.25) * (1.0 - std::exp(-0.32)));
    EXPECT_NEAR(luminance_chromaticity(dome, towards(30.0, 0.0)).x / luminance_chromaticity(dome, up).x / want, 1.0,
                1e-6);
}

// ISO 15469: type 12 is the clear sky of CIE 1973 written otherwise; type 5 is uniform.
TEST(Dome, GeneralSkiesHoldTheirNamesakes) {
    DomeParameters p;
    p.model = DomeModel::cie_general;
    p.to_sun = glm::vec3(towards(45.0, 0.0));
    p.cie_type = 5;
    const auto uniform = make_dome<double>(p);
    EXPECT_NEAR(luminance_chromaticity(uniform, towards(5.0, 0.0)).x,
                luminance_chromaticity(uniform, towards(80.0, 90.0)).x, 1e-6);
    p.cie_type = 12;
    const auto type12 = make_dome<double>(p);
    p.model = DomeModel::cie_clear;
    const auto clear = make_dome<double>(p);
    for (double altitude : {5.0, 30.0, 70.0}) {
        for (double azimuth : {0.0, 60.0, 180.0}) {
            const glm::dvec3 v = towards(altitude, azimuth);
            const double a =
                luminance_chromaticity(type12, v).x / luminance_chromaticity(type12, glm::dvec3(0, 0, 1)).x;
            const double b = luminance_chromaticity(clear, v).x / luminance_chromaticity(clear, glm::dvec3(0, 0, 1)).x;
            EXPECT_NEAR(a / b, 1.0, 0.1);
        }
    }
}

// The 1993 model's limits: clear skies peak at the sun and brighten at the horizon, overcast ones peak at the zenith.
TEST(Dome, PerezFromOvercastToClear) {
    DomeParameters p;
    p.model = DomeModel::perez;
    p.to_sun = glm::vec3(towards(50.0, 0.0));
    p.clearness = 8.0F;
    p.brightness = 0.12F;
    const auto clear = make_dome<double>(p);
    EXPECT_GT(luminance_chromaticity(clear, towards(50.0, 0.0)).x,
              5.0 * luminance_chromaticity(clear, glm::dvec3(0, 0, 1)).x);
    EXPECT_GT(luminance_chromaticity(clear, towards(2.0, 180.0)).x,
              luminance_chromaticity(clear, glm::dvec3(0, 0, 1)).x);
    p.clearness = 1.02F;
    p.brightness = 0.15F;
    const auto overcast = make_dome<double>(p);
    EXPECT_LT(luminance_chromaticity(overcast, towards(2.0, 180.0)).x,
              luminance_chromaticity(overcast, glm::dvec3(0, 0, 1)).x);
}

TEST(Dome, DiffuseIlluminanceIsPlausible) {
    for (const DomeParameters& p : many()) {
        if (p.to_sun.z < 0.3F || p.to_sun.z > 0.9F) {
            continue;
        }
        const double lux = diffuse_lux(make_dome<double>(p));
        EXPECT_GT(lux, 2e3) << static_cast<int>(p.model) << ' ' << p.clearness << ' ' << p.cie_type;
        EXPECT_LT(lux, 1e5) << static_cast<int>(p.model) << ' ' << p.clearness << ' ' << p.cie_type;
    }
}

TEST(Dome, GivenZenithIsKept) {
    for (DomeParameters p : many()) {
        p.zenith_cd_m2 = 1234.0F;
        const auto dome = make_dome<double>(p);
        const double zenith = luminance_chromaticity(dome, glm::dvec3(0, 0, 1)).x;
        if (zenith > 0.0) {
            EXPECT_NEAR(zenith, 1234.0, 1e-3);
        }
    }
}

// Perez et al. 1990, eq. 12 to 15: at the ends of the blend's ranges one of the four skies stands alone.
TEST(Dome, AsrcSkiesAsPrinted) {
    DomeParameters p;
    p.model = DomeModel::asrc_cie;
    const double sun_altitude = 35.0 * degree_rad;
    const double zenith_angle = 0.5 * pi - sun_altitude;
    p.to_sun = glm::vec3(towards(35.0, 0.0));
    const auto kittler = [](double c0, double c1, double c2, double angle) {
        return c0 + c1 * std::exp(-3.0 * angle) + c2 * std::cos(angle) * std::cos(angle);
    };
    const auto gradation = [](double altitude) { return 1.0 - std::exp(-0.32 / std::sin(altitude)); };
    const auto a = [](double x, double y) {
        return (1.35 * (std::sin(3.59 * y - 0.009) + 2.31) * std::sin(2.6 * x + 0.316) + y + 4.799) / 2.326;
    };
    const auto b = [](double x, double y) { return -0.563 * ((y + 1.059) * (x - 0.008) + 0.812); };
    for (double altitude : {10.0, 50.0}) {
        for (double azimuth : {0.0, 100.0}) {
            const double y = altitude * degree_rad;
            const glm::dvec3 v = towards(altitude, azimuth);
            const double angle = std::acos(glm::dot(v, towards(35.0, 0.0)));
            const auto relative = [&](float clearness, float brightness) {
                p.clearness = clearness;
                p.brightness = brightness;
                const auto dome = make_dome<double>(p);
                return luminance_chromaticity(dome, v).x / luminance_chromaticity(dome, glm::dvec3(0, 0, 1)).x;
            };
            EXPECT_NEAR(relative(1.0F, 0.04F), (1.0 + 2.0 * std::sin(y)) / 3.0, 1e-6);
            const double intermediate =
                a(sun_altitude, y) * std::exp(angle * b(sun_altitude, y)) /
                (a(sun_altitude, 0.5 * pi) * std::exp(zenith_angle * b(sun_altitude, 0.5 * pi)));
            EXPECT_NEAR(relative(1.0F, 0.5F) / intermediate, 1.0, 1e-5);
            EXPECT_NEAR(relative(1.2F, 0.1F) / intermediate, 1.0, 1e-5);
            EXPECT_NEAR(relative(3.0F, 0.1F),
                        gradation(y) * kittler(0.856, 16.0, 0.3, angle) /
                            (gradation(0.5 * pi) * kittler(0.856, 16.0, 0.3, zenith_angle)),
                        1e-5);
            EXPECT_NEAR(relative(7.0F, 0.1F),
                        gradation(y) * kittler(0.91, 10.0, 0.45, angle) /
                            (gradation(0.5 * pi) * kittler(0.91, 10.0, 0.45, zenith_angle)),
                        1e-5);
        }
    }
}

TEST(Dome, AsrcBlendIsContinuousInClearness) {
    DomeParameters p;
    p.model = DomeModel::asrc_cie;
    p.to_sun = glm::vec3(towards(40.0, 0.0));
    double before = 0.0;
    for (float clearness = 1.0F; clearness < 8.0F; clearness += 0.005F) {
        p.clearness = clearness;
        const double now = luminance_chromaticity(make_dome<double>(p), towards(35.0, 40.0)).x;
        if (before > 0.0) {
            EXPECT_NEAR(now / before, 1.0, 0.03);
        }
        before = now;
    }
}

TEST(Dome, SpectrumHasTheLuminanceAndColour) {
    DomeParameters p;
    p.to_sun = glm::vec3(towards(40.0, 0.0));
    const auto dome = make_dome<double>(p);
    const glm::dvec3 v = towards(60.0, 120.0);
    const glm::dvec3 Yxy = luminance_chromaticity(dome, v);
    const glm::dvec3 xyz = spectrum_to_xyz(spectral_radiance(dome, v));
    EXPECT_NEAR(xyz.y / Yxy.x, 1.0, 1e-12);
    EXPECT_NEAR(xyz.x / (xyz.x + xyz.y + xyz.z), Yxy.y, 2e-3);
}

TEST(Dome, BatchKeepsToTheDoubleReference) {
    std::vector<glm::vec3> v;
    for (int i = 0; i < 1237; ++i) { // not a whole number of vectors
        const double z = -0.1 + 1.1 * (i + 0.5) / 1237.0;
        const double a = 2.399963229728653 * i;
        const double r = std::sqrt(1.0 - z * z);
        v.emplace_back(glm::dvec3(r * std::cos(a), r * std::sin(a), z));
    }
    double worst = 0.0;
    double worst_preetham = 0.0;
    for (DomeParameters p : many()) {
        const auto reference = make_dome<double>(p);
        const auto dome = make_dome<float>(p);
        v[0] = p.to_sun;
        v[1] = -p.to_sun;
        v[2] = glm::vec3(glm::normalize(glm::dvec3(p.to_sun) + glm::dvec3(3e-5, 0, 0))); // hard by the sun
        std::vector<float> x, y, z, r(v.size()), g(v.size()), b(v.size());
        for (const glm::vec3& d : v) {
            x.push_back(d.x);
            y.push_back(d.y);
            z.push_back(d.z);
        }
        radiance(dome, {x, y, z}, {r, g, b});
        for (std::size_t i = 0; i < v.size(); ++i) {
            const glm::dvec3 want = radiance(reference, glm::dvec3(v[i]));
            const glm::dvec3 got(r[i], g[i], b[i]);
            ASSERT_GE(std::min({got.x, got.y, got.z}), 0.0);
            if (glm::length(want) > 1e-3) {
                const double error = glm::length(got - want) / glm::length(want);
                ASSERT_LT(error, 1e-4) << static_cast<int>(p.model) << " clearness " << p.clearness << " direction "
                                       << i;
                double& of = p.model == DomeModel::preetham ? worst_preetham : worst;
                of = std::max(of, error);
            }
        }
    }
    EXPECT_LT(worst_preetham, 1e-5);
    EXPECT_LT(worst, 1e-4); // gradations of Perez' skies that nearly cancel
}

TEST(Dome, CheckNamesTheField) {
    DomeParameters p;
    EXPECT_TRUE(check(p));
    p.cie_type = 16;
    EXPECT_NE(check(p).error().message().find("cie_type"), std::string::npos);
    p = {};
    p.brightness = std::nanf("");
    EXPECT_FALSE(check(p));
    p = {};
    p.to_sun = glm::vec3(0.0F);
    EXPECT_FALSE(check(p));
}

} // namespace
} // namespace alpenglow::sky
