// One point's hemisphere: which directions to shoot, and what the answers integrate to.
#pragma once

#include <alpenglow/prt/bake.hpp>

#include "scene.hpp"

#include <array>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::prt {

inline constexpr std::size_t row_floats = 48; // coefficients of a direction, padded: order 6 fits

struct alignas(64) CoefficientRow {
    std::array<float, row_floats> values{};
};

// What a point's shadow rays say, in the point's own frame (normal = +Z).
struct HemisphereResult {
    CoefficientRow transfer; // int V cos/pi y
    double visibility = 1.0; // int V cos/pi
    double variance = 0.0;   // of the transfer vector: E |error|^2, estimated
    std::uint64_t rays = 0;
    std::uint64_t batches = 0; // calls of the ray tracer
    double tracing_s = 0.0;    // CPU time within the ray tracer, if measured
};

// Many directions, component by component.
struct DirectionList {
    std::vector<float> x, y, z;
    void push_back(const glm::vec3& d) {
        x.push_back(d.x);
        y.push_back(d.y);
        z.push_back(d.z);
    }
    void resize(std::size_t count) {
        x.resize(count);
        y.resize(count);
        z.resize(count);
    }
    [[nodiscard]] std::size_t size() const noexcept { return x.size(); }
};

// Tables that all points share. Immutable once built.
class Hemisphere {
public:
    explicit Hemisphere(const BakeSettings& settings);

    struct Scratch {
        DirectionList local;
        DirectionList directions;
        std::vector<std::uint8_t> hit;
        struct Crossing { // on an edge of the grid: eighths of a cell along it
            std::uint32_t edge;
            std::uint8_t low;
            std::uint8_t high;
            bool low_blocked;
        };
        std::vector<std::uint8_t> node;
        std::vector<std::uint8_t> coarser;
        std::vector<std::uint32_t> asked;
        std::vector<Crossing> crossings;
        std::vector<float> radial_crossing;  // edge (ring, sector) -> (ring + 1, sector)
        std::vector<float> angular_crossing; // edge (ring, sector) -> (ring, sector + 1)
    };
    // Shoots the rays of one point. `frame` maps the point's frame to the object's; `stream` seeds random samplings.
    [[nodiscard]] HemisphereResult trace(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                         std::uint64_t stream, Scratch& scratch) const;

    // The clamped cosine over pi, about +Z.
    [[nodiscard]] const CoefficientRow& unoccluded() const noexcept { return unoccluded_; }
    [[nodiscard]] double unoccluded_norm() const noexcept { return unoccluded_norm_; }

private:
    // A polar grid: `rings` steps in u = sin^2 theta, `sectors` in azimuth v, so that all cells have the same cosine
    // measure and a horizon runs along grid lines. Nodes are numbered ring * sectors + sector, ring 0 being the pole.
    struct Level {
        std::size_t rings = 0;
        std::size_t sectors = 0;
        std::vector<glm::vec2> radial;        // (sin, cos) theta at every 1/8 of a ring
        std::vector<glm::vec2> azimuth;       // (cos, sin) phi at every 1/8 of a sector
        std::vector<CoefficientRow> integral; // int over a cell of cos/pi y,
        std::vector<CoefficientRow> slope_u;  // and of its best linear fit the slopes along the cell's sides
        std::vector<CoefficientRow> slope_v;
        std::vector<CoefficientRow>
            before;                       // of a ring's cells before each sector and, last, of all: [ring][sectors + 1]
        std::vector<std::uint32_t> fresh; // nodes that the next coarser grid does not have, and their directions
        DirectionList fresh_directions;
        [[nodiscard]] glm::vec3 direction(std::size_t eighth_u, std::size_t eighth_v) const {
            const glm::vec2 r = radial[eighth_u];
            const glm::vec2 a = azimuth[eighth_v];
            return {r.x * a.x, r.x * a.y, r.y};
        }
    };
    // What a grid's nodes and the crossings on its edges integrate to: the smaller of the two kinds.
    struct Coverage {
        CoefficientRow sum;
        std::uint8_t kind = 1; // 1: blocked, 0: visible
        double part = 0.0;
    };
    [[nodiscard]] HemisphereResult trace_list(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                              std::uint64_t stream, Scratch& scratch) const;
    [[nodiscard]] HemisphereResult trace_contours(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                                  Scratch& scratch) const;
    void shoot(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame, const DirectionList& local,
               Scratch& scratch, HemisphereResult& result) const;
    void ask(const Scene& scene, const glm::vec3& origin, Scratch& scratch, std::size_t count,
             HemisphereResult& result) const;
    void add(CoefficientRow& sum, const CoefficientRow& row) const noexcept {
        for (std::size_t i = 0; i < padded_; ++i) {
            sum.values[i] += row.values[i];
        }
    }
    [[nodiscard]] Coverage integrate(const Level& level, const Scene& scene, const glm::vec3& origin,
                                     const glm::mat3& frame, Scratch& scratch, HemisphereResult& result) const;

    Sampling sampling_;
    int order_;
    std::size_t coefficients_;
    std::size_t padded_; // to whole registers
    std::size_t rays_;
    double max_error_;
    std::uint64_t seed_;
    bool measure_;
    DirectionList directions_;         // fibonacci
    std::vector<CoefficientRow> rows_; // fibonacci
    std::vector<Level> levels_;        // adaptive
    std::size_t detect_ = 0;           // the last level whose nodes are all shot
    CoefficientRow unoccluded_;
    double unoccluded_norm_ = 0.0;
};

} // namespace alpenglow::prt
