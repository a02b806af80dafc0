// The run-time copy of a cloud's density: compact bricks that a ray samples without looking at neighbours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include <alpenglow/clouds/grid.hpp>

namespace alpenglow::clouds {

// Bricks of 8^3 voxels, each with an apron of one voxel on its far sides (9^3 bytes, x fastest), 8 bits a voxel with an
// offset and a scale for each brick. The error of a stored voxel is at most (max - min of its brick) / 510, and so is
// that of an interpolated one. Nodes of 8^3 bricks and bricks without density are not stored, and rays skip them whole.
class BrickVolume {
public:
    static constexpr int brick_voxels = 9 * 9 * 9;
    static constexpr std::size_t brick_stride = 736; // bytes between bricks: 729, and room for 4-byte reads

    BrickVolume() = default;
    explicit BrickVolume(const SparseGrid& grid);

    // Trilinear density at index coordinates: the scalar reference for sample_batch.
    [[nodiscard]] float sample(const glm::vec3& index) const;

    [[nodiscard]] bool empty() const { return table_.count() == 0; }
    // Index coordinates of the volume's corner: a multiple of 8, at most 8 + 7 below the first stored voxel.
    [[nodiscard]] const glm::ivec3& min() const { return min_; }
    [[nodiscard]] glm::ivec3 size() const { return table_.bricks() * 8; } // voxels
    // Tight box of the voxels with density > 0, as index coordinates of voxel centres. Empty: low > high.
    [[nodiscard]] const glm::ivec3& active_low() const { return active_low_; }
    [[nodiscard]] const glm::ivec3& active_high() const { return active_high_; }
    [[nodiscard]] std::size_t active_voxels() const { return active_; }
    [[nodiscard]] float max_density() const { return max_density_; }
    [[nodiscard]] const GridTransform& transform() const { return transform_; }
    void set_transform(const GridTransform& transform) { transform_ = transform; } // moving a cloud costs nothing else

    [[nodiscard]] const BrickTable& table() const { return table_; }
    [[nodiscard]] const std::vector<float>& scales() const { return scale_; }   // density of one step of a byte
    [[nodiscard]] const std::vector<float>& offsets() const { return offset_; } // density of byte 0
    [[nodiscard]] const std::vector<std::uint8_t>& data() const { return data_; }
    [[nodiscard]] std::size_t memory_bytes() const;

    // Means over blocks of factor^3 voxels: a dense grid of `dims` blocks whose first block's first voxel has the index
    // `first`. Parallel; x fastest.
    [[nodiscard]] std::vector<float> block_means(const glm::ivec3& first, const glm::ivec3& dims, int factor) const;

private:
    glm::ivec3 min_{0};
    glm::ivec3 active_low_{0};
    glm::ivec3 active_high_{-1};
    std::size_t active_ = 0;
    float max_density_ = 0.0F;
    GridTransform transform_;
    BrickTable table_;
    std::vector<float> scale_{0.0F};
    std::vector<float> offset_{0.0F};
    std::vector<std::uint8_t> data_ = std::vector<std::uint8_t>(brick_stride, 0);
};

// Trilinear densities at many index coordinates (structure of arrays, equal lengths), vectorised for the machine at
// hand.
void sample_batch(const BrickVolume& volume, std::span<const float> x, std::span<const float> y,
                  std::span<const float> z, std::span<float> density);

} // namespace alpenglow::clouds
