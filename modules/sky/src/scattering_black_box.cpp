#include <alpenglow/sky/fit_sky.hpp>

#include <alpenglow/sky/colour.hpp>
#include <alpenglow/sky/scattering_tables.hpp>
#include <alpenglow/sky/sky_sh.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <mutex>

namespace alpenglow::sky {

SkyBlackBox scattering_black_box(double height_km, int elevations, int azimuths) {
    struct Cache {
        std::mutex mutex;
        std::map<std::pair<double, double>, std::shared_ptr<const ScatteringTables>> tables;
    };
    auto cache = std::make_shared<Cache>();
    return [=](std::span<const double> p, int bands, std::span<glm::dvec3> c) {
        std::shared_ptr<const ScatteringTables> tables;
        {
            const std::lock_guard<std::mutex> lock(cache->mutex);
            auto& entry = cache->tables[{p[1], p[2]}];
            if (!entry) {
                const Result<ScatteringAtmosphere> air = make_scattering_atmosphere(p[1], 0.35, glm::dvec3(p[2]));
                ScatteringResolution fine;
                fine.sun_heights = 256;
                fine.sun_angles = 256;
                fine.field_zeniths = 16;
                fine.field_orders = 7;
                entry =
                    std::make_shared<ScatteringTables>(air.has_value() ? air.value() : ScatteringAtmosphere{}, fine);
            }
            tables = entry;
        }
        SkyView view(128, 48);
        const auto mu_s = static_cast<float>(std::cos(p[0]));
        view.build(*tables, static_cast<float>(height_km), mu_s, 128);
        const glm::vec3 to_sun(static_cast<float>(std::sin(p[0])), 0.0F, mu_s);
        double least = std::numeric_limits<double>::max();
        project_symmetric_sky(
            [&](const glm::dvec3& v) {
                const glm::dvec3 rgb(view.radiance(glm::vec3(v), to_sun));
                least = std::min(least, luminance(rgb));
                return rgb;
            },
            p[0], bands, {elevations, azimuths}, c);
        return least;
    };
}

} // namespace alpenglow::sky
