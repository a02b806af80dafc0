#include "object_shadows.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include <algorithm>
#include <cmath>

namespace alpenglow::sandbox {
namespace {

constexpr float group_distance_m = 25.0F;
constexpr float lowest_light = 0.02F; // sine of the elevation below which the ground is lit too faintly to show shadows
constexpr float lift_m = 0.06F;

// Counter-clockwise convex hull of the first two coordinates (Andrew's monotone chain).
std::vector<glm::vec3> hull_2d(std::vector<glm::vec3> points) {
    std::sort(points.begin(), points.end(),
              [](glm::vec3 a, glm::vec3 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
    const auto turn = [](glm::vec3 o, glm::vec3 a, glm::vec3 b) {
        return (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
    };
    std::vector<glm::vec3> hull;
    for (int pass = 0; pass < 2; ++pass) {
        const std::size_t start = hull.size();
        for (const glm::vec3 p : points) {
            while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0.0F) {
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back(); // the other pass begins with it
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

} // namespace

float hidden_disc_fraction(float x) noexcept {
    if (x >= 1.0F) {
        return 0.0F;
    }
    if (x <= -1.0F) {
        return 1.0F;
    }
    const float chord = std::sqrt(1.0F - x * x);
    return (std::atan2(chord, x) - x * chord) * static_cast<float>(1.0 / pi);
}

ObjectShadows::ObjectShadows(const std::vector<ObjectMesh>& meshes, const std::vector<ObjectInstance>& objects)
    : meshes_(meshes), objects_(objects) {
    for (std::uint32_t k = 0; k < objects.size(); ++k) {
        if (meshes[objects[k].mesh].solids.empty()) {
            continue;
        }
        const glm::vec3 foot(objects[k].world_from_object[3]);
        auto near = std::find_if(groups_.begin(), groups_.end(), [&](const Group& group) {
            return glm::distance(glm::vec3(objects[group.objects.front()].world_from_object[3]), foot) <
                   group_distance_m;
        });
        if (near == groups_.end()) {
            groups_.emplace_back();
            near = groups_.end() - 1;
        }
        near->objects.push_back(k);
    }
    for (Group& group : groups_) {
        for (const std::uint32_t k : group.objects) {
            group.centre_m += glm::vec3(objects[k].world_from_object[3]) / static_cast<float>(group.objects.size());
        }
        for (const std::uint32_t k : group.objects) {
            const glm::vec3 foot(objects[k].world_from_object[3]);
            const float scale = glm::length(glm::vec3(objects[k].world_from_object[2]));
            const ObjectMesh& mesh = meshes[objects[k].mesh];
            group.radius_m =
                std::max(group.radius_m, glm::length(glm::vec2(foot - group.centre_m)) + scale * mesh.radius_m);
            group.height_m = std::max(group.height_m, foot.z - group.centre_m.z + scale * mesh.height_m);
        }
    }
}

ObjectShadows::LightFrame ObjectShadows::light_frame(glm::vec3 to_light) {
    const glm::vec3 level(-to_light.y, to_light.x, 0.0F);
    const glm::vec3 across = glm::length(level) > 1e-6F ? glm::normalize(level) : glm::vec3(1.0F, 0.0F, 0.0F);
    return {across, glm::cross(to_light, across), to_light};
}

std::vector<ObjectShadows::Outline> ObjectShadows::outlines(const Group& group, const LightFrame& frame) const {
    std::vector<Outline> all;
    for (const std::uint32_t k : group.objects) {
        for (const std::vector<glm::vec3>& solid : meshes_[objects_[k].mesh].solids) {
            std::vector<glm::vec3> seen;
            for (const glm::vec3 corner : solid) {
                const glm::vec3 p = glm::vec3(objects_[k].world_from_object * glm::vec4(corner, 1.0F)) - group.centre_m;
                seen.emplace_back(glm::dot(p, frame.across), glm::dot(p, frame.up), glm::dot(p, frame.along));
            }
            Outline outline;
            outline.corners = hull_2d(std::move(seen));
            if (outline.corners.size() < 3) {
                continue;
            }
            outline.low = outline.high = glm::vec2(outline.corners.front());
            for (std::size_t c = 0; c < outline.corners.size(); ++c) {
                const glm::vec3 p = outline.corners[c];
                const glm::vec3 q = outline.corners[(c + 1) % outline.corners.size()];
                outline.low = glm::min(outline.low, glm::vec2(p));
                outline.high = glm::max(outline.high, glm::vec2(p));
                outline.area_m2 += 0.5F * (p.x * q.y - p.y * q.x);
            }
            all.push_back(std::move(outline));
        }
    }
    return all;
}

float ObjectShadows::shade(const std::vector<Outline>& outlines, glm::vec3 seen, float tangent, float blur_m) {
    float lit = 1.0F;
    for (const Outline& outline : outlines) {
        // Beyond the penumbra of the farthest corner there is nothing to find.
        const float reach = blur_m + tangent * std::max(0.0F, outline.corners.front().z + 60.0F - seen.z);
        if (seen.x < outline.low.x - reach || seen.x > outline.high.x + reach || seen.y < outline.low.y - reach ||
            seen.y > outline.high.y + reach) {
            continue;
        }
        // Signed distance to the outline, and how far along the light its nearest point stands.
        float nearest = -1e30F;
        float outside = 1e30F;
        float along = 0.0F;
        float along_outside = 0.0F;
        bool inside = true;
        for (std::size_t c = 0; c < outline.corners.size(); ++c) {
            const glm::vec3 p = outline.corners[c];
            const glm::vec3 q = outline.corners[(c + 1) % outline.corners.size()];
            const glm::vec2 edge(q - p);
            const float length = glm::length(edge);
            if (length < 1e-6F) {
                continue;
            }
            const glm::vec2 to_point = glm::vec2(seen) - glm::vec2(p);
            const float d = (edge.y * to_point.x - edge.x * to_point.y) / length;
            const float t = std::clamp(glm::dot(edge, to_point) / (length * length), 0.0F, 1.0F);
            const float z = p.z + t * (q.z - p.z);
            if (d > nearest) {
                nearest = d;
                along = z;
            }
            if (d > 0.0F) {
                inside = false;
            }
            const float corner_distance = glm::length(to_point - t * edge);
            if (corner_distance < outside) {
                outside = corner_distance;
                along_outside = z;
            }
        }
        const float distance = inside ? nearest : outside;
        const float gap_m = (inside ? along : along_outside) - seen.z;
        if (gap_m <= 0.0F) {
            continue; // the object stands behind the point
        }
        const float penumbra_m = tangent * gap_m;
        float hidden = hidden_disc_fraction(distance / std::max(std::hypot(penumbra_m, blur_m), 1e-4F));
        // An object smaller than the light's disc hides no more than its share.
        hidden *= std::min(1.0F, outline.area_m2 / std::max(1e-6F, static_cast<float>(pi) * penumbra_m * penumbra_m));
        lit = std::min(lit, 1.0F - hidden);
    }
    return 1.0F - lit;
}

float ObjectShadows::shade(glm::vec3 position_m, const ShadowInput& input) const {
    const LightFrame frame = light_frame(input.to_light);
    const float tangent = std::tan(input.angular_radius_rad);
    float lit = 1.0F;
    for (const Group& group : groups_) {
        const glm::vec3 p = position_m - group.centre_m;
        const glm::vec3 seen(glm::dot(p, frame.across), glm::dot(p, frame.up), glm::dot(p, frame.along));
        lit *= 1.0F - shade(outlines(group, frame), seen, tangent, 0.0F);
    }
    return 1.0F - lit;
}

void ObjectShadows::build(const ShadowInput& input, const TerrainLod& lod, const ShadowSettings& settings) {
    vertices_.clear();
    indices_.clear();
    grids_ = 0;
    if (input.to_light.z < lowest_light) {
        return;
    }
    const LightFrame frame = light_frame(input.to_light);
    const float level = std::sqrt(std::max(0.0F, 1.0F - input.to_light.z * input.to_light.z));
    const glm::vec2 away = level > 1e-5F ? -glm::vec2(input.to_light) / level : glm::vec2(0.0F, 1.0F);
    const glm::vec2 side(-away.y, away.x);
    const float tangent = std::tan(input.angular_radius_rad);
    std::vector<std::int64_t> vertex_at;
    for (const Group& group : groups_) {
        const float distance = glm::distance(group.centre_m, input.camera_m);
        if (distance > settings.reach_m) {
            continue;
        }
        const std::vector<Outline> casters = outlines(group, frame);
        // Longer where the ground falls away behind the object.
        const float length = std::min(1.5F * group.height_m * level / input.to_light.z, settings.max_length_m);
        const float margin = 1.0F;
        const float u0 = -group.radius_m - margin;
        const float u1 = group.radius_m + margin + length;
        const float half = group.radius_m + margin;
        const float cell = std::max({settings.cell_m, distance / 350.0F, std::sqrt((u1 - u0) * half * 2.0F / 1200.0F)});
        const int columns = static_cast<int>(std::ceil((u1 - u0) / cell));
        const int rows = static_cast<int>(std::ceil(2.0F * half / cell));
        const auto width = static_cast<std::size_t>(columns + 1);
        const std::array<std::uint32_t, 4>& horizon = objects_[group.objects.front()].horizon;
        std::vector<ShadowVertex> grid;
        grid.reserve(width * static_cast<std::size_t>(rows + 1));
        for (int r = 0; r <= rows; ++r) {
            for (int c = 0; c <= columns; ++c) {
                const glm::vec2 p = glm::vec2(group.centre_m) + (u0 + cell * static_cast<float>(c)) * away +
                                    (cell * static_cast<float>(r) - half) * side;
                const glm::vec3 ground(p, lod.surface_height_m(p) + lift_m);
                const glm::vec3 q = ground - group.centre_m;
                const glm::vec3 seen(glm::dot(q, frame.across), glm::dot(q, frame.up), glm::dot(q, frame.along));
                grid.push_back({ground, shade(casters, seen, tangent, 0.6F * cell), horizon});
            }
        }
        // Cells without shade are left out.
        vertex_at.assign(grid.size(), -1);
        const auto use = [&](std::size_t k) {
            if (vertex_at[k] < 0) {
                vertex_at[k] = static_cast<std::int64_t>(vertices_.size());
                vertices_.push_back(grid[k]);
            }
            return static_cast<std::uint32_t>(vertex_at[k]);
        };
        for (std::size_t r = 0; r < static_cast<std::size_t>(rows); ++r) {
            for (std::size_t c = 0; c < static_cast<std::size_t>(columns); ++c) {
                const std::size_t k = r * width + c;
                if (std::max({grid[k].shade, grid[k + 1].shade, grid[k + width].shade, grid[k + width + 1].shade}) <
                    0.004F) {
                    continue;
                }
                const std::uint32_t a = use(k);
                const std::uint32_t b = use(k + 1);
                const std::uint32_t d = use(k + width);
                const std::uint32_t e = use(k + width + 1);
                indices_.insert(indices_.end(), {a, b, e, a, e, d});
            }
        }
        ++grids_;
    }
}

SystemReport ObjectShadows::update(const ShadowInput& input, const TerrainLod& lod, const ShadowSettings& settings) {
    const double start = thread_cpu_seconds();
    SystemReport report;
    report.system = "object_shadows";
    report.considered = static_cast<std::uint32_t>(groups_.size());
    const glm::vec3 was = built_for_.to_light;
    const float moved = std::atan2(glm::length(glm::cross(input.to_light, was)), glm::dot(input.to_light, was));
    const bool rebuild = !built_ || moved > settings.light_move_rad ||
                         glm::distance(input.camera_m, built_for_.camera_m) > settings.camera_move_m;
    if (rebuild) {
        build(input, lod, settings);
        built_ = true;
        built_for_ = input;
    } else if (lod.revision() != lod_revision_) {
        for (ShadowVertex& v : vertices_) {
            v.position_m.z = lod.surface_height_m(glm::vec2(v.position_m)) + lift_m;
        }
    }
    if (rebuild || lod.revision() != lod_revision_) {
        ++revision_;
        report.updated = grids_;
    }
    lod_revision_ = lod.revision();
    report.skipped = report.considered - report.updated;
    report.error_bound = rebuild ? 0.0 : static_cast<double>(moved);
    report.cpu_ms = 1e3 * (thread_cpu_seconds() - start);
    return report;
}

} // namespace alpenglow::sandbox
