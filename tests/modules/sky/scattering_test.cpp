#include <alpenglow/sky/aerial_table.hpp>
#include <alpenglow/sky/scattering.hpp>
#include <alpenglow/sky/scattering_oracle.hpp>
#include <alpenglow/sky/scattering_tables.hpp>

#include <fp_traps.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/phase.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::sky {
namespace {

ScatteringAtmosphere clear() {
    return *make_scattering_atmosphere(2.5, 0.35, glm::dvec3(0.2));
}

glm::dvec3 towards(double altitude_deg, double azimuth_deg) {
    const double a = altitude_deg * degree_rad;
    const double z = azimuth_deg * degree_rad;
    return {std::cos(a) * std::cos(z), std::cos(a) * std::sin(z), std::sin(a)};
}

TEST(Scattering, VerticalDepthIsTheColumn) {
    const ScatteringAtmosphere air = clear();
    const glm::dvec3 depth = optical_depth(air, 0.0, 1.0, 0.0, air.top_km, 64);
    const glm::dvec3 want =
        air.rayleigh_per_km * air.rayleigh_height_km * (1.0 - std::exp(-100.0 / air.rayleigh_height_km)) +
        (air.mie_scattering_per_km + air.mie_absorption_per_km) * air.mie_height_km + air.ozone_per_km * 15.0;
    EXPECT_LT(glm::length(depth - want), 1e-5 * glm::length(want));
}

// Transmittance between two points is the same both ways, and along a ray it multiplies.
TEST(Scattering, TransmittanceIsReciprocalAndMultiplies) {
    const ScatteringAtmosphere air = clear();
    const double r0 = air.ground_radius_km + 2.0;
    const double mu = 0.03;
    const double length = 300.0;
    const double r1 = std::sqrt(r0 * r0 + 2.0 * r0 * mu * length + length * length);
    const double back = -(r0 * mu + length) / r1;
    const glm::dvec3 there = optical_depth(air, 2.0, mu, 0.0, length, 64);
    const glm::dvec3 again = optical_depth(air, r1 - air.ground_radius_km, back, 0.0, length, 64);
    EXPECT_LT(glm::length(there - again), 1e-6 * glm::length(there));
    const glm::dvec3 parts =
        optical_depth(air, 2.0, mu, 0.0, 100.0, 64) + optical_depth(air, 2.0, mu, 100.0, length, 64);
    EXPECT_LT(glm::length(there - parts), 1e-6 * glm::length(there));
}

// A thin, flat layer: single scattering has a closed form, E P(nu) mu_s / (mu + mu_s) (1 - e^(-tau (1/mu + 1/mu_s))) w.
TEST(Scattering, SingleScatteringIsThePlaneParallelLimit) {
    ScatteringAtmosphere air;
    air.ground_radius_km = 1e7; // flat
    air.rayleigh_per_km = glm::dvec3(0.05, 0.1, 0.2) / 8.0;
    air.mie_scattering_per_km = air.mie_absorption_per_km = air.ozone_per_km = air.ground_albedo = glm::dvec3(0.0);
    air.sun_lux = glm::dvec3(1.0);
    const double mu = 0.7;
    const double mu_s = 0.4;
    const double nu = mu * mu_s;
    const glm::dvec3 got = single_scattering(air, 0.0, mu, mu_s, nu, 2000);
    for (int c = 0; c < 3; ++c) {
        const double tau = air.rayleigh_per_km[c] * 8.0;
        // Seen from below: light falls and goes on down.
        const double want = phase_rayleigh(nu) * mu_s / (mu_s - mu) * (std::exp(-tau / mu_s) - std::exp(-tau / mu));
        EXPECT_NEAR(got[c] / want, 1.0, 2e-3);
    }
}

TEST(Scattering, PathTracerAgreesWithSingleScattering) {
    ScatteringAtmosphere air = clear();
    const glm::dvec3 sun = towards(30.0, 0.0);
    const glm::dvec3 v = towards(50.0, 70.0);
    const MonteCarlo all = trace_radiance(air, 0.001, v.z, sun.z, 70.0 * degree_rad, 20000, 1, 1);
    const MonteCarlo more = trace_radiance(air, 0.001, v.z, sun.z, 70.0 * degree_rad, 20000, 1, 2);
    const glm::dvec3 single = single_scattering(air, 0.001, v.z, sun.z, glm::dot(sun, v), 400);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(all.mean[c] - more.mean[c], single[c], 5.0 * all.standard_error[c]);
    }
}

// Successive orders in double against the path tracer: two ways to the same light.
TEST(ScatteringOracle, AgreesWithThePathTracer) {
    const ScatteringAtmosphere air = clear();
    OracleResolution resolution;
    resolution.heights = 25;
    resolution.zeniths = 10;
    resolution.angles = 32;
    resolution.step_rad = 0.0175;
    const ScatteringOracle oracle(air, 65.0 * degree_rad, resolution);
    const glm::dvec3 sun = towards(25.0, 0.0);
    for (const auto& [altitude, azimuth] : {std::array{40.0, 60.0}, {10.0, 150.0}}) {
        const glm::dvec3 v = towards(altitude, azimuth);
        const MonteCarlo more = trace_radiance(air, 0.001, v.z, sun.z, azimuth * degree_rad, 20000, 3, 2);
        const glm::dvec3 want = single_scattering(air, 0.001, v.z, sun.z, glm::dot(sun, v), 300) + more.mean;
        const glm::dvec3 got = oracle.radiance(0.001, v.z, azimuth * degree_rad);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(got[c], want[c], 0.005 * want[c] + 4.0 * more.standard_error[c]) << altitude << ' ' << c;
        }
    }
}

// Over flat ground, where a level plane takes in what falls on it: ground + air + space = the sun's light.
TEST(ScatteringOracle, EnergyIsConserved) {
    for (const double turbidity : {1.2, 4.0}) {
        ScatteringAtmosphere air = *make_scattering_atmosphere(turbidity, 0.35, glm::dvec3(0.3));
        air.ground_radius_km = 1e7;
        OracleResolution resolution;
        resolution.heights = 65;
        resolution.orders = 12;
        resolution.angles = 16;
        resolution.bands = 10;
        const ScatteringOracle::Balance balance = ScatteringOracle(air, 50.0 * degree_rad, resolution).flat_balance();
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(balance.ground[c] + balance.air[c] + balance.space[c], 1.0, 2e-3)
                << turbidity << ' ' << c << ": " << balance.ground[c] << ' ' << balance.air[c] << ' '
                << balance.space[c];
        }
    }
}

TEST(ScatteringTables, BrightGroundBrightensTheSky) {
    const ScatteringTables dark(*make_scattering_atmosphere(2.5, 0.0, glm::dvec3(0.0)));
    const ScatteringTables white(*make_scattering_atmosphere(2.5, 0.0, glm::dvec3(0.8)));
    const glm::vec3 d = dark.ground_illuminance_lux(0.7F);
    const glm::vec3 w = white.ground_illuminance_lux(0.7F);
    EXPECT_GT(w.z, 1.05F * d.z);
    EXPECT_LT(w.z, 1.5F * d.z);
    EXPECT_LT(luminance(w), 133334.0F * 0.7F * 1.1F);
}

TEST(ScatteringTables, SunTableKeepsToTheOracle) {
    const ScatteringAtmosphere air = clear();
    const ScatteringTables tables(air);
    // Worst above 50 km, where rays graze the ozone from outside.
    for (const auto& [h, most] :
         {std::pair{0.0, 0.003}, {1.3, 0.003}, {7.7, 0.003}, {25.0, 0.003}, {41.0, 0.006}, {60.0, 0.021}}) {
        const double dip = std::acos(air.ground_radius_km / (air.ground_radius_km + h));
        double worst = 0.0;
        for (double altitude = 0.5; altitude < 90.0; altitude += altitude < 6.0 ? 0.1 : 4.0) {
            const double mu = std::sin(altitude * degree_rad - dip);
            const glm::dvec3 want = sun_transmittance(air, h, mu);
            const glm::dvec3 got(tables.sun_transmittance(float(h), float(mu)));
            worst = std::max(worst, glm::length(got - want));
        }
        EXPECT_LT(worst, most) << h << " km";
    }
}

// The sky of the tables against the oracle; the benchmark has more suns.
TEST(ScatteringTables, SkyKeepsToTheOracle) {
    const ScatteringAtmosphere air = clear();
    const ScatteringTables tables(air);
    SkyView view;
    struct Want {
        double sun, mean, worst;
    };
    for (const Want& want : {Want{45.0, 0.01, 0.025}, Want{0.0, 0.015, 0.03}}) {
        OracleResolution resolution;
        resolution.heights = 25;
        resolution.zeniths = 10;
        resolution.angles = 48;
        resolution.step_rad = want.sun > 15.0 ? 0.0175 : 0.0087;
        const ScatteringOracle oracle(air, (90.0 - want.sun) * degree_rad, resolution);
        const glm::dvec3 sun = towards(want.sun, 0.0);
        view.build(tables, 0.001F, float(sun.z));
        double sum = 0.0;
        int count = 0;
        for (const double altitude : {-30.0, 3.0, 10.0, 35.0, 80.0}) {
            for (const double azimuth : {3.0, 40.0, 150.0}) {
                const glm::dvec3 v = towards(altitude, azimuth);
                const glm::dvec3 exact = oracle.radiance(0.001, v.z, azimuth * degree_rad);
                const glm::dvec3 got(view.radiance(glm::vec3(v), glm::vec3(sun)));
                for (int c = 0; c < 3; ++c) {
                    const double error = std::abs(got[c] / exact[c] - 1.0);
                    EXPECT_LE(error, want.worst) << want.sun << ' ' << altitude << ' ' << azimuth << ' ' << c;
                    sum += error;
                    ++count;
                }
            }
        }
        EXPECT_LE(sum / count, want.mean) << want.sun;
    }
}

// Looking down at the ground: the air before it and what the air leaves of it, against the oracle.
TEST(AerialTable, GroundThroughTheAirKeepsToTheOracle) {
    const ScatteringAtmosphere air = clear();
    const ScatteringTables tables(air);
    AerialTable table;
    OracleResolution resolution;
    resolution.heights = 25;
    resolution.zeniths = 10;
    resolution.angles = 32;
    resolution.step_rad = 0.0175;
    const double height = 2.0;
    const glm::dvec3 sun = towards(35.0, 0.0);
    const ScatteringOracle oracle(air, 55.0 * degree_rad, resolution);
    table.build(tables, float(height), float(sun.z));
    double mean = 0.0;
    for (const double altitude : {-60.0, -20.0, -6.0, -3.0}) {
        for (const double azimuth : {5.0, 70.0, 170.0}) {
            const glm::dvec3 v = towards(altitude, azimuth);
            const RaySpan span = ray_span(air, height, v.z);
            ASSERT_TRUE(span.ground);
            const double local =
                ((air.ground_radius_km + height) * sun.z + span.end_km * glm::dot(v, sun)) / air.ground_radius_km;
            const AerialPerspective got = table.evaluate(glm::vec3(v), float(span.end_km), glm::vec3(sun));
            const glm::dvec3 ground = air.ground_albedo / pi * glm::dvec3(tables.ground_illuminance_lux(float(local)));
            const glm::dvec3 sum = glm::dvec3(got.transmittance) * ground + glm::dvec3(got.in_scatter);
            const glm::dvec3 want = oracle.radiance(height, v.z, azimuth * degree_rad);
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(sum[c] / want[c], 1.0, 0.05) << altitude << ' ' << azimuth << ' ' << c;
                mean += std::abs(sum[c] / want[c] - 1.0) / 36.0;
            }
        }
    }
    EXPECT_LT(mean, 0.03);
    // Nothing over no distance, more light and less of the rest over more.
    const glm::vec3 level(0.8F, 0.6F, 0.0F);
    EXPECT_EQ(table.evaluate(level, 0.0F, glm::vec3(sun)).in_scatter, glm::vec3(0.0F));
    EXPECT_EQ(table.evaluate(level, 0.0F, glm::vec3(sun)).transmittance, glm::vec3(1.0F));
    float before = 0.0F;
    for (float distance = 0.01F; distance < 100.0F; distance *= 1.5F) {
        const AerialPerspective at = table.evaluate(level, distance, glm::vec3(sun));
        EXPECT_GT(at.in_scatter.z, before);
        before = at.in_scatter.z;
    }
}

TEST(ScatteringTables, TwilightFallsSmoothlyAndBlues) {
    const ScatteringTables tables(clear());
    double before = 1e9;
    for (double altitude = 5.0; altitude >= -18.0; altitude -= 0.25) {
        const double lux = luminance(tables.ground_illuminance_lux(float(std::sin(altitude * degree_rad))));
        if (before < 1e9) {
            EXPECT_LT(lux, before) << altitude;
            EXPECT_GT(lux, before * 0.6) << altitude;
        }
        before = lux;
    }
    // Janiczek and DeYoung 1987: 3.4 lux at -6 degrees; turbidity and refraction shift it by a factor of two.
    const double civil = luminance(tables.ground_illuminance_lux(float(std::sin(-6.0 * degree_rad))));
    EXPECT_GT(civil, 1.5);
    EXPECT_LT(civil, 12.0);
    const glm::vec3 at = tables.ground_illuminance_lux(float(std::sin(-5.0 * degree_rad)));
    EXPECT_GT(at.z, at.y); // ozone's blue hour
}

TEST(ScatteringTables, SameBitsEveryTime) {
    const ScatteringTables a(clear());
    const ScatteringTables b(clear());
    SkyView one;
    SkyView two;
    one.build(a, 0.1F, 0.3F);
    two.build(b, 0.1F, 0.3F);
    EXPECT_TRUE(std::equal(one.values().begin(), one.values().end(), two.values().begin()));
    EXPECT_TRUE(std::equal(a.sun().begin(), a.sun().end(), b.sun().begin()));
}

TEST(Scattering, BadParametersAreNamed) {
    EXPECT_NE(make_scattering_atmosphere(0.5, 0.3, glm::dvec3(0.2)).error().message().find("turbidity"),
              std::string::npos);
    EXPECT_NE(make_scattering_atmosphere(2.5, -1.0, glm::dvec3(0.2)).error().message().find("ozone"),
              std::string::npos);
    EXPECT_FALSE(make_scattering_atmosphere(2.5, 0.3, glm::dvec3(0.2, 1.5, 0.2)));
    EXPECT_FALSE(make_scattering_atmosphere(std::nan(""), 0.3, glm::dvec3(0.2)));
}

class ScatteringStress : public test::StressTest {};

TEST_F(ScatteringStress, EveryRayAndObserver) {
    for (double turbidity : {1.0, 2.5, 10.0}) {
        const ScatteringAtmosphere air = *make_scattering_atmosphere(turbidity, 0.35, glm::dvec3(0.0, 0.5, 1.0));
        const ScatteringTables tables(air);
        for (float height : {0.0F, 1e-4F, 12.0F, 80.0F, 100.0F}) {
            for (float sun : {1.0F, 0.5F, 1e-7F, 0.0F, -1e-7F, -0.05F, -0.31F, -1.0F}) {
                SkyView view(32, 9);
                view.build(tables, height, sun, 16);
                const glm::vec3 to_sun(std::sqrt(std::max(1.0F - sun * sun, 0.0F)), 0.0F, sun);
                for (double altitude : {-90.0, -45.0, -1.0, -1e-7, 0.0, 1e-7, 0.3, 30.0, 90.0}) {
                    for (double azimuth : {0.0, 90.0, 180.0, 271.0}) {
                        const glm::vec3 v(towards(altitude, azimuth));
                        const glm::vec3 rgb = view.radiance(v, to_sun);
                        for (int c = 0; c < 3; ++c) {
                            ASSERT_TRUE(std::isfinite(rgb[c])) << height << ' ' << sun << ' ' << altitude;
                            ASSERT_GE(rgb[c], 0.0F);
                        }
                    }
                }
                ASSERT_TRUE(std::isfinite(luminance(view.radiance(to_sun, to_sun))));
                ASSERT_TRUE(std::isfinite(luminance(view.radiance(-to_sun, to_sun))));
            }
        }
        for (double mu : {1.0, 1e-7, 0.0, -1e-7, -0.2, -1.0}) {
            for (double h : {0.0, 50.0, 100.0, 500.0}) {
                const RaySpan span = ray_span(air, h, mu);
                ASSERT_LE(span.begin_km, span.end_km);
                ASSERT_GE(optical_depth(air, h, mu, span.begin_km, span.end_km, 16).x, 0.0);
                const glm::dvec3 t = sun_transmittance(air, h, mu);
                ASSERT_TRUE(t.x >= 0.0 && t.x <= 1.0);
            }
        }
    }
}

TEST_F(ScatteringStress, ThinAndThickAir) {
    for (double scale : {1e-8, 1e-3, 1e2, 1e4}) {
        ScatteringAtmosphere air = clear();
        air.rayleigh_per_km *= scale;
        air.mie_scattering_per_km *= scale;
        air.mie_absorption_per_km *= scale;
        const ScatteringTables tables(air);
        SkyView view(16, 9);
        view.build(tables, 0.001F, 0.5F, 16);
        const glm::vec3 rgb = view.radiance(glm::vec3(0.6F, 0.0F, 0.8F), glm::vec3(0.866F, 0.0F, 0.5F));
        for (int c = 0; c < 3; ++c) {
            ASSERT_TRUE(std::isfinite(rgb[c]));
            ASSERT_GE(rgb[c], 0.0F);
        }
    }
}

} // namespace
} // namespace alpenglow::sky
