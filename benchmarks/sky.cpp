#include "bench.hpp"
#include "sky_support.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sky/scattering.hpp>
#include <alpenglow/sky/scattering_tables.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

const Case scattering_case("sky/scattering tables", [](const Context& context) {
    const sky::ScatteringAtmosphere air = *sky::make_scattering_atmosphere(2.5, 0.35, glm::dvec3(0.2));
    sky::ScatteringTables tables(air);
    Row row{.module = "sky",
            .name = "scattering tables",
            .method = "sun's light 64 x 128",
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

    // The sky of tables against single scattering in double plus the higher orders of the path tracer.
    sky::SkyView view;
    const int paths = context.quick() ? 1000 : 8000;
    double worst = 0.0;
    double mean = 0.0;
    double noise = 0.0;
    int count = 0;
    for (double altitude : {60.0, 20.0, 5.0, 0.0}) {
        const double h = altitude * degree_rad;
        const glm::dvec3 sun(std::cos(h), 0.0, std::sin(h));
        view.build(tables, 0.001F, static_cast<float>(sun.z));
        for (double elevation : {80.0, 35.0, 10.0}) {
            for (double azimuth : {30.0, 120.0}) {
                const double e = elevation * degree_rad;
                const double a = azimuth * degree_rad;
                const glm::dvec3 v(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
                const auto more = sky::trace_radiance(air, 0.001, v.z, sun.z, a, paths, 11, 2);
                const glm::dvec3 want =
                    sky::single_scattering(air, 0.001, v.z, sun.z, glm::dot(sun, v), 300) + more.mean;
                const double error = relative(glm::dvec3(view.radiance(glm::vec3(v), glm::vec3(sun))), want);
                worst = std::max(worst, error);
                mean += error;
                noise += glm::length(more.standard_error) / glm::length(want);
                ++count;
            }
        }
    }
    row.error = worst;
    row.error_metric = "max relative RGB, sun 60 to 0 degrees, 24 directions; mean " + std::to_string(mean / count) +
                       ", of which the reference's own noise " + std::to_string(noise / count);
    row.reference = "single scattering in double + path tracer";
    row.method = "multiple scattering 24 x 48 x 18";
    row.bytes = 4.0 * static_cast<double>(tables.field().size() + tables.aureole().size());
    context.run(row, [&] { tables.build_field(); });
    row.method = "sky view 108 x 24 x 12";
    row.bytes = 4.0 * static_cast<double>(view.values().size());
    context.run(row, [&] { view.build(tables, 0.001F, 0.5F); });
    row.method = "radiance from the view, a direction";
    const glm::vec3 sun(0.866F, 0.0F, 0.5F);
    const std::vector<glm::vec3> directions = hemisphere(512);
    row.items = 512;
    context.run(row, [&] {
        for (const glm::vec3& v : directions) {
            keep(view.radiance(v, sun));
        }
    });
});

} // namespace
} // namespace alpenglow::bench
