#include "terrain_lod.hpp"

#include "vertex.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>
#include <alpenglow/core/timing.hpp>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cassert>
#include <cmath>

namespace alpenglow::sandbox {
namespace {

// Both grids in virtual coordinates of 16 m: the outer one spans 0 .. side, the inner one low .. high.
constexpr int side = (Terrain::samples - 1) * Terrain::ratio;
constexpr int low = side / 2 - (Terrain::samples - 1) / 2;
constexpr int high = side / 2 + (Terrain::samples - 1) / 2;
constexpr std::size_t grid_count = static_cast<std::size_t>(Terrain::samples) * Terrain::samples;

constexpr std::array<glm::ivec2, 4> square_corners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
constexpr std::array<glm::ivec2, 4> cross_corners{{{-1, 0}, {0, -1}, {1, 0}, {0, 1}}};

bool in_square(glm::ivec2 p) {
    return p.x >= 0 && p.y >= 0 && p.x <= side && p.y <= side;
}

// The split vertices of one level: middles of cells of side 2 g (both coordinates odd multiples of g), or middles of
// the sides of those cells (one odd, one even).
struct Level {
    int g;
    bool middles;

    // The long edge's ends are the corners with even index in the returned order, the right angles (the parents) those
    // with odd index.
    [[nodiscard]] std::array<glm::ivec2, 4> corners(glm::ivec2 v) const {
        std::array<glm::ivec2, 4> c;
        int first = 0;
        if (middles) {
            // The diagonal that is cut joins corners whose coordinates, in cells, have an even sum.
            const glm::ivec2 corner = v - glm::ivec2(g);
            first = ((corner.x + corner.y) / (2 * g)) % 2;
        } else {
            first = (v.x / g) % 2 != 0 ? 0 : 1;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t turned = (k + static_cast<std::size_t>(first)) % 4;
            c[k] = v + g * (middles ? square_corners[turned] : cross_corners[turned]);
        }
        return c;
    }
    [[nodiscard]] std::array<glm::ivec2, 4> children(glm::ivec2 v) const {
        std::array<glm::ivec2, 4> c;
        for (std::size_t k = 0; k < 4; ++k) {
            c[k] = v + (middles ? g * cross_corners[k] : (g / 2) * square_corners[k]);
        }
        return c;
    }
    // Calls visit(v) for every vertex of the level that has a sample, rows in parallel.
    template <class Visit>
    void for_each(const Visit& visit) const {
        const bool fine = g < Terrain::ratio; // odd multiples of g are no outer samples
        const int from = fine ? low : 0;
        const int to = fine ? high : side;
        const int row_step = middles ? 2 * g : g;
        const int row_first = middles ? from + g : from;
        const int rows = (to - row_first) / row_step + 1;
        parallel_for(static_cast<std::size_t>(rows), 16, [&](std::size_t begin, std::size_t end) {
            for (std::size_t r = begin; r < end; ++r) {
                const int y = row_first + static_cast<int>(r) * row_step;
                const bool odd_row = (y / g) % 2 != 0;
                for (int x = middles || !odd_row ? from + g : from; x <= to; x += 2 * g) {
                    visit(glm::ivec2(x, y));
                }
            }
        });
    }
};

// How much a vertex looks unlike the mean of two others, as a fraction of the length of the edge between them that is
// as disturbing as an error in shape. Normals and the albedo's luminance are drawn from an image of the finest grid:
// hue counts, the rest little.
float contrast(const Vertex& v, const Vertex& a, const Vertex& b) {
    const glm::vec3 normal = unpack_normal(v.normal) - 0.5F * (unpack_normal(a.normal) + unpack_normal(b.normal));
    const glm::vec3 albedo = unpack_albedo(v.albedo) - 0.5F * (unpack_albedo(a.albedo) + unpack_albedo(b.albedo));
    const glm::vec3 hue = albedo - glm::dot(albedo, glm::vec3(0.2126F, 0.7152F, 0.0722F));
    return 0.22F * std::min(0.7F, 0.2F * glm::length(normal) + 2.0F * glm::length(hue));
}

std::vector<Level> levels_coarse_to_fine() {
    std::vector<Level> levels;
    for (int g = side / 2; g >= 1; g /= 2) {
        levels.push_back({g, true});
        levels.push_back({g, false});
    }
    return levels;
}

struct Plane {
    glm::vec3 normal; // towards the inside
    float offset;
};

// Sides, top, bottom and near plane of a Vulkan clip space; the terrain ends before any far plane.
std::array<Plane, 5> frustum_planes(const glm::mat4& m) {
    const auto row = [&](int r) { return glm::vec4(m[0][r], m[1][r], m[2][r], m[3][r]); };
    const std::array<glm::vec4, 5> raw{row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(2)};
    std::array<Plane, 5> planes{};
    for (std::size_t k = 0; k < planes.size(); ++k) {
        const float length = glm::length(glm::vec3(raw[k]));
        // A projection with reversed or infinite depth may have no near plane here: keep everything.
        planes[k] =
            length > 1e-12F ? Plane{glm::vec3(raw[k]) / length, raw[k].w / length} : Plane{glm::vec3(0.0F), 1.0F};
    }
    return planes;
}

// How far up the ground drawn so far hides what lies behind it, by azimuth: a horizon that grows from near to far.
class Occlusion {
public:
    Occlusion(glm::vec3 eye_m, float slack_m) : eye_m_(eye_m), slack_m_(slack_m) { tangent_.fill(-1e30F); }

    // Is all of a ball behind ground nearer than it?
    [[nodiscard]] bool hides(glm::vec3 centre, float radius) const {
        const glm::vec3 d = centre - eye_m_;
        const float r = radius + slack_m_;
        const float distance = std::sqrt(d.x * d.x + d.y * d.y);
        if (distance < 2.0F * r) {
            return false;
        }
        const float top = d.z + r;
        const float tangent = top / (top > 0.0F ? distance - r : distance + r);
        const float half = 1.05F * r / distance * bins_per_radian; // asin(x) < 1.05 x for x < 1/2
        const float middle = bin_of(d);
        if (tangent_[wrapped(static_cast<int>(middle))] < tangent) {
            return false;
        }
        const int first = static_cast<int>(std::floor(middle - half));
        const int last = static_cast<int>(std::floor(middle + half));
        for (int b = first; b <= last; ++b) {
            if (tangent_[wrapped(b)] < tangent) {
                return false;
            }
        }
        return true;
    }

    // Raises the horizon by a triangle's edges: in each bin that one spans, to its lower end there.
    void add_triangle(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
        const std::array<glm::vec3, 3> p{a - eye_m_, b - eye_m_, c - eye_m_};
        const std::array<float, 3> bin{bin_of(p[0]), bin_of(p[1]), bin_of(p[2])};
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t next = (k + 1) % 3;
            add_edge(p[k], bin[k], p[next], bin[next]);
        }
    }

private:
    static constexpr int bins = 2048;
    static constexpr float bins_per_radian = static_cast<float>(bins / two_pi);

    // Direction of each border between bins.
    struct Borders {
        std::array<glm::vec2, bins> direction;
        Borders() {
            for (int k = 0; k < bins; ++k) {
                const double angle = (k - bins / 2) / (bins / two_pi);
                direction[static_cast<std::size_t>(k)] = glm::vec2(std::cos(angle), std::sin(angle));
            }
        }
    };

    static std::size_t wrapped(int bin) { return static_cast<std::size_t>(bin & (bins - 1)); }
    static float bin_of(glm::vec3 d) { return std::atan2(d.y, d.x) * bins_per_radian + 0.5F * bins; }

    void add_edge(glm::vec3 p, float begin, glm::vec3 q, float end) {
        if (std::abs(end - begin) > 0.5F * bins) {
            (end > begin ? begin : end) += bins;
        }
        const int first = static_cast<int>(std::ceil(std::min(begin, end)));
        const int last = static_cast<int>(std::floor(std::max(begin, end))); // whole bins are first .. last - 1
        if (first >= last) {
            return;
        }
        float before = tangent_at(p, q, first);
        for (int b = first; b < last; ++b) {
            const float after = tangent_at(p, q, b + 1);
            float& bin = tangent_[wrapped(b)];
            bin = std::max(bin, std::min(before, after));
            before = after;
        }
    }

    // Tangent of elevation where the vertical plane at the border of a bin cuts the edge.
    [[nodiscard]] float tangent_at(glm::vec3 p, glm::vec3 q, int border) const {
        static const Borders borders;
        const glm::vec2 d = borders.direction[wrapped(border)];
        const float side_p = p.y * d.x - p.x * d.y;
        const float side_q = q.y * d.x - q.x * d.y;
        const float t = side_p == side_q ? 0.0F : std::clamp(side_p / (side_p - side_q), 0.0F, 1.0F);
        const glm::vec3 cut = p + t * (q - p);
        const float per_distance = 1.0F / std::max(cut.x * d.x + cut.y * d.y, 1.0F);
        return (cut.z - slack_m_ - slack_m_ * std::abs(cut.z) * per_distance) * per_distance;
    }

    glm::vec3 eye_m_;
    float slack_m_; // the eye may be off by so much
    std::array<float, bins> tangent_{};
};

glm::vec3 view_direction(const glm::mat4& clip_from_world) {
    // The fourth row is the distance along the view axis.
    return glm::normalize(glm::vec3(clip_from_world[0][3], clip_from_world[1][3], clip_from_world[2][3]));
}

} // namespace

TerrainLod::TerrainLod(const Terrain& terrain, std::span<const Vertex> vertices) : terrain_(terrain) {
    assert(terrain.inner.n == Terrain::samples && terrain.outer.n == Terrain::samples);
    assert(vertices.empty() || vertices.size() == 2 * grid_count);
    bounds_.error_m.assign(2 * grid_count, UpperBound(-1.0F));
    bounds_.radius_m.assign(2 * grid_count, UpperBound());
    bound_errors(vertices);
}

TerrainLod::TerrainLod(const Terrain& terrain, LodBounds bounds) : terrain_(terrain), bounds_(std::move(bounds)) {
    assert(bounds_.error_m.size() == 2 * grid_count && bounds_.radius_m.size() == 2 * grid_count);
}

std::int64_t TerrainLod::vertex_of(glm::ivec2 p) const {
    if (p.x % Terrain::ratio == 0 && p.y % Terrain::ratio == 0) {
        return static_cast<std::int64_t>(terrain_.outer.index(p.x / Terrain::ratio, p.y / Terrain::ratio));
    }
    if (p.x >= low && p.y >= low && p.x <= high && p.y <= high) {
        return static_cast<std::int64_t>(grid_count + terrain_.inner.index(p.x - low, p.y - low));
    }
    return -1;
}

glm::vec3 TerrainLod::position_m(std::uint32_t vertex) const {
    const bool inner = vertex >= grid_count;
    const HeightGrid& grid = inner ? terrain_.inner : terrain_.outer;
    const auto k = static_cast<int>(inner ? vertex - grid_count : vertex);
    const glm::vec2 p = grid.position_m(k % Terrain::samples, k / Terrain::samples);
    return {p, grid.height_m[static_cast<std::size_t>(k)]};
}

void TerrainLod::bound_errors(std::span<const Vertex> vertices) {
    std::vector<float> look_m(vertices.empty() ? 0 : bounds_.error_m.size(),
                              0.0F); // what the eye misses besides shape, nested
    std::vector<float> shape_m(bounds_.error_m.size(), 0.0F);
    const std::vector<Level> levels = levels_coarse_to_fine();
    // Which vertices may ever be split: those whose parents may. Error 0 marks them for now.
    for (const Level& level : levels) {
        level.for_each([&](glm::ivec2 v) {
            const std::int64_t at = vertex_of(v);
            if (at < 0) {
                return;
            }
            const auto corners = level.corners(v);
            for (const glm::ivec2 parent : {corners[1], corners[3]}) {
                if (!in_square(parent) || level.g == side / 2) {
                    continue;
                }
                const std::int64_t p = vertex_of(parent);
                if (p < 0 || bounds_.error_m[static_cast<std::size_t>(p)].value() < 0.0F) {
                    return;
                }
            }
            bounds_.error_m[static_cast<std::size_t>(at)] = UpperBound(0.0F);
        });
    }
    for (std::size_t l = levels.size(); l-- > 0;) {
        const Level& level = levels[l];
        level.for_each([&](glm::ivec2 v) {
            const std::int64_t signed_at = vertex_of(v);
            if (signed_at < 0 || bounds_.error_m[static_cast<std::size_t>(signed_at)].value() < 0.0F) {
                return;
            }
            const auto at = static_cast<std::uint32_t>(signed_at);
            const glm::vec3 position = position_m(at);
            const auto corners = level.corners(v);
            float radius = 0.0F;
            for (const glm::ivec2 corner : corners) {
                if (in_square(corner)) {
                    const glm::vec3 c = position_m(static_cast<std::uint32_t>(vertex_of(corner)));
                    radius = std::max(radius, glm::distance(position, c));
                }
            }
            const glm::vec3 a = position_m(static_cast<std::uint32_t>(vertex_of(corners[0])));
            const glm::vec3 b = position_m(static_cast<std::uint32_t>(vertex_of(corners[2])));
            const float own = std::abs(position.z - 0.5F * (a.z + b.z));
            float look = 0.0F;
            if (!vertices.empty()) {
                look = contrast(vertices[at], vertices[static_cast<std::size_t>(vertex_of(corners[0]))],
                                vertices[static_cast<std::size_t>(vertex_of(corners[2]))]) *
                       glm::distance(a, b);
            }
            float below = 0.0F;
            for (const glm::ivec2 child : level.children(v)) {
                if (!in_square(child) || (level.g == 1 && !level.middles)) {
                    continue;
                }
                const std::int64_t c = vertex_of(child);
                if (c >= 0 && bounds_.error_m[static_cast<std::size_t>(c)].value() >= 0.0F) {
                    const auto k = static_cast<std::uint32_t>(c);
                    below = std::max(below, shape_m[k]);
                    look = vertices.empty() ? 0.0F : std::max(look, look_m[k]);
                    radius = std::max(radius, glm::distance(position, position_m(k)) + bounds_.radius_m[k].value());
                }
            }
            shape_m[at] = own + below;
            bounds_.error_m[at] = UpperBound(shape_m[at]);
            if (!vertices.empty()) {
                look_m[at] = look;
                bounds_.error_m[at] = UpperBound(std::max(shape_m[at], look));
            }
            bounds_.radius_m[at] =
                UpperBound(1.0001F * radius + 0.05F); // above what rounding could take from the nesting
        });
    }
}

bool TerrainLod::active(std::uint32_t v, float distance_m, const Threshold& t) const {
    const float e = bounds_.error_m[v].value();
    if (!(e > 0.0F)) {
        return false;
    }
    const float clear_m = distance_m - bounds_.radius_m[v].value();
    // Grows with distance, so that parents stay active; past the first test the exponential is rarely needed.
    return e > t.ratio * clear_m && (clear_m <= 0.0F || e > t.ratio * clear_m * std::exp(clear_m * t.per_haze));
}

TerrainLod::Corner TerrainLod::corner(glm::ivec2 at) const {
    const std::int64_t vertex = vertex_of(at);
    assert(vertex >= 0);
    const auto v = static_cast<std::uint32_t>(vertex);
    const float height = v < grid_count ? terrain_.outer.height_m[v] : terrain_.inner.height_m[v - grid_count];
    const glm::vec2 p = terrain_.outer.origin_m + Terrain::inner_spacing_m * glm::vec2(at);
    return {at, v, glm::vec3(p, height)};
}

std::array<TerrainLod::Triangle, 2> TerrainLod::roots() const {
    const Corner south_west = corner({0, 0});
    const Corner north_east = corner({side, side});
    return {Triangle{south_west, north_east, corner({0, side})}, Triangle{north_east, south_west, corner({side, 0})}};
}

std::int64_t TerrainLod::split_vertex(const Triangle& triangle) const {
    const glm::ivec2 sum = triangle.a.at + triangle.b.at;
    const std::int64_t v = sum.x % 2 == 0 && sum.y % 2 == 0 ? vertex_of(sum / 2) : -1;
    return v >= 0 && bounds_.error_m[static_cast<std::size_t>(v)].value() >= 0.0F ? v : -1;
}

bool TerrainLod::build(const LodView& view, const LodSettings& settings, float threshold_px) {
    const Threshold t{view.camera_m, threshold_px / view.pixels_per_radian, 1.0F / settings.haze_m};
    const std::array<Plane, 5> planes = frustum_planes(view.clip_from_world);
    const float turn = std::sin(settings.turn_rad);
    const std::size_t limit = 3U * static_cast<std::size_t>(settings.max_triangles);
    indices_.clear();

    struct Entry {
        Triangle triangle;
        std::uint32_t planes; // bit k: not yet known to be inside plane k
    };
    std::vector<Entry> stack;
    const glm::vec2 eye(view.camera_m);
    const auto push_near_last = [&](const Triangle& first, const Triangle& second, glm::vec2 cut, glm::vec2 from,
                                    std::uint32_t left) {
        // `first` lies to the left of `cut`; the half on the camera's side comes off the stack first, so that near
        // ground hides far ground.
        const glm::vec2 to_eye = eye - from;
        const bool left_first = cut.x * to_eye.y - cut.y * to_eye.x > 0.0F;
        stack.push_back({left_first ? second : first, left});
        stack.push_back({left_first ? first : second, left});
    };
    const std::array<Triangle, 2> whole = roots();
    push_near_last(whole[0], whole[1], glm::vec2(1.0F), terrain_.outer.origin_m, 31U);
    Occlusion occlusion(view.camera_m, settings.move_m);
    while (!stack.empty()) {
        Entry entry = stack.back();
        stack.pop_back();
        const Triangle& triangle = entry.triangle;
        const std::int64_t split = split_vertex(triangle);
        if (split >= 0) {
            const Corner middle = corner((triangle.a.at + triangle.b.at) / 2);
            const float radius = bounds_.radius_m[middle.vertex].value();
            const float distance = glm::distance(middle.position_m, view.camera_m);
            const float margin = turn * distance + settings.move_m;
            bool outside = false;
            for (std::uint32_t k = 0; k < planes.size() && entry.planes != 0; ++k) {
                if ((entry.planes >> k & 1U) != 0) {
                    const float inside = glm::dot(planes[k].normal, middle.position_m) + planes[k].offset;
                    outside = outside || inside < -(radius + margin);
                    if (inside > radius * (1.0F + turn)) {
                        entry.planes &= ~(1U << k);
                    }
                }
            }
            if (outside || occlusion.hides(middle.position_m, radius)) {
                continue;
            }
            if (active(middle.vertex, distance, t)) {
                push_near_last({triangle.c, triangle.a, middle}, {triangle.b, triangle.c, middle},
                               glm::vec2(triangle.c.position_m - middle.position_m), glm::vec2(middle.position_m),
                               entry.planes);
                continue;
            }
        }
        if (indices_.size() + 3 > limit) {
            return false;
        }
        indices_.insert(indices_.end(), {triangle.a.vertex, triangle.b.vertex, triangle.c.vertex});
        occlusion.add_triangle(triangle.a.position_m, triangle.b.position_m, triangle.c.position_m);
    }
    threshold_ = t;
    error_px_ = threshold_px;
    built_for_ = view;
    return true;
}

SystemReport TerrainLod::update(const LodView& view, const LodSettings& settings) {
    const double start = thread_cpu_seconds();
    SystemReport report;
    report.system = "terrain_lod";
    report.considered = 1;
    bool keep = error_px_ > 0.0F && view.pixels_per_radian == built_for_.pixels_per_radian;
    if (keep) {
        const float moved = glm::distance(view.camera_m, built_for_.camera_m);
        const glm::vec3 now = view_direction(view.clip_from_world);
        const glm::vec3 then = view_direction(built_for_.clip_from_world);
        const float turned = std::atan2(glm::length(glm::cross(now, then)), glm::dot(now, then));
        keep = moved <= settings.move_m && turned <= settings.turn_rad;
    }
    if (keep) {
        report.skipped = 1;
    } else {
        // Starts from the last threshold, so that the choice does not flutter, and ends near the finest that fits or at
        // the target. Triangles grow about as the inverse of the threshold.
        float threshold = std::max(settings.target_error_px, error_px_ > 0.0F ? error_px_ : 3.0F);
        bool fits = build(view, settings, threshold);
        float too_fine = 0.0F;
        while (!fits) {
            too_fine = threshold;
            threshold *= 1.25F;
            fits = build(view, settings, threshold);
        }
        const float limit = 3.0F * static_cast<float>(settings.max_triangles);
        for (int attempt = 0; attempt < 8 && threshold > settings.target_error_px; ++attempt) {
            const float fill = std::max(0.3F, static_cast<float>(indices_.size()) / limit);
            const float finer = std::max({settings.target_error_px, threshold * fill / 0.95F, 1.04F * too_fine});
            if (fill > 0.85F || finer > 0.97F * threshold) {
                break;
            }
            if (!build(view, settings, finer)) {
                too_fine = finer;
                (void)build(view, settings, threshold);
            } else {
                threshold = finer;
            }
        }
        ++revision_;
        report.updated = 1;
    }
    report.error_bound = error_px_;
    report.cpu_ms = 1e3 * (thread_cpu_seconds() - start);
    return report;
}

std::vector<std::uint32_t> TerrainLod::coarse_indices(float error_m) const {
    std::vector<std::uint32_t> indices;
    const std::array<Triangle, 2> whole = roots();
    std::vector<Triangle> stack(whole.begin(), whole.end());
    while (!stack.empty()) {
        const Triangle triangle = stack.back();
        stack.pop_back();
        const std::int64_t split = split_vertex(triangle);
        if (split >= 0 && bounds_.error_m[static_cast<std::size_t>(split)].value() > error_m) {
            const Corner middle = corner((triangle.a.at + triangle.b.at) / 2);
            stack.push_back({triangle.c, triangle.a, middle});
            stack.push_back({triangle.b, triangle.c, middle});
            continue;
        }
        indices.insert(indices.end(), {triangle.a.vertex, triangle.b.vertex, triangle.c.vertex});
    }
    return indices;
}

float TerrainLod::surface_height_m(glm::vec2 position) const {
    const float half = 0.5F * terrain_.outer.extent_m();
    const glm::vec2 p = glm::clamp(position, glm::vec2(-half), glm::vec2(half));
    const auto cross = [](glm::vec2 u, glm::vec2 w) { return u.x * w.y - u.y * w.x; };
    Triangle triangle = roots()[p.y > p.x ? 0 : 1];
    for (;;) {
        if (split_vertex(triangle) < 0) {
            break;
        }
        const Corner middle = corner((triangle.a.at + triangle.b.at) / 2);
        if (!active(middle.vertex, glm::distance(middle.position_m, threshold_.camera_m), threshold_)) {
            break;
        }
        // The half with `a` lies to the left of the line from the middle to `c`.
        const glm::vec2 cut(triangle.c.position_m - middle.position_m);
        const bool left = cross(cut, p - glm::vec2(middle.position_m)) > 0.0F;
        triangle = left ? Triangle{triangle.c, triangle.a, middle} : Triangle{triangle.b, triangle.c, middle};
    }
    const glm::vec2 a(triangle.a.position_m);
    const glm::vec2 ab = glm::vec2(triangle.b.position_m) - a;
    const glm::vec2 ac = glm::vec2(triangle.c.position_m) - a;
    const float area = cross(ab, ac);
    const float u = cross(p - a, ac) / area;
    const float w = cross(ab, p - a) / area;
    const float h = triangle.a.position_m.z;
    return h + u * (triangle.b.position_m.z - h) + w * (triangle.c.position_m.z - h);
}

} // namespace alpenglow::sandbox
