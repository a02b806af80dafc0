// Every SkyModel through SkyState: radiance, SH, drift bounds and tables.
#include <alpenglow/sky/scattering_tables.hpp>
#include <alpenglow/sky/sky_state.hpp>

#include <fp_traps.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

constexpr std::array<SkyModel, 7> all_models{SkyModel::preetham,     SkyModel::perez,    SkyModel::cie_clear,
                                             SkyModel::cie_overcast, SkyModel::asrc_cie, SkyModel::cie_general,
                                             SkyModel::scattering};

glm::vec3 towards(double altitude_deg, double azimuth_deg) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return glm::vec3(glm::dvec3(std::cos(a) * std::sin(z), std::cos(a) * std::cos(z), std::sin(a)));
}

std::vector<glm::vec3> sphere(int count, double lowest = -1.0) {
    std::vector<glm::vec3> out;
    for (int i = 0; i < count; ++i) {
        const double z = lowest + (1.0 - lowest) * (i + 0.5) / count;
        const double r = std::sqrt(1.0 - z * z);
        out.emplace_back(glm::dvec3(r * std::cos(2.399963 * i), r * std::sin(2.399963 * i), z));
    }
    return out;
}

struct Scene {
    CelestialState celestial;
    SkyState state;
    SkyTables tables;

    SkyTableWork make(const Atmosphere& air, double height_m = 0.0) {
        state = make_sky_state(celestial, air, height_m);
        state.revision = 1;
        return update_sky_tables(state, celestial, {.sky_view = true}, tables);
    }
};

// The SH are the projection of what sky_radiance says of the upper hemisphere.
TEST(SkyModels, ShIsTheProjectionOfTheRadiance) {
    const std::vector<glm::vec3> directions = sphere(20000, 0.0);
    std::vector<glm::vec3> radiance(directions.size());
    for (const SkyModel model : all_models) {
        for (const double altitude : {50.0, 8.0, -5.0}) {
            Scene scene;
            scene.celestial.to_sun = towards(altitude, 200.0);
            scene.celestial.to_moon = towards(30.0, 20.0);
            Atmosphere air;
            air.model = model;
            scene.make(air);
            sky_radiance(scene.state, &scene.tables, directions, radiance);
            double horizontal = 0.0;
            glm::dvec3 linear(0.0);
            for (std::size_t i = 0; i < directions.size(); ++i) {
                horizontal += luminance(radiance[i]);
                linear += glm::dvec3(directions[i]) * double(luminance(radiance[i]));
            }
            const double w = two_pi / static_cast<double>(directions.size());
            std::array<glm::vec3, 9> c{};
            project_sky_state(scene.state, &scene.tables, 3, c);
            // The shipped fit of the scattering sky is for an error of its own.
            const double tolerance = model == SkyModel::scattering ? 0.012 : 0.004;
            EXPECT_NEAR(luminance(c[0]) / (0.2820948 * w * horizontal), 1.0, tolerance)
                << int(model) << ' ' << altitude;
            EXPECT_NEAR(luminance(c[2]) / (0.4886025 * w * linear.z), 1.0, tolerance) << int(model) << ' ' << altitude;
            EXPECT_NEAR(-luminance(c[3]) / luminance(c[0]), 1.7320508 * linear.x / horizontal, tolerance) << int(model);
            EXPECT_NEAR(-luminance(c[1]) / luminance(c[0]), 1.7320508 * linear.y / horizontal, tolerance) << int(model);
        }
    }
}

TEST(SkyModels, CloudsKeepTheSunAway) {
    CelestialState celestial;
    celestial.to_sun = towards(40.0, 100.0);
    const auto sun = [&](SkyModel model, float clearness, int type) {
        Atmosphere air;
        air.model = model;
        air.clearness = clearness;
        air.cie_type = type;
        air.brightness = clearness > 3.0F ? 0.12F : 0.25F;
        return luminance(make_sky_state(celestial, air).sun_illuminance_lux);
    };
    EXPECT_EQ(sun(SkyModel::cie_overcast, 6.0F, 1), 0.0);
    EXPECT_EQ(sun(SkyModel::perez, 1.0F, 1), 0.0);
    EXPECT_GT(sun(SkyModel::perez, 7.0F, 1), 4e4);
    EXPECT_EQ(sun(SkyModel::asrc_cie, 1.0F, 1), 0.0);
    EXPECT_GT(sun(SkyModel::asrc_cie, 6.0F, 1), 6e4);
    EXPECT_EQ(sun(SkyModel::cie_general, 6.0F, 1), 0.0);
    EXPECT_GT(sun(SkyModel::cie_general, 6.0F, 12), 6e4);
    EXPECT_GT(sun(SkyModel::scattering, 6.0F, 12), 6e4);
}

struct Errors {
    double sky, sun;
};
Errors errors(const SkyState& kept, const SkyState& now, const SkyTables* tables) {
    std::array<glm::vec3, 49> a{};
    std::array<glm::vec3, 49> b{};
    project_sky_state(kept, tables, 7, a);
    project_sky_state(now, tables, 7, b);
    double difference = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(a[i]) - glm::dvec3(b[i]);
        difference += glm::dot(d, d);
        norm += glm::dot(glm::dvec3(b[i]), glm::dvec3(b[i]));
    }
    const double horizontal = 0.886227 * luminance(b[0]) + 1.023327 * luminance(b[2]) + 0.495416 * luminance(b[6]);
    return {std::sqrt(difference / norm),
            std::abs(luminance(kept.sun_illuminance_lux) - luminance(now.sun_illuminance_lux)) /
                (luminance(now.sun_illuminance_lux) + horizontal)};
}

// Sweep the sun, keep the state for as long as the bound allows, recompute in secret.
TEST(SkyModels, DriftBoundHoldsForEveryModel) {
    struct Kind {
        SkyModel model;
        float clearness;
        int type;
        float turbidity;
    };
    std::vector<Kind> kinds;
    for (float turbidity : {2.0F, 8.0F}) {
        kinds.push_back({SkyModel::cie_clear, 6.0F, 12, turbidity});
        kinds.push_back({SkyModel::scattering, 6.0F, 12, turbidity});
    }
    kinds.push_back({SkyModel::cie_overcast, 6.0F, 1, 3.0F});
    for (float clearness : {1.0F, 1.6F, 3.0F, 9.0F}) {
        kinds.push_back({SkyModel::perez, clearness, 1, 3.0F});
        kinds.push_back({SkyModel::asrc_cie, clearness, 1, 3.0F});
    }
    for (int type : {1, 5, 9, 13, 15}) {
        kinds.push_back({SkyModel::cie_general, 6.0F, type, 3.0F});
    }
    for (const Kind& kind : kinds) {
        Atmosphere air;
        air.model = kind.model;
        air.clearness = kind.clearness;
        air.cie_type = kind.type;
        air.turbidity = kind.turbidity;
        air.brightness = kind.clearness > 3.0F ? 0.12F : 0.3F;
        CelestialState celestial;
        SkyState kept;
        double altitude = -20.0;
        double azimuth = 40.0;
        int step = 0;
        while (altitude < 90.0) {
            celestial.to_sun = towards(altitude, azimuth);
            const double bound = drift_bound(kept, celestial, air);
            if (!(bound <= 0.05)) {
                kept = make_sky_state(celestial, air);
                kept.revision = 1;
            } else if (++step % 4 == 0) {
                const Errors e = errors(kept, make_sky_state(celestial, air), nullptr);
                EXPECT_LE(e.sky, bound + 2e-6) << int(kind.model) << ' ' << kind.clearness << ' ' << kind.type << ' '
                                               << kind.turbidity << " sun " << altitude;
                EXPECT_LE(e.sun, bound + 2e-6) << int(kind.model) << " sun " << altitude;
            }
            const double move = altitude < 12.0 ? 0.0071 : 0.07;
            altitude += move;
            azimuth += 0.7 * move;
        }
    }
}

// Sunrise in small steps: views are kept while the bound allows, and what they show stays within it.
TEST(SkyModels, TableBoundHolds) {
    const std::vector<glm::vec3> directions = sphere(60);
    std::vector<glm::vec3> kept(directions.size());
    std::vector<glm::vec3> now(directions.size());
    Atmosphere air;
    air.model = SkyModel::scattering;
    air.max_error = 0.1F;
    Scene scene;
    Scene secret;
    int rebuilt = 0;
    int steps = 0;
    for (const auto& [from, to] : {std::pair{-16.5, -15.5}, {-7.0, -5.5}, {-1.2, 1.5}, {4.0, 5.5}, {20.0, 26.0}}) {
        for (double altitude = from; altitude < to; altitude += altitude < 6.0 ? 0.021 : 0.21) {
            scene.celestial.to_sun = secret.celestial.to_sun = towards(altitude, 30.0);
            const SkyTableWork work = scene.make(air);
            rebuilt += static_cast<int>(work.rebuilt);
            if (work.rebuilt == 0 && ++steps % 7 == 0) {
                secret.tables = scene.tables;
                secret.tables.sun_view = nullptr;
                secret.make(air);
                sky_radiance(scene.state, &scene.tables, directions, kept);
                sky_radiance(secret.state, &secret.tables, directions, now);
                for (std::size_t i = 0; i < kept.size(); ++i) {
                    EXPECT_LE(glm::length(kept[i] - now[i]), (work.error_bound + 1e-5) * glm::length(now[i]))
                        << altitude << ' ' << directions[i].z;
                }
            }
        }
    }
    EXPECT_LT(rebuilt, steps);
}

TEST(SkyModels, AirMovesWithinItsBound) {
    const std::vector<glm::vec3> directions = sphere(60);
    std::vector<glm::vec3> kept(directions.size());
    std::vector<glm::vec3> now(directions.size());
    for (double altitude : {3.0, -4.0}) {
        Scene scene;
        scene.celestial.to_sun = towards(altitude, 30.0);
        Atmosphere air;
        air.model = SkyModel::scattering;
        air.max_error = 0.2F;
        for (int what = 0; what < 4; ++what) {
            Atmosphere other = air;
            other.turbidity += what == 0 ? 0.08F : 0.0F;
            other.ozone_atm_cm += what == 1 ? 0.03F : 0.0F;
            other.ground_albedo += glm::vec3(what == 2 ? 0.02F : 0.0F);
            scene.tables = {};
            scene.make(air);
            const SkyTableWork work = scene.make(other, what == 3 ? 40.0 : 0.0);
            EXPECT_EQ(work.rebuilt, 0U);
            sky_radiance(scene.state, &scene.tables, directions, kept);
            Scene secret;
            secret.celestial = scene.celestial;
            secret.make(other, what == 3 ? 40.0 : 0.0);
            sky_radiance(secret.state, &secret.tables, directions, now);
            float mean = 0.0F;
            for (const glm::vec3& v : now) {
                mean += glm::length(v) / static_cast<float>(now.size());
            }
            for (std::size_t i = 0; i < kept.size(); ++i) {
                // A little height puts air before the ground, which may be dark: relative to the whole then.
                const float scale = what == 3 ? std::max(glm::length(now[i]), mean) : glm::length(now[i]);
                if (std::abs(directions[i].z) > 0.02F || what != 3) { // the horizon's edge moves by its dip
                    EXPECT_LE(glm::length(kept[i] - now[i]), work.error_bound * scale)
                        << altitude << ' ' << what << ' ' << directions[i].z;
                }
            }
        }
    }
}

// A moonlit sky is the sun's, dimmed: it has a gradient, and its brightest part is around the moon.
TEST(SkyModels, MoonlightHasAGradient) {
    Scene scene;
    scene.celestial.to_sun = towards(-40.0, 0.0);
    scene.celestial.to_moon = towards(35.0, 90.0);
    Atmosphere air;
    air.model = SkyModel::scattering;
    scene.make(air);
    EXPECT_EQ(scene.tables.sun_view, nullptr);
    ASSERT_NE(scene.tables.moon_view, nullptr);
    const std::array<glm::vec3, 3> directions{towards(40.0, 90.0), towards(60.0, 270.0), towards(5.0, 0.0)};
    std::array<glm::vec3, 3> out{};
    sky_radiance(scene.state, &scene.tables, directions, out);
    EXPECT_GT(luminance(out[0]), 3.0 * luminance(out[1]));
    EXPECT_GT(luminance(out[1]), 1e-3);
    EXPECT_LT(luminance(out[1]), 2e-2);
    EXPECT_GT(luminance(scene.state.moon_illuminance_lux), 0.15);
}

TEST(SkyModels, TablesOnlyForThoseWhoRead) {
    Scene scene;
    scene.celestial.to_sun = towards(20.0, 0.0);
    Atmosphere air;
    air.model = SkyModel::scattering;
    scene.state = make_sky_state(scene.celestial, air);
    EXPECT_EQ(update_sky_tables(scene.state, scene.celestial, {}, scene.tables).rebuilt, 0U);
    EXPECT_EQ(scene.tables.atmosphere, nullptr);
    EXPECT_EQ(update_sky_tables(scene.state, scene.celestial, {.transmittance = true}, scene.tables).rebuilt, 1U);
    EXPECT_EQ(scene.tables.sun_view, nullptr);
    EXPECT_EQ(update_sky_tables(scene.state, scene.celestial, {.sky_view = true}, scene.tables).rebuilt, 1U);
    ASSERT_NE(scene.tables.sun_view, nullptr);
    EXPECT_EQ(scene.tables.moon_view, nullptr); // by day
    EXPECT_EQ(update_sky_tables(scene.state, scene.celestial, {.sky_view = true}, scene.tables).rebuilt, 0U);
    air.model = SkyModel::preetham;
    scene.state = make_sky_state(scene.celestial, air);
    EXPECT_EQ(update_sky_tables(scene.state, scene.celestial, {.sky_view = true}, scene.tables).rebuilt, 0U);
    EXPECT_EQ(scene.tables.atmosphere, nullptr);
}

class SkyModelStress : public test::StressTest {};

TEST_F(SkyModelStress, EveryModelEverywhere) {
    const std::vector<glm::vec3> directions = sphere(40);
    std::vector<glm::vec3> out(directions.size());
    SkyTables made; // the scattering air is the same throughout
    for (const SkyModel model : all_models) {
        for (const double altitude : {90.0, 30.0, 1e-7, 0.0, -1e-7, -0.3, -6.0, -18.0, -19.0, -90.0}) {
            for (const double height : {-400.0, 0.0, 12e3, 80e3}) {
                for (const int type : {1, 15}) {
                    Scene scene;
                    scene.celestial.to_sun = towards(altitude, 10.0);
                    scene.celestial.to_moon = towards(-altitude, 80.0);
                    Atmosphere air;
                    air.model = model;
                    air.turbidity = type == 1 ? 1.7F : 10.0F;
                    air.cie_type = type;
                    air.clearness = type == 1 ? 1.0F : 12.0F;
                    ASSERT_TRUE(check(air, height));
                    if (model == SkyModel::scattering && (type == 15 || height == 0.0)) {
                        continue; // tables take their time
                    }
                    scene.tables = made;
                    scene.make(air, height);
                    if (model == SkyModel::scattering) {
                        made = scene.tables;
                    }
                    sky_radiance(scene.state, &scene.tables, directions, out);
                    for (const glm::vec3& v : out) {
                        ASSERT_TRUE(std::isfinite(v.x + v.y + v.z)) << int(model) << ' ' << altitude;
                        ASSERT_TRUE(v.x >= 0.0F && v.y >= 0.0F && v.z >= 0.0F);
                    }
                    std::array<glm::vec3, 49> c{};
                    project_sky_state(scene.state, &scene.tables, 7, c);
                    ASSERT_TRUE(std::isfinite(c[0].x + c[48].z));
                    const DayLight day = level_illuminance(scene.state, &scene.tables);
                    ASSERT_GE(luminance(day.sky_lux), 0.0);
                }
            }
        }
    }
}

TEST(SkyModels, CheckNamesTheModelsFields) {
    const auto refused = [](auto&& change, const char* field) {
        Atmosphere air;
        change(air);
        const Status status = check(air);
        EXPECT_FALSE(status.has_value());
        EXPECT_NE(status.error().message().find(field), std::string::npos) << status.error().message();
    };
    const float nan = std::numeric_limits<float>::quiet_NaN();
    refused([](Atmosphere& a) { a.model = static_cast<SkyModel>(9); }, "model");
    refused([](Atmosphere& a) { a.model = SkyModel::perez, a.clearness = 0.5F; }, "clearness");
    refused([&](Atmosphere& a) { a.model = SkyModel::perez, a.brightness = nan; }, "brightness");
    refused([](Atmosphere& a) { a.model = SkyModel::cie_general, a.cie_type = 16; }, "cie_type");
    refused([&](Atmosphere& a) { a.model = SkyModel::cie_clear, a.zenith_cd_m2 = -1.0F; }, "zenith");
    refused([&](Atmosphere& a) { a.ozone_atm_cm = nan; }, "ozone");
    EXPECT_FALSE(check(Atmosphere{}, 81e3));
    EXPECT_FALSE(check(Atmosphere{}, std::numeric_limits<double>::quiet_NaN()));
    Atmosphere scattering; // fields that a model does not read may hold anything
    scattering.model = SkyModel::scattering;
    scattering.cie_type = 99;
    EXPECT_TRUE(check(scattering).has_value());
}

} // namespace
} // namespace alpenglow::sky
