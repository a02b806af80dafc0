#include "study.hpp"

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/reference.hpp>
#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace alpenglow::tool {
namespace {

using namespace clouds;

constexpr int width = 96;
constexpr int height = 54;
constexpr const char* view_names[] = {"side", "front", "back", "sky"};

glm::dvec3 direction(double azimuth_deg, double elevation_deg) {
    const double a = azimuth_deg * degree_rad;
    const double e = elevation_deg * degree_rad;
    return {std::sin(a) * std::cos(e), std::cos(a) * std::cos(e), std::sin(e)};
}

// The sun stands at azimuth 0, 30 degrees high.
Camera view_of(int view, const glm::dvec3& centre, double extent) {
    const glm::dvec3 from[] = {direction(90, 5), direction(15, 15), direction(170, -20), direction(60, 5)};
    return look_at(centre + from[view] * (1.9 * extent), centre, 0.30F, width, height);
}

LightingMethod method_of(const std::string& name) {
    return name == "single"    ? LightingMethod::single_scattering
           : name == "harris"  ? LightingMethod::harris
           : name == "octaves" ? LightingMethod::octaves
                               : LightingMethod::transport;
}

// Pixels averaged over 4 x 4 rays, as the reference averages over its samples.
Picture averaged(const BrickVolume& volume, const CloudLighting& lighting, const Camera& camera) {
    Camera fine = camera;
    fine.width *= 4;
    fine.height *= 4;
    const Picture rays = march(volume, lighting, fine);
    Picture out(camera.width, camera.height);
    std::fill(out.transmittance.begin(), out.transmittance.end(), 0.0F);
    for (int y = 0; y < fine.height; ++y) {
        for (int x = 0; x < fine.width; ++x) {
            const std::size_t from = std::size_t(y) * std::size_t(fine.width) + std::size_t(x);
            const std::size_t to = std::size_t(y / 4) * std::size_t(camera.width) + std::size_t(x / 4);
            out.radiance[to] += rays.radiance[from] / 16.0F;
            out.transmittance[to] += rays.transmittance[from] / 16.0F;
        }
    }
    return out;
}

} // namespace

Status run_study(const StudyOptions& options) {
    std::error_code failure;
    std::filesystem::create_directories(options.folder, failure);
    if (failure) {
        return Error{"cannot be made: " + failure.message(), options.folder, "a folder for the references"};
    }
    const SparseGrid grid = options.cloud < 100 ? cumulus_of_study(options.cloud) : noise_cloud(options.cloud, 96);
    const BrickVolume volume(grid);
    const glm::dvec3 centre = glm::dvec3(volume.active_low() + volume.active_high()) * 0.5;
    const glm::ivec3 size = volume.active_high() - volume.active_low();
    const DirectionalLight sun{glm::vec3(direction(0, 30)), glm::vec3(1.0F), 0.0F};
    std::printf("cloud %u: %d x %d x %d voxels, %zu active\n\n", options.cloud, size.x + 1, size.y + 1, size.z + 1,
                volume.active_voxels());
    if (!options.references_only) {
        std::printf("| albedo | g | view | reference noise |");
        for (const std::string& name : options.methods) {
            std::printf(" %s |", name.c_str());
        }
        std::printf("\n|---|---|---|---|%s\n",
                    [&] {
                        std::string columns;
                        for (std::size_t i = 0; i < options.methods.size(); ++i) {
                            columns += "---|";
                        }
                        return columns;
                    }()
                        .c_str());
    }
    double bake_s = 0.0;
    int bakes = 0;
    for (const double albedo : options.albedos) {
        for (const double g : options.anisotropies) {
            Medium medium{1.0F, static_cast<float>(albedo), {}};
            medium.phase.g = static_cast<float>(g);
            for (int view = 0; view < 4; ++view) {
                char name[64];
                std::snprintf(name, sizeof name, "/c%u_a%.2f_g%.2f_%s.ref", options.cloud, albedo, g, view_names[view]);
                const std::string path = options.folder + name;
                const Camera camera = view_of(view, centre, double(std::max({size.x, size.y, size.z})));
                ReferenceFile file;
                if (std::filesystem::exists(path)) {
                    auto loaded = load_reference(path);
                    if (!loaded) {
                        return loaded.error();
                    }
                    file = std::move(*loaded);
                } else {
                    file.image = ReferenceImage(width, height);
                }
                if (file.image.samples() < std::uint64_t(options.samples)) {
                    ReferenceScene scene;
                    scene.grid = &grid;
                    scene.medium = medium;
                    if (view < 3) {
                        scene.lights = {sun};
                    } else {
                        scene.sky = [](const glm::vec3&) { return glm::vec3(1.0F); };
                    }
                    const std::uint64_t more = std::uint64_t(options.samples) - file.image.samples();
                    PathTracer(std::move(scene)).render(camera, file.image, file.next_sample, more);
                    file.next_sample += more;
                    if (Status saved = save_reference(path, file); !saved) {
                        return saved;
                    }
                }
                if (options.references_only) {
                    continue;
                }
                std::string cells;
                double noise = 0.0;
                for (const std::string& method : options.methods) {
                    LightingSettings settings;
                    settings.method = method_of(method);
                    if (options.transport_factor > 0) {
                        settings.transport_factor = options.transport_factor;
                        settings.max_transport_cells = std::size_t(1) << 23; // whatever it costs
                    }
                    settings.sweeps = options.sweeps > 0 ? options.sweeps : settings.sweeps;
                    CloudLighting lighting;
                    lighting.reset(volume, medium, settings);
                    const double start = process_cpu_seconds();
                    if (view < 3) {
                        lighting.bake_light(0, sun);
                    } else {
                        lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)));
                    }
                    if (settings.method == LightingMethod::transport) {
                        bake_s += process_cpu_seconds() - start;
                        ++bakes;
                    }
                    Picture picture = averaged(volume, lighting, camera);
                    std::vector<bool> mask;
                    for (std::size_t i = 0; i < picture.radiance.size(); ++i) {
                        mask.push_back(picture.transmittance[i] < 0.99F);
                        if (view == 3) {
                            picture.radiance[i] += picture.transmittance[i];
                        }
                    }
                    const ImageError error = image_error(picture.radiance, file.image, mask);
                    noise = error.noise;
                    char cell[64];
                    std::snprintf(cell, sizeof cell, " %.3f, %+.1f %% |", error.relative_rmse, 100.0 * error.bias);
                    cells += cell;
                }
                std::printf("| %.2f | %.2f | %s | %.3f |%s\n", albedo, g, view_names[view], noise, cells.c_str());
                std::fflush(stdout);
            }
        }
    }
    if (bakes > 0) {
        std::printf("\ntransport: %.3f s of CPU time a bake of sun or sky, mean of %d\n", bake_s / bakes, bakes);
    }
    return Ok{};
}

} // namespace alpenglow::tool
