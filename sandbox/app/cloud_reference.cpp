#include "sandbox/app/cloud_reference.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <alpenglow/clouds/march.hpp>
#include <alpenglow/core/constants.hpp>

#include "sandbox/app/cloud_view.hpp"

namespace alpenglow::sandbox {
namespace {

constexpr int width = 64;
constexpr int height = 36;

} // namespace

clouds::SparseGrid layer_grid(const CloudSettings& settings, const CloudLayerSettings& layer) {
    const auto azimuth = static_cast<float>(settings.wind_from_deg * static_cast<float>(degree_rad));
    const clouds::Weather weather{.type = static_cast<clouds::CloudType>(layer.type),
                                  .cover = layer.cover,
                                  .base_m = layer.base_m,
                                  .top_m = layer.top_m,
                                  .wind_m_s = -settings.wind_m_s * glm::vec2(std::sin(azimuth), std::cos(azimuth)),
                                  .seed = static_cast<std::uint32_t>(layer.seed)};
    return clouds::generate(weather, glm::vec2(layer.extent_m), layer.voxel_m);
}

clouds::Camera reference_camera(const Camera& scene_camera) {
    return cloud_camera(scene_camera, width, height, 1);
}

clouds::ReferenceScene reference_scene(const clouds::SparseGrid& grid, const CloudMatter& matter,
                                       const clouds::CloudSources& sources) {
    clouds::ReferenceScene scene;
    scene.grid = &grid;
    scene.medium = {
        matter.extinction_per_m, matter.albedo, {clouds::PhaseKind::henyey_greenstein, matter.anisotropy, 0.0F, 1.0F}};
    scene.lights.assign(sources.lights, sources.lights + sources.count);
    scene.sky = [sky = sources.sky](const glm::vec3& direction) {
        return glm::max(sky.radiance(direction), glm::vec3(0.0F));
    };
    return scene;
}

std::string reference_note(const clouds::CloudSources& sources) {
    std::ostringstream note;
    const glm::vec3 to = sources.count > 0 ? sources.lights[0].to_light : glm::vec3(0.0F);
    note << to.x << ' ' << to.y << ' ' << to.z;
    return note.str();
}

std::optional<CloudReference> CloudReference::load(const CloudSettings& settings, const Camera& scene_camera) {
    if (settings.layers.size() != 1 || !settings.files.empty()) {
        return std::nullopt;
    }
    const std::filesystem::path path =
        std::filesystem::path(ALPENGLOW_CLOUD_REFERENCES) / (settings.scene + ".reference");
    std::error_code failed;
    if (!std::filesystem::exists(path, failed)) {
        return std::nullopt;
    }
    Result<clouds::ReferenceFile> file = clouds::load_reference(path.string());
    if (!file || file->image.width != width || file->image.height != height) {
        return std::nullopt;
    }
    CloudReference out;
    out.file_ = std::move(file).value();
    out.camera_ = reference_camera(scene_camera);
    std::istringstream(out.file_.note) >> out.to_light_.x >> out.to_light_.y >> out.to_light_.z;
    return out;
}

bool CloudReference::holds(const clouds::CloudSources& sources) const {
    constexpr float cos_half_degree = 0.99996192F;
    return sources.count > 0 && glm::dot(sources.lights[0].to_light, to_light_) > cos_half_degree;
}

clouds::ImageError CloudReference::error(const clouds::BrickVolume& volume, const clouds::CloudLighting& lighting,
                                         const clouds::SkySh& sky) const {
    // 3 x 3 rays a pixel: the path tracer's pixels are means.
    constexpr int rays = 3;
    clouds::Camera fine = camera_;
    fine.width *= rays;
    fine.height *= rays;
    const clouds::Picture picture = clouds::march(volume, lighting, fine);
    std::vector<glm::vec3> seen(std::size_t(width) * height, glm::vec3(0.0F));
    std::vector<float> alpha(seen.size(), 0.0F);
    for (int y = 0; y < fine.height; ++y) {
        for (int x = 0; x < fine.width; ++x) {
            const std::size_t from = std::size_t(y) * std::size_t(fine.width) + std::size_t(x);
            const std::size_t to = std::size_t(y / rays) * width + std::size_t(x / rays);
            const glm::vec3 direction = fine.direction(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F);
            const glm::vec3 behind = glm::max(sky.radiance(direction), glm::vec3(0.0F));
            seen[to] += (picture.radiance[from] + picture.transmittance[from] * behind) / float(rays * rays);
            alpha[to] += (1.0F - picture.transmittance[from]) / float(rays * rays);
        }
    }
    std::vector<bool> mask(seen.size());
    for (std::size_t i = 0; i < mask.size(); ++i) {
        mask[i] = alpha[i] > 0.01F;
    }
    return clouds::image_error(seen, file_.image, mask);
}

} // namespace alpenglow::sandbox
