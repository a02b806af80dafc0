// A small game: where the sun stands over Innsbruck, by a system on the carried registry, and how bright the zenith is.
#include <alpenglow/components/celestial.hpp>
#include <alpenglow/components/observer.hpp>
#include <alpenglow/ecs/registry.hpp>
#include <alpenglow/ephemeris/time.hpp>
#include <alpenglow/sky/sky_state.hpp>
#include <alpenglow/systems/ephemeris.hpp>
#include <alpenglow/systems/frame.hpp>
#include <alpenglow/systems/sky.hpp>

#include <cmath>
#include <cstdio>

int main() {
    using namespace alpenglow;
    BasicRegistry registry;
    const auto world = registry.create();
    const double latitude_rad = 47.27 / 57.29578;
    const double longitude_rad = 11.39 / 57.29578;
    const Frame frame;

    registry.emplace<WorldClock>(world, *ephemeris::parse_time("2026-06-21T05:30:00Z"));
    registry.emplace<Observer>(world, latitude_rad, longitude_rad);
    registry.emplace<CelestialState>(world);
    update_ephemeris(registry, frame);
    const glm::vec3 to_sun = registry.get<CelestialState>(world).to_sun;

    registry.emplace<Atmosphere>(world);
    update_sky(registry, frame);
    const SkyState& sky = registry.get<SkyState>(world);
    const glm::vec3 zenith = sky::sky_radiance(sky, sky::preetham_of(sky), {0.0F, 0.0F, 1.0F});
    const double altitude_deg = std::asin(static_cast<double>(to_sun.z)) * 57.29578;
    std::printf("sun %.2f degrees up, zenith %.0f %.0f %.0f cd/m^2\n", altitude_deg, static_cast<double>(zenith.r),
                static_cast<double>(zenith.g), static_cast<double>(zenith.b));
    // Two hours after sunrise at midsummer: the sun stands in the east, some 20 degrees up, and the sky is blue.
    return altitude_deg > 15.0 && altitude_deg < 30.0 && to_sun.x > 0.0F && zenith.b > zenith.r ? 0 : 1;
}
