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
// as disturbing as an error in shape.
float contrast(const Vertex& v, const Vertex& a, const Vertex& b) {
    const glm::vec3 normal = unpack_normal(v.normal) - 0.5F * (unpack_normal(a.normal) + unpack_normal(b.normal));
    const glm::vec3 albedo = unpack_albedo(v.albedo) - 0.5F * (unpack_albedo(a.albedo) + unpack_albedo(b.albedo));
    return 0.22F * std::min(0.7F, 0.5F * glm::length(normal) + glm::length(albedo));
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
        const float distance = std::hypot(d.x, d.y);
        if (distance < 2.0F * r) {
            return false;
        }
        const float top = d.z + r;
        const float tangent = top / (top > 0.0F ? distance - r : distance + r);
        const float half = 1.05F * r / distance; // asin(x) < 1.05 x for x < 1/2
        const float middle = bin_of(d);
        const int first = static_cast<int>(std::floor(middle - half * bins_per_radian));
        const int last = static_cast<int>(std::floor(middle + half * bins_per_radian));
        for (int b = first; b <= last; ++b) {
            if (tangent_[static_cast<std::size_t>(b & (bins - 1))] < tangent) {
                return false;
            }
        }
        return true;
    }

    // Raises the horizon by an edge: in each bin that it spans, to its lower end there.
    void add_edge(glm::vec3 from, glm::vec3 to) {
        const glm::vec3 p = from - eye_m_;
        const glm::vec3 q = to - eye_m_;
        float begin = bin_of(p);
        float end = bin_of(q);
        if (std::abs(end - begin) > 0.5F * bins) {
            (end > begin ? begin : end) += bins;
        }
        const bool turned = begin > end;
        const int first = static_cast<int>(std::ceil(turned ? end : begin));
        const int last = static_cast<int>(std::floor(turned ? begin : end)); // whole bins are first .. last - 1
        if (first >= last) {
            return;
        }
        float before = tangent_at(p, q, first);
        for (int b = first; b < last; ++b) {
            const float after = tangent_at(p, q, b + 1);
            float& bin = tangent_[static_cast<std::size_t>(b & (bins - 1))];
            bin = std::max(bin, std::min(before, after));
            before = after;
        }
    }

private:
    static constexpr int bins = 4096;
    static constexpr float bins_per_radian = static_cast<float>(bins / two_pi);

    static float bin_of(glm::vec3 d) { return std::atan2(d.y, d.x) * bins_per_radian + 0.5F * bins; }

    // Tangent of elevation where the vertical plane at the border of a bin cuts the edge.
    [[nodiscard]] float tangent_at(glm::vec3 p, glm::vec3 q, int border) const {
        const float angle = (static_cast<float>(border) - 0.5F * bins) / bins_per_radian;
        const float c = std::cos(angle);
        const float s = std::sin(angle);
        const float side_p = p.y * c - p.x * s;
        const float side_q = q.y * c - q.x * s;
        const float t = side_p == side_q ? 0.0F : std::clamp(side_p / (side_p - side_q), 0.0F, 1.0F);
        const glm::vec3 cut = p + t * (q - p);
        const float distance = std::max(std::hypot(cut.x, cut.y), 1.0F);
        return (cut.z - slack_m_) / distance - slack_m_ * std::abs(cut.z) / (distance * distance);
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
    error_m_.assign(2 * grid_count, -1.0F);
    radius_m_.assign(2 * grid_count, 0.0F);
    bound_errors(vertices);
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
    std::vector<float> look_m(vertices.empty() ? 0 : error_m_.size(),
                              0.0F); // what the eye misses besides shape, nested
    std::vector<float> shape_m(error_m_.size(), 0.0F);
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
                if (p < 0 || error_m_[static_cast<std::size_t>(p)] < 0.0F) {
                    return;
                }
            }
            error_m_[static_cast<std::size_t>(at)] = 0.0F;
        });
    }
    for (std::size_t l = levels.size(); l-- > 0;) {
        const Level& level = levels[l];
        level.for_each([&](glm::ivec2 v) {
            const std::int64_t signed_at = vertex_of(v);
            if (signed_at < 0 || error_m_[static_cast<std::size_t>(signed_at)] < 0.0F) {
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
                if (c >= 0 && error_m_[static_cast<std::size_t>(c)] >= 0.0F) {
                    const auto k = static_cast<std::uint32_t>(c);
                    below = std::max(below, shape_m[k]);
                    look = vertices.empty() ? 0.0F : std::max(look, look_m[k]);
                    radius = std::max(radius, glm::distance(position, position_m(k)) + radius_m_[k]);
                }
            }
            shape_m[at] = own + below;
            error_m_[at] = shape_m[at];
            if (!vertices.empty()) {
                look_m[at] = look;
                error_m_[at] = std::max(shape_m[at], look);
            }
            radius_m_[at] = 1.0001F * radius + 0.05F; // above what rounding could take from the nesting
        });
    }
}

bool TerrainLod::active(std::uint32_t v, const Threshold& t) const {
    const float e = error_m_[v];
    if (!(e > 0.0F)) {
        return false;
    }
    const float distance = glm::distance(position_m(v), t.camera_m) - radius_m_[v];
    // Grows with distance, so that parents stay active; past the first test the exponential is rarely needed.
    return e > t.ratio * distance && (distance <= 0.0F || e > t.ratio * distance * std::exp(distance * t.per_haze));
}

bool TerrainLod::build(const LodView& view, const LodSettings& settings, float threshold_px) {
    const Threshold t{view.camera_m, threshold_px / view.pixels_per_radian, 1.0F / settings.haze_m};
    const std::array<Plane, 5> planes = frustum_planes(view.clip_from_world);
    const float turn = std::sin(settings.turn_rad);
    const float shift = settings.move_m;
    const std::size_t limit = 3U * static_cast<std::size_t>(settings.max_triangles);
    indices_.clear();

    struct Entry {
        Triangle triangle;
        std::uint32_t planes; // bit k: not yet known to be inside plane k
    };
    std::vector<Entry> stack;
    constexpr std::uint32_t all = 31;
    Entry north{{{0, 0}, {side, side}, {0, side}}, all};
    Entry south{{{side, side}, {0, 0}, {side, 0}}, all};
    const glm::vec2 camera = (glm::vec2(view.camera_m) - terrain_.outer.origin_m) / Terrain::inner_spacing_m;
    if (camera.y > camera.x) {
        std::swap(north, south);
    }
    stack.push_back(north);
    stack.push_back(south);
    Occlusion occlusion(view.camera_m, settings.move_m);
    while (!stack.empty()) {
        Entry entry = stack.back();
        stack.pop_back();
        const Triangle& triangle = entry.triangle;
        const glm::ivec2 middle = (triangle.a + triangle.b) / 2;
        const bool whole = ((triangle.a.x + triangle.b.x) % 2 == 0) && ((triangle.a.y + triangle.b.y) % 2 == 0);
        const std::int64_t v = whole ? vertex_of(middle) : -1;
        const bool may_split = v >= 0 && error_m_[static_cast<std::size_t>(v)] >= 0.0F;
        if (may_split && entry.planes != 0) {
            const glm::vec3 centre = position_m(static_cast<std::uint32_t>(v));
            const float margin = turn * glm::distance(centre, view.camera_m) + shift;
            const float radius = radius_m_[static_cast<std::size_t>(v)];
            bool outside = false;
            for (std::uint32_t k = 0; k < planes.size(); ++k) {
                if ((entry.planes >> k & 1U) != 0) {
                    const float distance = glm::dot(planes[k].normal, centre) + planes[k].offset;
                    outside = outside || distance < -(radius + margin);
                    if (distance > radius * (1.0F + turn)) {
                        entry.planes &= ~(1U << k);
                    }
                }
            }
            if (outside) {
                continue;
            }
        }
        if (may_split &&
            occlusion.hides(position_m(static_cast<std::uint32_t>(v)), radius_m_[static_cast<std::size_t>(v)])) {
            continue;
        }
        if (may_split && active(static_cast<std::uint32_t>(v), t)) {
            // The half on the camera's side comes off the stack first, so that near ground hides far ground.
            Entry near{{triangle.c, triangle.a, middle}, entry.planes};
            Entry far{{triangle.b, triangle.c, middle}, entry.planes};
            const glm::vec2 cut(triangle.c - middle);
            const glm::vec2 eye = camera - glm::vec2(middle);
            if (cut.x * eye.y - cut.y * eye.x < 0.0F) {
                std::swap(near, far);
            }
            stack.push_back(far);
            stack.push_back(near);
            continue;
        }
        if (indices_.size() + 3 > limit) {
            return false;
        }
        const glm::vec3 a = position_m(static_cast<std::uint32_t>(vertex_of(triangle.a)));
        const glm::vec3 b = position_m(static_cast<std::uint32_t>(vertex_of(triangle.b)));
        const glm::vec3 c = position_m(static_cast<std::uint32_t>(vertex_of(triangle.c)));
        occlusion.add_edge(a, b);
        occlusion.add_edge(b, c);
        occlusion.add_edge(c, a);
        for (const glm::ivec2 corner : {triangle.a, triangle.b, triangle.c}) {
            indices_.push_back(static_cast<std::uint32_t>(vertex_of(corner)));
        }
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
        const float above_ground_m = std::max(0.0F, view.camera_m.z - terrain_.height_m(glm::vec2(view.camera_m)));
        const float moved = glm::distance(view.camera_m, built_for_.camera_m);
        const glm::vec3 now = view_direction(view.clip_from_world);
        const glm::vec3 then = view_direction(built_for_.clip_from_world);
        const float turned = std::atan2(glm::length(glm::cross(now, then)), glm::dot(now, then));
        keep = moved <= std::min(settings.move_m, std::max(0.1F, settings.move_fraction * above_ground_m)) &&
               turned <= settings.turn_rad;
    }
    if (keep) {
        report.skipped = 1;
    } else {
        // Starts from the last threshold, so that the choice does not flutter, and ends within 8 % of the finest that
        // fits or at the target.
        const float step = error_px_ > 0.0F ? 1.08F : 1.25F;
        float threshold = std::max(settings.target_error_px, error_px_ > 0.0F ? error_px_ : 3.0F);
        bool fits = build(view, settings, threshold);
        while (!fits) {
            threshold *= step;
            fits = build(view, settings, threshold);
        }
        const auto roomy = static_cast<std::size_t>(0.85 * 3.0 * settings.max_triangles);
        while (threshold > settings.target_error_px && indices_.size() < roomy) {
            const float finer = std::max(settings.target_error_px, threshold / 1.08F);
            if (!build(view, settings, finer)) {
                (void)build(view, settings, threshold);
                break;
            }
            threshold = finer;
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
    std::vector<Triangle> stack{{{0, 0}, {side, side}, {0, side}}, {{side, side}, {0, 0}, {side, 0}}};
    while (!stack.empty()) {
        const Triangle triangle = stack.back();
        stack.pop_back();
        const glm::ivec2 sum = triangle.a + triangle.b;
        const std::int64_t v = sum.x % 2 == 0 && sum.y % 2 == 0 ? vertex_of(sum / 2) : -1;
        if (v >= 0 && error_m_[static_cast<std::size_t>(v)] > error_m) {
            stack.push_back({triangle.c, triangle.a, sum / 2});
            stack.push_back({triangle.b, triangle.c, sum / 2});
            continue;
        }
        for (const glm::ivec2 corner : {triangle.a, triangle.b, triangle.c}) {
            indices.push_back(static_cast<std::uint32_t>(vertex_of(corner)));
        }
    }
    return indices;
}

float TerrainLod::surface_height_m(glm::vec2 position) const {
    const glm::vec2 p = glm::clamp((position - terrain_.outer.origin_m) / Terrain::inner_spacing_m, glm::vec2(0.0F),
                                   glm::vec2(static_cast<float>(side)));
    const auto cross = [](glm::vec2 u, glm::vec2 w) { return u.x * w.y - u.y * w.x; };
    Triangle triangle =
        p.y > p.x ? Triangle{{0, 0}, {side, side}, {0, side}} : Triangle{{side, side}, {0, 0}, {side, 0}};
    for (;;) {
        const glm::ivec2 sum = triangle.a + triangle.b;
        const std::int64_t v = sum.x % 2 == 0 && sum.y % 2 == 0 ? vertex_of(sum / 2) : -1;
        if (v < 0 || error_m_[static_cast<std::size_t>(v)] < 0.0F ||
            !active(static_cast<std::uint32_t>(v), threshold_)) {
            break;
        }
        const glm::ivec2 middle = sum / 2;
        // a lies to the left of the line from the middle to c's far side: which half holds p?
        const bool first = cross(glm::vec2(triangle.c - middle), p - glm::vec2(middle)) > 0.0F;
        triangle = first ? Triangle{triangle.c, triangle.a, middle} : Triangle{triangle.b, triangle.c, middle};
    }
    const auto height = [&](glm::ivec2 q) { return position_m(static_cast<std::uint32_t>(vertex_of(q))).z; };
    const glm::vec2 a(triangle.a);
    const glm::vec2 b(triangle.b);
    const glm::vec2 c(triangle.c);
    const float area = cross(b - a, c - a);
    const float u = cross(p - a, c - a) / area;
    const float w = cross(b - a, p - a) / area;
    const float h = height(triangle.a);
    return h + u * (height(triangle.b) - h) + w * (height(triangle.c) - h);
}

} // namespace alpenglow::sandbox
