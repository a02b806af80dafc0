#include <alpenglow/sky/fit_sky.hpp>
#include <alpenglow/sky/sky_fit.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

template <class Vec>
double distance(std::span<const glm::dvec3> want, std::span<const Vec> got) {
    double difference = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < want.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(got[i]) - want[i];
        difference += glm::dot(d, d);
        norm += glm::dot(want[i], want[i]);
    }
    return std::sqrt(difference / norm);
}

// Points of a low-discrepancy sequence over the domain, none of them a node of the fit.
TEST(SkyFit, ShippedPreethamFitKeepsItsErrors) {
    const SkyBlackBox sky = preetham_black_box(48, 60);
    const SkyFit& fit = preetham_fit();
    EXPECT_LE(fit.bytes(), 140U * 1024);
    std::array<double, 8> worst{};
    for (int i = 0; i < 120; ++i) {
        const double theta = 0.5 * pi * std::fmod(0.618034 * i, 1.0);
        const double turbidity =
            i % 2 == 0 ? 2.0 + 8.0 * std::fmod(0.754878 * i, 1.0) : 2.5 + 3.5 * std::fmod(0.569840 * i, 1.0);
        const std::array<double, 2> p{theta, turbidity};
        for (int bands : {3, 5, 7}) {
            worst[static_cast<std::size_t>(bands)] =
                std::max(worst[static_cast<std::size_t>(bands)], fit_error(fit, p, bands, sky).e_mean);
        }
    }
    EXPECT_LT(worst[3], 2.0e-5);
    EXPECT_LT(worst[5], 3.0e-5);
    EXPECT_LT(worst[7], 5.0e-5);
}

TEST(SkyFit, EndsOfTheDomain) {
    const SkyBlackBox sky = preetham_black_box(64, 80);
    for (double theta : {0.0, 0.5 * pi}) {
        for (double turbidity : {2.0, 2.5, 3.0, 6.0, 10.0}) {
            const std::array<double, 2> p{theta, turbidity};
            EXPECT_LT(fit_error(preetham_fit(), p, 7, sky).e_mean, 5e-5) << theta << ' ' << turbidity;
        }
    }
    // Beyond them: held.
    std::array<glm::dvec3, 49> at{};
    std::array<glm::dvec3, 49> beyond{};
    evaluate_fit(preetham_fit(), std::array{0.5 * pi, 10.0}, 7, at);
    evaluate_fit(preetham_fit(), std::array{2.0, 99.0}, 7, beyond);
    EXPECT_EQ(at[0], beyond[0]);
}

TEST(SkyFit, SineTermsAreExactlyZeroBeforeRotation) {
    std::array<glm::dvec3, 49> c{};
    evaluate_fit(preetham_fit(), std::array{0.8, 3.3}, 7, c);
    std::array<glm::vec3, 49> f{};
    SkyFitEvaluator evaluator(preetham_fit());
    evaluator.evaluate(glm::vec3(std::sin(0.8F), 0.0F, std::cos(0.8F)), std::array{3.3F}, 7, f);
    for (int l = 1; l < 7; ++l) {
        for (int m = 1; m <= l; ++m) {
            EXPECT_EQ(c[static_cast<std::size_t>(sh::index(l, -m))], glm::dvec3(0.0));
            EXPECT_EQ(f[static_cast<std::size_t>(sh::index(l, -m))], glm::vec3(0.0F));
        }
    }
}

TEST(SkyFit, FastPathsKeepToTheReference) {
    SkyFitEvaluator evaluator(preetham_fit());
    std::array<glm::dvec3, 49> want{};
    std::array<glm::vec3, 49> cached{};
    std::array<glm::vec3, 49> straight{};
    double worst = 0.0;
    for (int i = 0; i < 200; ++i) {
        const double theta = 0.5 * pi * std::fmod(0.618034 * i, 1.0);
        const double azimuth = 0.37 * i;
        const float turbidity = 2.0F + 0.04F * static_cast<float>(i / 10 * 10);
        const glm::vec3 to_sun(
            glm::dvec3(std::sin(theta) * std::cos(azimuth), std::sin(theta) * std::sin(azimuth), std::cos(theta)));
        for (int bands : {1, 2, 3, 4, 5, 6, 7}) {
            const auto count = static_cast<std::size_t>(bands * bands);
            evaluate_fit(preetham_fit(), std::array{theta, double(turbidity)}, bands, want);
            rotate_symmetric_sky(glm::dvec3(to_sun), bands, std::span(want).first(count));
            evaluator.evaluate(to_sun, std::array{turbidity}, bands, std::span(cached).first(count));
            evaluator.evaluate_uncached(to_sun, std::array{turbidity}, bands, std::span(straight).first(count));
            const std::span<const glm::dvec3> reference = std::span(want).first(count);
            worst = std::max(worst, distance<glm::vec3>(reference, std::span<const glm::vec3>(cached).first(count)));
            worst = std::max(worst, distance<glm::vec3>(reference, std::span<const glm::vec3>(straight).first(count)));
        }
    }
    EXPECT_LT(worst, 4e-6);
}

// Three axes, and a factor that runs over many powers of ten.
TEST(SkyFit, FastPathsOfTheAtmospheresFit) {
    const SkyFit& fit = scattering_fit();
    SkyFitEvaluator evaluator(fit);
    std::array<glm::dvec3, 49> want{};
    std::array<glm::vec3, 49> got{};
    double worst = 0.0;
    for (int i = 0; i < 200; ++i) {
        const std::array<double, 3> p{1.88 * std::fmod(0.618034 * i, 1.0),
                                      2.0 + 6.0 * std::fmod(0.754878 * (i / 4), 1.0),
                                      0.8 * std::fmod(0.569840 * (i / 4), 1.0)};
        const std::array others{static_cast<float>(p[1]), static_cast<float>(p[2])};
        const glm::vec3 to_sun(glm::dvec3(std::sin(p[0]), 0.0, std::cos(p[0])));
        for (int bands : {2, 7}) {
            const auto count = static_cast<std::size_t>(bands * bands);
            const std::span<const glm::dvec3> reference = std::span(want).first(count);
            evaluate_fit(fit, p, bands, want);
            evaluator.evaluate(to_sun, others, bands, std::span(got).first(count));
            worst = std::max(worst, distance<glm::vec3>(reference, std::span<const glm::vec3>(got).first(count)));
            evaluator.evaluate_uncached(to_sun, others, bands, std::span(got).first(count));
            worst = std::max(worst, distance<glm::vec3>(reference, std::span<const glm::vec3>(got).first(count)));
        }
    }
    EXPECT_LT(worst, 2e-5);
}

TEST(SkyFit, NothingIsWrittenPastTheBandsAskedFor) {
    SkyFitEvaluator evaluator(preetham_fit());
    for (int bands = 1; bands <= 7; ++bands) {
        std::array<glm::vec3, 50> out;
        out.fill(glm::vec3(-7.0F));
        evaluator.evaluate(glm::vec3(0.6F, 0.0F, 0.8F), std::array{2.5F}, bands, out);
        EXPECT_EQ(out[static_cast<std::size_t>(bands * bands)], glm::vec3(-7.0F));
        EXPECT_NE(out[static_cast<std::size_t>(bands * bands - 1)], glm::vec3(-7.0F));
    }
}

// A black box that a fit of low degree holds exactly comes back exactly.
TEST(SkyFit, PolynomialsComeBack) {
    SkyFitBox box;
    box.axes = {
        {FitMap::half_tangent, 0.1, 1.2, 0.0}, {FitMap::linear, 0.0, 1.0, 0.0}, {FitMap::linear, -1.0, 2.0, 0.0}};
    box.nodes = {6, 4, 3};
    box.max_e_mean = 1e-9;
    const SkyBlackBox polynomial = [](std::span<const double> p, int bands, std::span<glm::dvec3> c) {
        const double u = std::tan(0.5 * p[0]);
        for (int l = 0; l < bands; ++l) {
            for (int m = -l; m <= l; ++m) {
                c[static_cast<std::size_t>(sh::index(l, m))] =
                    m < 0
                        ? glm::dvec3(0.0)
                        : glm::dvec3(5.0 + u * u * p[1] + p[2] * p[2] * 0.1 * l, 4.0 - u * p[2] * m, 3.0 + p[1] * p[1]);
            }
        }
        return 1.0;
    };
    SkyFitReport report;
    Result<SkyFitPart> part = fit_sky_box(box, FitNormaliser::none, 3, polynomial, report);
    ASSERT_TRUE(part.has_value());
    EXPECT_LT(report.rows, 12U); // the rest is pruned
    SkyFit fit{FitNormaliser::none, 3, {*part}};
    EXPECT_LT(fit_error(fit, std::array{0.7, 0.3, 1.1}, 3, polynomial).e_max,
              2e-5); // float coefficients
}

// Off the nodes of the fit, by day, at the joins of its parts and in twilight. At the nodes the fit keeps 0.3 %;
// between them the steps of the tables that it was made from show, which grow as the Earth's shadow rises
// (docs/sky.md).
TEST(SkyFit, ShippedScatteringFitKeepsItsErrors) {
    const SkyBlackBox sky = scattering_black_box(0.001, 20, 28);
    EXPECT_LE(write_fit(scattering_fit(), FitStorage::int16).size(), 256U * 1024);
    for (double theta_deg : {3.0, 41.0, 77.0, 87.9, 88.1, 93.3, 97.9, 98.1, 105.0}) {
        const FitError error = fit_error(scattering_fit(), std::array{theta_deg * degree_rad, 3.1, 0.27}, 7, sky);
        EXPECT_LT(error.e_mean, theta_deg < 88.0 ? 0.003 : 0.012) << theta_deg;
        std::printf("theta %.1f: E_mean %.3f %%\n", theta_deg, 100.0 * error.e_mean);
    }
}

TEST(SkyFit, WritesAndReads) {
    const std::vector<std::uint8_t> bytes = write_fit(preetham_fit());
    Result<SkyFit> read = read_fit(bytes, "table");
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(write_fit(*read), bytes);
}

// What a table of a size can hold: coarse in 16 bits, and in whole floats, over the paper's domain and over all.
TEST(SkyFit, TablesOfThreeSizes) {
    struct Wanted {
        double low, high, max_e_mean;
        FitStorage storage;
        std::size_t bytes;
        double worst_e_mean;
    };
    const SkyBlackBox sky = preetham_black_box(48, 60);
    for (const Wanted& wanted : {Wanted{2.5, 6.0, 2.2e-4, FitStorage::int16, 16U * 1024, 3e-4},
                                 Wanted{2.5, 6.0, 4.4e-5, FitStorage::float32, 40U * 1024, 5e-5},
                                 Wanted{2.0, 10.0, 1.7e-4, FitStorage::float32, 64U * 1024, 2e-4}}) {
        SkyFitBox box;
        box.axes = {{FitMap::half_tangent, 0.0, 0.5 * pi, 0.0}, {FitMap::log_offset, wanted.low, wanted.high, 1.2}};
        box.nodes = {32, 18};
        box.max_e_mean = wanted.max_e_mean;
        SkyFitReport report;
        Result<SkyFitPart> part = fit_sky_box(box, FitNormaliser::preetham, 7, preetham_black_box(32, 44), report);
        ASSERT_TRUE(part.has_value());
        const std::vector<std::uint8_t> bytes = write_fit({FitNormaliser::preetham, 7, {*part}}, wanted.storage);
        EXPECT_LE(bytes.size(), wanted.bytes);
        Result<SkyFit> read = read_fit(bytes, "compact");
        ASSERT_TRUE(read.has_value());
        double worst = 0.0;
        for (int i = 0; i < 60; ++i) {
            const std::array<double, 2> p{0.5 * pi * std::fmod(0.618034 * i, 1.0),
                                          wanted.low + (wanted.high - wanted.low) * std::fmod(0.754878 * i, 1.0)};
            worst = std::max(worst, fit_error(*read, p, 7, sky).e_mean);
        }
        EXPECT_LT(worst, wanted.worst_e_mean);
        std::printf("turbidity %.1f to %.1f: %zu bytes, worst E_mean %.5f %%\n", wanted.low, wanted.high, bytes.size(),
                    100.0 * worst);
    }
}

// Suns and turbidities on the parts' borders, on both sides, and beyond the ends: no step larger than the fit's error.
TEST(SkyFit, PartsJoin) {
    SkyFitEvaluator evaluator(preetham_fit());
    std::array<glm::vec3, 49> below{};
    std::array<glm::vec3, 49> above{};
    for (const SkyFitPart& part : preetham_fit().parts) {
        for (double theta : {part.axes[0].low, part.axes[0].high}) {
            for (double turbidity : {part.axes[1].low, 0.5 * (part.axes[1].low + part.axes[1].high)}) {
                const auto at = [&](double t, double haze, std::array<glm::vec3, 49>& out) {
                    evaluator.evaluate(glm::vec3(glm::dvec3(std::sin(t), 0.0, std::cos(t))),
                                       std::array{static_cast<float>(haze)}, 7, out);
                };
                const auto step = [&] {
                    float squares = 0.0F;
                    float norm = 0.0F;
                    for (std::size_t i = 0; i < below.size(); ++i) {
                        squares += glm::dot(below[i] - above[i], below[i] - above[i]);
                        norm += glm::dot(below[i], below[i]);
                    }
                    return std::sqrt(squares / norm);
                };
                at(theta - 1e-6, turbidity, below);
                at(theta + 1e-6, turbidity, above);
                EXPECT_LT(step(), 5e-5F) << theta << ' ' << turbidity;
                at(theta, turbidity * (1.0 - 1e-6), below);
                at(theta, turbidity * (1.0 + 1e-6), above);
                EXPECT_LT(step(), 5e-5F) << theta << ' ' << turbidity;
            }
        }
    }
}

TEST(SkyFit, DamagedTablesAreRefusedWithAReason) {
    const std::vector<std::uint8_t> good = write_fit(preetham_fit());
    EXPECT_FALSE(read_fit({}, "empty.fit"));
    EXPECT_NE(read_fit({}, "empty.fit").error().message().find("empty.fit"), std::string::npos);
    for (std::size_t size : {4U, 11U, 12U, 40U, 1000U}) {
        EXPECT_FALSE(read_fit(std::span(good).first(size), "short.fit")) << size;
    }
    for (std::size_t at : {0U, 5U, 9U, 13U, 30U, 5000U}) {
        std::vector<std::uint8_t> bad = good;
        bad[at] ^= 0x40U;
        EXPECT_FALSE(read_fit(bad, "bad.fit")) << at;
    }
    std::vector<std::uint8_t> longer = good;
    longer.resize(good.size() + 8);
    EXPECT_FALSE(read_fit(longer, "long.fit"));
}

TEST(SkyFit, BadBoxesAreRefused) {
    SkyFitReport report;
    SkyFitBox box;
    box.axes = {{FitMap::half_tangent, 1.0, 0.5, 0.0}};
    box.nodes = {4};
    EXPECT_FALSE(fit_sky_box(box, FitNormaliser::none, 3, preetham_black_box(4, 4), report));
    box.axes = {{FitMap::half_tangent, 0.0, 0.5, 0.0}};
    box.nodes = {1000};
    EXPECT_FALSE(fit_sky_box(box, FitNormaliser::none, 3, preetham_black_box(4, 4), report));
}

} // namespace
} // namespace alpenglow::sky
