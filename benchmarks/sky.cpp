// The scattering atmosphere: tables against the oracle, and a day of them.
#include "bench.hpp"
#include "sky_support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/aerial_table.hpp>
#include <alpenglow/sky/scattering_oracle.hpp>
#include <alpenglow/sky/scattering_tables.hpp>
#include <alpenglow/sky/sky_state.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

const Case scattering_case("sky/scattering tables", [](const Context& context) {
    const sky::ScatteringAtmosphere air = *sky::make_scattering_atmosphere(2.5, 0.35, glm::dvec3(0.2));
    sky::ScatteringTables tables(air);
    Row row{.module = "sky",
            .name = "scattering tables",
            .method = "sun's light 128 x 160",
            .error_metric = "max absolute, 5 heights to 60 km, sun over the limb",
            .reference = "double, 256 nodes"};
    for (double h : {0.0, 1.3, 7.7, 25.0, 60.0}) {
        const double dip = std::acos(air.ground_radius_km / (air.ground_radius_km + h));
        for (double altitude = 0.3; altitude < 1.57; altitude *= 1.2) {
            const double mu = std::sin(altitude - dip);
            row.error = std::max(row.error, glm::length(glm::dvec3(tables.sun_transmittance(float(h), float(mu))) -
                                                        sky::sun_transmittance(air, h, mu)));
        }
    }
    row.bytes = 4.0 * static_cast<double>(tables.sun().size());
    context.run(row, [&] { tables.build_sun(); });
    row.method = "scattered light, 14 bands x 33 heights x 112 angles";
    row.error = 0.0;
    row.error_metric = "see the sky view";
    row.bytes = static_cast<double>(tables.field_bytes());
    context.run(row, [&] { tables.build_field(); });

    // Each sun's sky against successive orders in double.
    sky::SkyView view;
    row.reference = "successive orders in double, 18 bands";
    row.bytes = 4.0 * static_cast<double>(view.rows() * view.columns() * sky::sky_view_values);
    const std::vector<double> altitudes =
        context.quick() ? std::vector<double>{20.0, 0.0} : std::vector<double>{60.0, 20.0, 5.0, 0.0, -3.0, -6.0, -12.0};
    for (const double altitude : altitudes) {
        sky::OracleResolution resolution;
        resolution.zeniths = 12;
        resolution.step_rad = altitude > 15.0 ? 0.0175 : 0.0087;
        const sky::ScatteringOracle oracle(air, (90.0 - altitude) * degree_rad, resolution);
        const double h = altitude * degree_rad;
        const glm::dvec3 sun(std::cos(h), 0.0, std::sin(h));
        view.build(tables, 0.001F, static_cast<float>(sun.z));
        double mean = 0.0;
        int count = 0;
        row.error = 0.0;
        for (const double elevation : {-30.0, 1.0, 3.0, 10.0, 35.0, 80.0}) {
            for (const double azimuth : {3.0, 40.0, 100.0, 170.0}) {
                const double e = elevation * degree_rad;
                const double a = azimuth * degree_rad;
                const glm::dvec3 v(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
                const double error = relative(glm::dvec3(view.radiance(glm::vec3(v), glm::vec3(sun))),
                                              oracle.radiance(0.001, v.z, a, 200));
                row.error = std::max(row.error, error);
                mean += error;
                ++count;
            }
        }
        row.method = "sky view 108 x 97 (192 around), sun at " + std::to_string(static_cast<int>(altitude));
        row.error_metric = "max relative RGB, 24 directions; mean " + std::to_string(mean / count);
        context.run(row, [&] { view.build(tables, 0.001F, static_cast<float>(sun.z)); });
    }
    row.error = 0.0;
    row.error_metric = "is the table";
    row.reference = "";
    row.method = "radiance from the view, a direction";
    const glm::vec3 sun(0.866F, 0.0F, 0.5F);
    const std::vector<glm::vec3> directions = hemisphere(512);
    row.items = 512;
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(view.radiance(v, sun));
        }
    });
    row.items = 1;
    sky::AerialTable aerial;
    aerial.build(tables, 0.5F, 0.5F);
    row.method = "aerial table 32 x 32 x 32";
    row.bytes = 12.0 * static_cast<double>(aerial.light().size() + aerial.extinction().size());
    context.run(row, [&] { aerial.build(tables, 0.5F, 0.5F); });
});

// A day at the equinox, 47 degrees north, in minutes: how often tables are rebuilt, and what the kept ones are off by.
const Case day_case("sky/scattering day", [](const Context& context) {
    Atmosphere air;
    air.model = SkyModel::scattering;
    air.max_error = 0.02F;
    CelestialState celestial;
    celestial.to_moon = {0.0F, 0.0F, -1.0F};
    SkyState state;
    SkyTables tables;
    SkyTables secret;
    const std::vector<glm::vec3> directions = hemisphere(48);
    std::vector<glm::vec3> kept(directions.size());
    std::vector<glm::vec3> now(directions.size());
    int states = 0;
    std::uint32_t rebuilt = 0;
    double worst = 0.0;
    double step = 0.0; // the largest step of illuminance from minute to minute, relative
    double before = 0.0;
    const int minutes = context.quick() ? 720 : 1440;
    for (int minute = 0; minute < minutes; ++minute) {
        const double hour_angle = two_pi * minute / 1440.0 - pi;
        const double latitude = 47.0 * degree_rad;
        celestial.to_sun = glm::vec3(glm::dvec3(-std::sin(hour_angle), -std::sin(latitude) * std::cos(hour_angle),
                                                std::cos(latitude) * std::cos(hour_angle)));
        if (!(sky::drift_bound(state, celestial, air) <= static_cast<double>(air.max_error))) {
            state = sky::make_sky_state(celestial, air);
            state.revision = 1;
            ++states;
        }
        rebuilt += sky::update_sky_tables(state, celestial, {.sky_view = true}, tables).rebuilt;
        const SkyState exact = sky::make_sky_state(celestial, air);
        if (minute % 15 == 0 && tables.sun_view != nullptr) {
            secret = tables;
            secret.sun_view = nullptr;
            sky::update_sky_tables(exact, celestial, {.sky_view = true}, secret);
            sky::sky_radiance(state, &tables, directions, kept);
            sky::sky_radiance(exact, &secret, directions, now);
            for (std::size_t i = 0; i < kept.size(); ++i) {
                worst = std::max(worst, relative(glm::dvec3(kept[i]), glm::dvec3(now[i])));
            }
        }
        const sky::DayLight light = sky::level_illuminance(exact, &tables);
        const double total = static_cast<double>(light.sun_lux.y + light.sky_lux.y + light.moon_lux.y);
        if (before > 0.0) {
            step = std::max(step, std::abs(std::log(total / before)));
        }
        before = total;
    }
    Row row{.module = "sky",
            .name = "a day of the scattering sky",
            .method = std::to_string(rebuilt) + " tables and " + std::to_string(states) + " states in " +
                      std::to_string(minutes) + " minutes, max_error 0.02",
            .error = worst,
            .error_metric =
                "max relative RGB, 48 directions; largest step of illuminance in a minute e^" + std::to_string(step),
            .reference = "rebuilt in secret"};
    context.run(row, [&] { keep(sky::update_sky_tables(state, celestial, {.sky_view = true}, tables)); });
});

} // namespace
} // namespace alpenglow::bench
