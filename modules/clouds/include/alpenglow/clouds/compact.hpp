// A lit cloud in as few bytes as a given error allows: for scenes with more clouds than memory or cache has room for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/clouds/bricks.hpp>
#include <alpenglow/clouds/lighting.hpp>
#include <alpenglow/clouds/march.hpp>

namespace alpenglow::clouds {

// A lattice's values in bricks of 8^3 cells with an apron of one on the far sides. Each brick is trimmed to the box
// beyond which it repeats its border (that of a cloud's edge is mostly nothing), or thinned to every 2nd, 4th or 8th
// cell where lines between those do, and holds as many bits a value (0 to 12) as its error asks for: whichever is the
// smallest. What is kept is the value less a plane of the brick's own, or, where small values count more, the value's
// square root. Bricks nobody asks for are not stored and read as 0.
class CompactField {
public:
    static constexpr int brick_values = 9 * 9 * 9;

    // 4 words a brick: first byte | box and bits (below) | offset | scale (floats).
    // Box: low corner 3 x 4 bits, steps to the high corner 3 x 4 bits, bits a value 4, log2 of the step 2.
    struct Brick {
        std::uint32_t at = 0;
        std::uint32_t box = 0;
        float offset = 0.0F;
        float scale = 0.0F;
    };

    // Values and the errors they may have: infinite is don't-care; 0 is for zeros that are to stay zeros (`squared`).
    // Returns whether the brick at these coordinates (in bricks) is needed. Called from several threads.
    using Fill = std::function<bool(const glm::ivec3& brick, float* values, float* errors)>;

    CompactField() = default;
    // origin: index coordinates of cell (0, 0, 0); factor: voxels a cell; bricks: extent. squared: roots are kept, of
    // values >= 0; else values less a plane. where: nodes that are empty in this table of the same extent are not asked
    // for.
    CompactField(const glm::vec3& origin, int factor, const glm::ivec3& bricks, bool squared, const Fill& fill,
                 const BrickTable* where = nullptr);

    // At index coordinates, clamped to the lattice: the scalar reference.
    [[nodiscard]] float sample(const glm::vec3& index) const;

    [[nodiscard]] const glm::vec3& origin() const { return origin_; }
    [[nodiscard]] int factor() const { return factor_; }
    [[nodiscard]] const glm::ivec3& nodes() const { return nodes_; }
    [[nodiscard]] glm::ivec3 size() const { return bricks_in_ * 8; } // cells
    // Nodes of 8^3 bricks: the number of a node's first brick, or -1, and its block of entries.
    struct Node {
        std::int32_t first = -1;
        std::int32_t entries = 0;
    };
    [[nodiscard]] const std::vector<Node>& node_table() const { return node_; }
    // 512 a node in use: the brick's number within the node, or 512 for none.
    [[nodiscard]] const std::vector<std::uint16_t>& entries() const { return entry_; }
    [[nodiscard]] const std::vector<Brick>& bricks() const { return bricks_; }
    // Of each brick's plane, in steps of a cell: three signed mantissas of 9 bits times 2^(e - 24), e in the upper 5
    // bits. Empty where values are squared.
    [[nodiscard]] const std::vector<std::uint32_t>& slopes() const { return slopes_; }
    [[nodiscard]] const std::vector<std::uint8_t>& data() const { return data_; }
    [[nodiscard]] std::size_t memory_bytes() const;

private:
    glm::vec3 origin_{0.0F};
    int factor_ = 1;
    bool squared_ = false;
    glm::ivec3 bricks_in_{0};
    glm::ivec3 nodes_{0};
    std::vector<Node> node_;
    std::vector<std::uint16_t> entry_;
    std::vector<Brick> bricks_;
    std::vector<std::uint32_t> slopes_;
    std::vector<std::uint8_t> data_; // and room for reads past the end
};

// A BeamTable in 16 bits, each angle's depths with their own offset and scale.
class CompactTable {
public:
    CompactTable() = default;
    explicit CompactTable(const BeamTable& table);

    [[nodiscard]] float value(float depth, float one_minus_cos) const; // as BeamTable::value()
    [[nodiscard]] float decay() const { return decay_; }
    [[nodiscard]] float max_depth() const { return max_depth_; }
    [[nodiscard]] float narrow() const { return narrow_; }
    [[nodiscard]] const std::vector<std::uint16_t>& values() const { return values_; } // [angle][depth]
    [[nodiscard]] const std::vector<float>& rows() const { return rows_; }             // offset and scale of each angle
    [[nodiscard]] std::size_t memory_bytes() const;

private:
    float decay_ = 1.0F;
    float max_depth_ = 64.0F;
    float narrow_ = 0.1F;
    std::vector<std::uint16_t> values_; // and room for reads of pairs
    std::vector<float> rows_;
};

// Bounds on what is stored; docs/clouds.md has the image errors that they lead to.
struct CompactSettings {
    // Of a voxel's density d, over sqrt(d) and the greatest density's: thin edges count. What is empty stays empty.
    float density_error = 1.0F / 24.0F;
    // Of an optical depth where the beam is not dimmed. At a depth tau it may grow by exp(3/4 tau) (scaled extinction):
    // so much less light is there.
    float depth_error = 1.0F / 28.0F;
    // Of multiply scattered light and skylight, over itself, or over a twentieth of the greatest where that is more.
    float light_error = 1.0F / 48.0F;
};

// All that drawing a lit cloud for an eye reads. Keeps nothing of what it is made from.
class CompactCloud {
public:
    struct Light {
        glm::vec3 to_light{0, 0, 1}; // the grid's frame
        glm::vec3 irradiance{0.0F};
        CompactField depth;
    };

    CompactCloud(const BrickVolume& volume, const CloudLighting& lighting, const glm::dvec3& eye_m,
                 const CompactSettings& settings = {});
    // Light alone anew: when it or the eye has moved.
    void relight(const BrickVolume& volume, const CloudLighting& lighting, const glm::dvec3& eye_m);

    [[nodiscard]] bool empty() const { return density_.bricks().empty(); }
    [[nodiscard]] const GridTransform& transform() const { return transform_; }
    [[nodiscard]] const glm::ivec3& min() const { return min_; }
    [[nodiscard]] const glm::ivec3& active_low() const { return active_low_; }
    [[nodiscard]] const glm::ivec3& active_high() const { return active_high_; }
    [[nodiscard]] float max_density() const { return max_density_; }
    [[nodiscard]] const CompactField& density() const { return density_; }
    [[nodiscard]] const std::vector<Light>& lights() const { return lights_; }
    [[nodiscard]] const std::vector<CompactField>& fields() const { return fields_; } // as CloudLighting::ViewFields
    [[nodiscard]] const glm::vec3& colour() const { return colour_; }
    [[nodiscard]] const CompactTable& table() const { return table_; }
    [[nodiscard]] float extinction_per_m() const { return extinction_per_m_; } // along eye rays, at density 1
    [[nodiscard]] float eye_extinction() const { return eye_extinction_; }
    [[nodiscard]] bool riemann() const { return riemann_; } // Harris: eq. 9 as it stands

    [[nodiscard]] std::size_t density_bytes() const { return density_.memory_bytes(); }
    [[nodiscard]] std::size_t light_bytes() const; // with the beam table
    [[nodiscard]] std::size_t memory_bytes() const { return density_bytes() + light_bytes(); }

private:
    CompactSettings settings_;
    GridTransform transform_;
    glm::ivec3 min_{0};
    glm::ivec3 active_low_{0};
    glm::ivec3 active_high_{-1};
    float max_density_ = 0.0F;
    CompactField density_;
    std::vector<Light> lights_;
    std::vector<CompactField> fields_;
    glm::vec3 colour_{1.0F};
    CompactTable table_;
    float extinction_per_m_ = 1.0F;
    float eye_extinction_ = 1.0F;
    bool riemann_ = false;
};

// As march() and march_scalar() of what the cloud was made from, within its errors. MarchSettings::fields is not read.
[[nodiscard]] Picture march(const CompactCloud& cloud, const Camera& camera, const MarchSettings& settings = {});
[[nodiscard]] Picture march_scalar(const CompactCloud& cloud, const Camera& camera, const MarchSettings& settings = {});

} // namespace alpenglow::clouds
