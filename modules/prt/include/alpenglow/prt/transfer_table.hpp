// Tables of transfer vectors and matrices: what a bake makes, a file holds, and the run time reads.
//
// Sloan, Kautz and Snyder, "Precomputed Radiance Transfer" (2002). A vector M maps light coefficients L to exit
// radiance of a diffuse point of albedo 1, L'_p = sum_i M_i L_i (eq. 8, with the 1/pi of T_DS inside); the point's own
// albedo multiplies the result at run time. A matrix maps L to the coefficients of transferred radiance, eq. 9.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/sh/basis.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::prt {

inline constexpr std::size_t block_points = 16; // points that stand side by side in a table, see TransferTable

enum class TransferKind : std::uint32_t {
    mesh = 0,          // vectors, one a vertex
    texels = 1,        // vectors, one a texel of a heightfield or lightmap
    glossy = 2,        // matrices, one a vertex
    volume = 3,        // vectors, one a voxel
    neighbourhood = 4, // matrices, one a point of a grid around the object
};

enum class Encoding : std::uint32_t {
    f32 = 0,
    f16 = 1,
    s8 = 2,   // 8-bit integers times a scale for each band and channel
    cpca = 3, // clustered principal components: Sloan, Hall, Hart, Snyder (2003)
};

// Points of a grid: point (x, y, z) stands at origin_m + step_m * (x, y, z), index x + size.x * (y + size.y * z).
struct Grid {
    glm::uvec3 size{0};
    glm::vec3 origin_m{0.0F};
    glm::vec3 step_m{0.0F};
};

// Transfer as a bake makes it: plain floats, [point][row][channel][coefficient].
struct TransferField {
    TransferKind kind = TransferKind::mesh;
    int order = 5;         // bands of the light, 1 .. 6
    int out_order = 0;     // 0: vectors (one row); else matrices of out_order^2 rows
    int channels = 1;      // 3: colour bleeding makes the channels differ
    std::size_t count = 0; // points
    Grid grid;             // volumes and neighbourhoods
    std::uint64_t mesh_hash = 0;
    std::vector<float> values;

    [[nodiscard]] int rows() const noexcept { return out_order == 0 ? 1 : out_order * out_order; }
    [[nodiscard]] int coefficients() const noexcept { return order * order; }
    [[nodiscard]] std::size_t width() const noexcept {
        return static_cast<std::size_t>(rows() * channels * coefficients());
    }
    [[nodiscard]] std::span<float> point(std::size_t i) noexcept { return {values.data() + i * width(), width()}; }
    [[nodiscard]] std::span<const float> point(std::size_t i) const noexcept {
        return {values.data() + i * width(), width()};
    }
};

// What a table is, beside its data. Written to files as it stands (little-endian, no padding).
struct TransferInfo {
    TransferKind kind = TransferKind::mesh;
    Encoding encoding = Encoding::f32;
    std::uint32_t order = 5;
    std::uint32_t rows = 1;
    std::uint32_t channels = 1;
    std::uint32_t clusters = 0;   // CPCA only
    std::uint32_t components = 0; // CPCA only: principal components a cluster
    std::uint32_t reserved = 0;
    std::uint64_t count = 0; // points
    std::uint64_t slots = 0; // places in the blocks: points and padding, a multiple of block_points
    std::uint64_t mesh_hash = 0;
    glm::uvec3 grid_size{0};
    glm::vec3 grid_origin_m{0.0F};
    glm::vec3 grid_step_m{0.0F};
    float encoding_rms = 0.0F; // relative RMS error of the encoding: |decoded - baked| / |baked| over all values
    // The largest 2-norm (matrices: Frobenius) of a band's transfer over points and channels: a change dL of the light
    // changes no point's result by more than sum_l band_norm[l] |dL_l|.
    std::array<float, 8> band_norm{};
    std::array<float, 24> band_scale{}; // s8: value = scale[channel * 8 + band] * integer

    [[nodiscard]] std::size_t coefficients() const noexcept { return std::size_t{order} * order; }
    [[nodiscard]] std::size_t width() const noexcept { return coefficients() * channels * rows; }
};

// An encoded table. Points stand in blocks of 16, so that one register holds one coefficient of many points:
// [block][row][channel][coefficient][16]. CPCA blocks hold [block][component][16] weights (signed bytes), every block
// of one cluster, and `clusters` holds [cluster][1 + components][row][channel][coefficient] floats: the mean, then the
// basis with the weights' scale in it. Data is shared and never written after it was made: copying a table is cheap.
struct TransferTable {
    TransferInfo info;
    std::span<const std::byte> blocks;             // aligned to 64 bytes
    std::span<const float> clusters;               // CPCA
    std::span<const std::uint32_t> cluster_blocks; // CPCA: first block of each cluster, and the end
    std::span<const std::uint32_t> slot_points;    // CPCA: the point of each slot, or no_point in padding
    std::shared_ptr<const void> owner;             // keeps the memory or the mapped file

    static constexpr std::uint32_t no_point = 0xFFFFFFFFU;

    [[nodiscard]] std::size_t bytes() const noexcept {
        return blocks.size() + clusters.size_bytes() + cluster_blocks.size_bytes() + slot_points.size_bytes();
    }
};

// Encodes as f32, f16 or s8 (CPCA: compress.hpp of prt_bake). Values must be finite: the bake sees to it, and an Error
// says which point is not. Halves clamp at 65504.
[[nodiscard]] Result<TransferTable> encode(const TransferField& field, Encoding encoding);

// The floats that a table stands for, in the order of TransferField::values. The slow way back, for tests and tools.
[[nodiscard]] TransferField decode(const TransferTable& table);

// For encoders: zeros, aligned to 64 bytes as the evaluation wants `blocks`.
[[nodiscard]] std::shared_ptr<std::span<std::byte>> aligned_memory(std::size_t bytes);
// For encoders: fills band_norm.
void fill_band_norms(const TransferField& field, TransferInfo& info);
// |decoded - baked| / |baked| over all values.
[[nodiscard]] double relative_rms(const TransferField& decoded, const TransferField& baked);

} // namespace alpenglow::prt
