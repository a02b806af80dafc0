// Several clouds in one picture.
#include <alpenglow/clouds/march.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {

PixelRect bounds_on_screen(const LitCloud& cloud, const Camera& camera, const PixelRect& within) {
    const PixelRect all = within.empty() ? PixelRect{0, 0, camera.width, camera.height} : within;
    if (cloud.volume->empty()) {
        return {};
    }
    const GridTransform& transform = cloud.volume->transform();
    const glm::dvec3 low(cloud.volume->active_low() - 1);
    const glm::dvec3 high(cloud.volume->active_high() + 1);
    const auto along = [](const glm::vec3& axis, const glm::dvec3& v) {
        return double(axis.x) * v.x + double(axis.y) * v.y + double(axis.z) * v.z;
    };
    const double scale = 0.5 * camera.height / double(camera.tan_half_height);
    double x0 = 1e30;
    double y0 = 1e30;
    double x1 = -1e30;
    double y1 = -1e30;
    int behind = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 index((corner & 1) != 0 ? high.x : low.x, (corner & 2) != 0 ? high.y : low.y,
                               (corner & 4) != 0 ? high.z : low.z);
        const glm::dvec3 v = transform.world_from_index(index) + cloud.offset_m - camera.position_m;
        const double depth = along(camera.forward, v);
        if (!(depth > 1e-3)) {
            ++behind;
            continue;
        }
        const double x = 0.5 * camera.width + along(camera.right, v) / depth * scale;
        const double y = 0.5 * camera.height - along(camera.up, v) / depth * scale;
        x0 = std::min(x0, x);
        x1 = std::max(x1, x);
        y0 = std::min(y0, y);
        y1 = std::max(y1, y);
    }
    if (behind == 8) {
        return {};
    }
    if (behind > 0) { // the box reaches past the eye's plane: where it ends on the screen is not said by its corners
        return all;
    }
    const auto clamped = [](double v, int a, int b) { return static_cast<int>(std::clamp(v, double(a), double(b))); };
    // A pixel more, for cameras whose forward axis is turned by a part of one.
    return {clamped(std::floor(x0) - 1.0, all.x0, all.x1), clamped(std::floor(y0) - 1.0, all.y0, all.y1),
            clamped(std::ceil(x1) + 1.0, all.x0, all.x1), clamped(std::ceil(y1) + 1.0, all.y0, all.y1)};
}

Picture march(std::span<const LitCloud> clouds, const Camera& camera, const MarchSettings& settings,
              std::span<const CloudLighting::ViewFields* const> fields) {
    assert(fields.empty() || fields.size() == clouds.size());
    Picture out(camera.width, camera.height);
    struct Seen {
        Picture picture;
        PixelRect rect;
    };
    std::vector<Seen> seen;
    for (std::size_t c = 0; c < clouds.size(); ++c) {
        MarchSettings one = settings;
        one.rect = bounds_on_screen(clouds[c], camera, settings.rect);
        if (one.rect.empty()) {
            continue;
        }
        one.fields = fields.empty() ? nullptr : fields[c];
        Camera moved = camera;
        moved.position_m -= clouds[c].offset_m;
        seen.push_back({march(*clouds[c].volume, *clouds[c].lighting, moved, one), one.rect});
    }
    if (seen.size() == 1) {
        return std::move(seen.front().picture);
    }
    struct Part {
        float depth;
        const Picture* picture;
    };
    std::vector<Part> parts;
    for (int y = 0; y < camera.height; ++y) {
        for (int x = 0; x < camera.width; ++x) {
            const std::size_t pixel = std::size_t(y) * std::size_t(camera.width) + std::size_t(x);
            parts.clear();
            for (const Seen& s : seen) {
                if (x >= s.rect.x0 && x < s.rect.x1 && y >= s.rect.y0 && y < s.rect.y1 &&
                    s.picture.depth_m[pixel] > 0.0F) {
                    parts.push_back({s.picture.depth_m[pixel], &s.picture});
                }
            }
            std::stable_sort(parts.begin(), parts.end(),
                             [](const Part& a, const Part& b) { return a.depth < b.depth; });
            float weight = 0.0F;
            float depth = 0.0F;
            for (const Part& part : parts) {
                float& through = out.transmittance[pixel];
                const float opacity = through * (1.0F - part.picture->transmittance[pixel]);
                out.radiance[pixel] += part.picture->radiance[pixel] * through;
                depth += opacity * part.depth;
                weight += opacity;
                through *= part.picture->transmittance[pixel];
            }
            out.depth_m[pixel] = weight > 0.0F ? depth / weight : 0.0F;
        }
    }
    return out;
}

} // namespace alpenglow::clouds
