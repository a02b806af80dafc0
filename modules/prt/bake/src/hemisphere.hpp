// One point's hemisphere: which directions to shoot, and what the answers integrate to.
#pragma once

#include <alpenglow/prt/bake.hpp>

#include "scene.hpp"

#include <array>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
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
    double tracing_s = 0.0; // CPU time within the ray tracer
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
        std::vector<std::uint32_t> cells;
    };
    // Shoots the rays of one point. `frame` maps the point's frame to the object's; `stream` seeds random samplings.
    [[nodiscard]] HemisphereResult trace(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                         std::uint64_t stream, Scratch& scratch) const;

    // The clamped cosine over pi, about +Z.
    [[nodiscard]] const CoefficientRow& unoccluded() const noexcept { return unoccluded_; }
    [[nodiscard]] double unoccluded_norm() const noexcept { return unoccluded_norm_; }

private:
    struct Level {
        std::size_t size = 0;                 // cells a side
        DirectionList directions;             // of the cells' centres
        std::vector<CoefficientRow> integral; // int over the cell of cos/pi y
        std::vector<float> norm2;             // of those
    };
    [[nodiscard]] HemisphereResult trace_list(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                              std::uint64_t stream, Scratch& scratch) const;
    [[nodiscard]] HemisphereResult trace_grid(const Scene& scene, const glm::vec3& origin, const glm::mat3& frame,
                                              Scratch& scratch) const;

    Sampling sampling_;
    int order_;
    std::size_t coefficients_;
    std::size_t rays_;
    double max_error_;
    std::uint64_t seed_;
    DirectionList directions_;         // fibonacci
    std::vector<CoefficientRow> rows_; // fibonacci
    std::vector<Level> levels_;        // adaptive: from 16 x 16 on
    CoefficientRow unoccluded_;
    double unoccluded_norm_ = 0.0;
};

} // namespace alpenglow::prt
