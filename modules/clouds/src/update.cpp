#include <alpenglow/clouds/update.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace alpenglow::clouds {
namespace {

float luminance_of(const glm::vec3& c) {
    return 0.2126F * c.x + 0.7152F * c.y + 0.0722F * c.z;
}

float angle_between(const glm::vec3& a, const glm::vec3& b) {
    const glm::vec3 cross(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
    return std::atan2(std::sqrt(cross.x * cross.x + cross.y * cross.y + cross.z * cross.z),
                      a.x * b.x + a.y * b.y + a.z * b.z);
}

} // namespace

CloudSources cloud_sources(const SkyState& state, const SkyLightSh* sky, const glm::vec3& ground_albedo) {
    CloudSources out;
    const float sun = state.to_sun.z > -0.02F ? luminance_of(state.sun_illuminance_lux) : 0.0F;
    const float moon = state.to_moon.z > -0.02F ? luminance_of(state.moon_illuminance_lux) : 0.0F;
    const float brightest = std::max(sun, moon);
    const auto add = [&](float strength, const glm::vec3& to, const glm::vec3& illuminance, std::uint8_t kind) {
        if (strength > 0.0F && strength >= 1e-3F * brightest) {
            out.lights[out.count] = {to, illuminance, 0.0F};
            out.kind[out.count++] = kind;
        }
    };
    add(sun, state.to_sun, state.sun_illuminance_lux, 1);
    add(moon, state.to_moon, state.moon_illuminance_lux, 2);
    if (sky != nullptr && sky->bands > 0) {
        out.sky.bands = std::min(sky->bands, 4);
        std::copy_n(sky->coefficients.begin(), out.sky.bands * out.sky.bands, out.sky.coefficients.begin());
        // Irradiance of level ground: pi K_0 c_0 + (2 pi / 3) K_1 c_10 + (pi / 4) K_2 c_20 with K_l = sqrt((2l+1)/(4
        // pi)).
        constexpr float k[4] = {0.28209479F, 0.48860251F, 0.63078313F, 0.74635267F};
        constexpr float pi_f = 3.14159265F;
        const auto& c = out.sky.coefficients;
        glm::vec3 ground = pi_f * k[0] * c[0];
        ground += out.sky.bands > 1 ? 2.0F * pi_f / 3.0F * k[1] * c[2] : glm::vec3(0.0F);
        ground += out.sky.bands > 2 ? 0.25F * pi_f * k[2] * c[6] : glm::vec3(0.0F);
        for (int i = 0; i < out.count; ++i) {
            ground += std::max(out.lights[i].to_light.z, 0.0F) * out.lights[i].irradiance;
        }
        // Of a lower hemisphere of radiance 1: 2 pi K_l times the integral of P_l from -1 to 0, which is 1, -1/2, 0,
        // 1/8.
        constexpr float share[4] = {1.0F, -0.5F, 0.0F, 0.125F};
        for (int l = 0; l < out.sky.bands; ++l) {
            const glm::vec3 radiance(std::max(ground.x, 0.0F), std::max(ground.y, 0.0F), std::max(ground.z, 0.0F));
            out.sky.coefficients[std::size_t(l * (l + 1))] +=
                ground_albedo * radiance * (2.0F * k[l] * share[l]); // over pi: the plane's radiance
        }
    }
    return out;
}

Status check(const CloudVolume& cloud) {
    const auto bad = [](const char* field, float value, const char* expected) {
        return Error{std::to_string(value), std::string("CloudVolume::") + field, expected};
    };
    if (!(cloud.extinction_per_m > 0.0F) || !std::isfinite(cloud.extinction_per_m)) {
        return bad("extinction_per_m", cloud.extinction_per_m, "a finite number above 0");
    }
    if (!(cloud.albedo >= 0.0F && cloud.albedo <= 1.0F)) {
        return bad("albedo", cloud.albedo, "0 to 1");
    }
    if (!(std::abs(cloud.anisotropy) < 1.0F)) {
        return bad("anisotropy", cloud.anisotropy, "between -1 and 1");
    }
    if (!(cloud.max_error >= 0.0F)) {
        return bad("max_error", cloud.max_error, "0 or more");
    }
    return Ok{};
}

float CloudStaleness::bound() const {
    return anew ? std::numeric_limits<float>::infinity() : direction[0] + direction[1] + sky;
}

float turning_error(float angle_rad, float anisotropy) {
    const float width = std::cbrt(std::max(1.0F - std::abs(anisotropy), 5e-3F));
    return 3.0F * angle_rad / (width * width);
}

CloudStaleness staleness(const CloudVolume& cloud, const CloudLight& light, const CloudSources& sources) {
    CloudStaleness out;
    out.anew = !light.lighting || light.made_from_volume != cloud.volume ||
               light.made_from_extinction_per_m != cloud.extinction_per_m || light.made_from_albedo != cloud.albedo ||
               light.made_from_anisotropy != cloud.anisotropy || light.made_from_method != cloud.method ||
               light.lights != sources.count;
    for (int i = 0; i < sources.count && !out.anew; ++i) {
        out.anew = light.kind[std::size_t(i)] != sources.kind[i];
        out.direction[i] = turning_error(
            angle_between(light.made_from_to_light[std::size_t(i)], sources.lights[i].to_light), cloud.anisotropy);
    }
    const bool sky = cloud.skylit && sources.sky.bands > 0;
    if (sky != light.has_sky) {
        out.sky = std::numeric_limits<float>::infinity();
    } else if (sky) {
        // Radiance changes by at most the sum over coefficients of change times the function's maximum; transport is
        // linear in what comes in, and its picture no brighter than the brightest of it.
        float change = 0.0F;
        for (int k = 0; k < 16; ++k) {
            const glm::vec3 d = sources.sky.coefficients[std::size_t(k)] - light.made_from_sky[std::size_t(k)];
            const float most = k == 0 ? 0.2821F : (k < 4 ? 0.4886F : (k < 9 ? 1.0926F : 1.4454F));
            change += most * std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
        }
        const float mean = 0.2821F * luminance_of(light.made_from_sky[0]);
        out.sky = mean > 0.0F ? change / mean : (change > 0.0F ? std::numeric_limits<float>::infinity() : 0.0F);
    }
    return out;
}

bool refresh(const CloudVolume& cloud, CloudLight& light, const CloudSources& sources, const CloudStaleness& stale,
             int& depths) {
    bool started = false;
    if (stale.anew) {
        if (depths < sources.count && depths < 1) {
            return false;
        }
        const Medium medium{
            cloud.extinction_per_m, cloud.albedo, {PhaseKind::henyey_greenstein, cloud.anisotropy, 0.0F, 1.0F}};
        LightingSettings settings;
        settings.method = static_cast<LightingMethod>(cloud.method);
        // In slices over frames finer cells are worth their time.
        settings.max_transport_cells = std::size_t(1) << 19;
        settings.sweeps = 4;
        if (!light.lighting) {
            light.lighting = std::make_shared<CloudLighting>();
        }
        light.lighting->reset(*cloud.volume, medium, settings);
        if (light.made_from_volume != cloud.volume) {
            light.made_from_volume = cloud.volume;
            ++light.volume_revision;
        }
        light.made_from_extinction_per_m = cloud.extinction_per_m;
        light.made_from_albedo = cloud.albedo;
        light.made_from_anisotropy = cloud.anisotropy;
        light.made_from_method = cloud.method;
        light.lights = sources.count;
        light.has_sky = false;
        for (int i = 0; i < sources.count; ++i) {
            light.kind[std::size_t(i)] = sources.kind[i];
            light.made_from_to_light[std::size_t(i)] = sources.lights[i].to_light;
            light.lighting->start_light(std::size_t(i), sources.lights[i]);
            --depths;
        }
        started = true;
    }
    for (int i = 0; i < sources.count && !stale.anew; ++i) {
        light.lighting->set_irradiance(std::size_t(i), sources.lights[i].irradiance);
        // Half the budget goes to directions, so that sun, moon and sky together stay within it.
        if (stale.direction[i] > 0.5F * cloud.max_error && depths > 0 &&
            !light.lighting->working_on_light(std::size_t(i))) {
            light.lighting->start_light(std::size_t(i), sources.lights[i]);
            light.made_from_to_light[std::size_t(i)] = sources.lights[i].to_light;
            --depths;
            started = true;
        }
    }
    const bool sky = cloud.skylit && sources.sky.bands > 0;
    if ((sky != light.has_sky || stale.sky > 0.5F * cloud.max_error) && !light.lighting->working_on_sky()) {
        SkySh wanted = sources.sky;
        if (!sky) {
            wanted.bands = 0;
        }
        light.lighting->start_sky(wanted);
        light.made_from_sky = wanted.coefficients;
        light.has_sky = sky;
        started = true;
    }
    return started;
}

} // namespace alpenglow::clouds
