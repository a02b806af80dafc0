// The C evaluator for other engines, compiled as it is shipped, on tables written by the exporter.
#include <alpenglow/sky/fit_sky.hpp>
#include <alpenglow/sky/sky_fit.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <glm/geometric.hpp>

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wpedantic"
#endif
#include "../../../modules/sky/export/sky_fit_eval.h"
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace alpenglow::sky {
namespace {

// The same structs that the generated header fills.
struct Exported {
    std::vector<sky_fit_part> parts;
    sky_fit fit{};

    explicit Exported(const SkyFit& source) {
        for (const SkyFitPart& p : source.parts) {
            sky_fit_part part{};
            for (std::size_t a = 0; a < p.axes.size(); ++a) {
                part.axes[a] = {static_cast<int>(p.axes[a].map), static_cast<float>(p.axes[a].low),
                                static_cast<float>(p.axes[a].high), static_cast<float>(p.axes[a].offset)};
            }
            part.axis_count = static_cast<int>(p.axes.size());
            part.rows = static_cast<int>(p.degrees.size() / p.axes.size());
            part.log_terms = static_cast<int>(p.log_terms.size());
            part.degrees = p.degrees.data();
            part.row = p.rows.data();
            part.log_degrees = p.log_degrees.data();
            part.log_term = p.log_terms.data();
            parts.push_back(part);
        }
        fit = {static_cast<int>(source.normaliser), source.bands, static_cast<int>(parts.size()), parts.data()};
    }
};

void compare(const SkyFit& source, const std::vector<std::array<double, 3>>& points, double tolerance) {
    const Exported exported(source);
    for (const auto& p : points) {
        const double azimuth = 0.7;
        std::array<glm::dvec3, 49> want{};
        evaluate_fit(source, p, 7, want);
        rotate_symmetric_sky(glm::dvec3(std::cos(azimuth), std::sin(azimuth), 0.0), 7, want);
        const std::array<float, 3> parameters{static_cast<float>(p[0]), static_cast<float>(p[1]),
                                              static_cast<float>(p[2])};
        std::array<float, 147> got{};
        sky_fit_evaluate(&exported.fit, parameters.data(), static_cast<float>(azimuth), 7, got.data());
        double difference = 0.0;
        double norm = 0.0;
        for (std::size_t i = 0; i < 49; ++i) {
            const glm::dvec3 d = glm::dvec3(got[3 * i], got[3 * i + 1], got[3 * i + 2]) - want[i];
            difference += glm::dot(d, d);
            norm += glm::dot(want[i], want[i]);
        }
        EXPECT_LT(std::sqrt(difference / norm), tolerance) << p[0] << ' ' << p[1];
    }
}

TEST(CExport, EvaluatorAgreesOnPreetham) {
    compare(preetham_fit(), {{0.0, 2.0, 0.0}, {0.4, 2.5, 0.0}, {1.1, 3.7, 0.0}, {1.5707, 6.0, 0.0}, {0.8, 10.0, 0.0}},
            1e-5);
}

TEST(CExport, EvaluatorAgreesOnTheScatteringAtmosphere) {
    compare(scattering_fit(), {{0.3, 2.5, 0.2}, {1.4, 4.0, 0.1}, {1.6, 3.0, 0.5}, {1.8, 2.2, 0.3}}, 1e-4);
}

TEST(CExport, HeaderNamesEverything) {
    const std::string text = fit_as_c_header(preetham_fit(), "my_sky");
    for (const char* word : {"my_sky_0_rows", "my_sky_1_degrees", "my_sky_parts", "static const sky_fit my_sky"}) {
        EXPECT_NE(text.find(word), std::string::npos) << word;
    }
}

} // namespace
} // namespace alpenglow::sky
