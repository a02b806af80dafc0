// Sparse voxel grids of density on the CPU: what modelling writes, files are read into, and the reference traces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace alpenglow::clouds {

// Where a grid's voxels lie: world = origin_m + axes * (voxel_m * index). The centre of voxel (i, j, k) has the index
// coordinates (i, j, k), as in OpenVDB. `axes` is orthonormal; rotations and reflections, and a voxel size for each
// axis, are what the module supports: no shear, no frustum.
struct GridTransform {
    glm::dvec3 origin_m{0.0};
    glm::dmat3 axes{1.0};
    glm::dvec3 voxel_m{1.0};

    [[nodiscard]] glm::dvec3 world_from_index(const glm::dvec3& index) const;
    [[nodiscard]] glm::dvec3 index_from_world(const glm::dvec3& world_m) const;
    // A world direction in the grid's own orthonormal frame (metres along the grid's axes).
    [[nodiscard]] glm::dvec3 local_direction(const glm::dvec3& world) const;
};

// Two levels over bricks of 8^3 voxels: nodes of 8^3 bricks in a dense table, entries only for nodes in use.
class BrickTable {
public:
    static constexpr int brick_size = 8; // voxels a side
    static constexpr int node_size = 8;  // bricks a side
    static constexpr int max_axis_voxels = 16384;

    BrickTable() = default;
    explicit BrickTable(const glm::ivec3& bricks);

    // The brick's number, or -1. (x, y, z) in bricks; outside the table: -1.
    [[nodiscard]] std::int32_t find(int x, int y, int z) const;
    // The brick's number, which is `count()` if it is new.
    std::int32_t insert(int x, int y, int z);

    [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(coordinates_.size()); }
    [[nodiscard]] const glm::ivec3& bricks() const { return bricks_; }
    [[nodiscard]] const glm::ivec3& nodes() const { return nodes_; }
    [[nodiscard]] const std::vector<glm::ivec3>& coordinates() const {
        return coordinates_;
    }                                                                                   // of each brick, in bricks
    [[nodiscard]] const std::vector<std::int32_t>& node_table() const { return node_; } // -1 or a multiple of 512
    [[nodiscard]] const std::vector<std::int32_t>& entries() const { return entry_; }   // -1 or a brick's number
    [[nodiscard]] std::size_t memory_bytes() const;

private:
    glm::ivec3 bricks_{0};
    glm::ivec3 nodes_{0};
    std::vector<std::int32_t> node_;
    std::vector<std::int32_t> entry_;
    std::vector<glm::ivec3> coordinates_;
};

// Float densities >= 0 (unit: the file's own, extinction = density * Medium::extinction_per_m), zero outside its
// bricks.
class SparseGrid {
public:
    static constexpr int brick_voxels = 512;

    SparseGrid() = default;
    // Voxel indices min .. min + size - 1 can be set. `min` is rounded down to a multiple of 8, the end up.
    SparseGrid(const glm::ivec3& min, const glm::ivec3& size, const GridTransform& transform);

    [[nodiscard]] float value(int x, int y, int z) const; // at voxel index (x, y, z); 0 where nothing is stored
    // Trilinear interpolation at index coordinates: the density that every method and the reference agree on.
    [[nodiscard]] float sample(double x, double y, double z) const;

    // The 512 values of a brick (x fastest), made on first use. (x, y, z) in bricks relative to min().
    float* brick(int x, int y, int z);
    [[nodiscard]] const float* brick(std::int32_t number) const {
        return values_.data() + std::size_t(number) * brick_voxels;
    }
    float* brick(std::int32_t number) { return values_.data() + std::size_t(number) * brick_voxels; }

    [[nodiscard]] const glm::ivec3& min() const { return min_; }
    [[nodiscard]] const BrickTable& table() const { return table_; }
    [[nodiscard]] const GridTransform& transform() const { return transform_; }
    void set_transform(const GridTransform& transform) { transform_ = transform; }
    [[nodiscard]] std::size_t active_voxels() const; // voxels with density > 0
    [[nodiscard]] float max_density() const;
    [[nodiscard]] std::size_t memory_bytes() const;
    // Drops bricks without a voxel > 0.
    void prune();

private:
    glm::ivec3 min_{0};
    GridTransform transform_;
    BrickTable table_;
    std::vector<float> values_;
};

} // namespace alpenglow::clouds
