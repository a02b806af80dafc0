// Run time: light coefficients times a transfer table. SIMD (Highway, dispatched at run time), one thread; split the
// block range for more.
#pragma once

#include <alpenglow/prt/transfer_table.hpp>

#include <span>

#include <glm/vec3.hpp>

namespace alpenglow::prt {

struct BlockRange {
    std::size_t first = 0;
    std::size_t last = 0; // one past the end
};
[[nodiscard]] BlockRange all_blocks(const TransferTable& table) noexcept;

// out[point] = sum_i M_i light[i], for vector tables (rows == 1): exit radiance of albedo 1, the light's unit. `light`
// is in the table's frame, a square number of coefficients; if its order differs from the table's, the bands that both
// have are used, and bands that nobody lights are not read. out holds info.count values; points outside `blocks` are
// left. Error: relative to sum_i |M_i light[i]|, below 3e-6 (order 6) over that of the encoding.
void evaluate(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out,
              BlockRange blocks) noexcept;
void evaluate(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept;

// The same in plain scalar code: the reference.
void evaluate_scalar(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept;

// Matrix tables, eq. 9: out[row * info.count + point] = coefficient `row` of transferred radiance: plane by plane, as a
// volume texture wants it.
void evaluate_matrix(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out,
                     BlockRange blocks) noexcept;
void evaluate_matrix(const TransferTable& table, std::span<const glm::vec3> light, std::span<glm::vec3> out) noexcept;

// Matrix tables, eq. 12: out[point] = sum_i kernel[l(i)] y_i(directions[point]) (M light)_i, where `directions` are the
// reflected view directions (unit, table's frame) and kernel[l] = alpha_l G*_l of the lobe (lobe.hpp).
void evaluate_glossy(const TransferTable& table, std::span<const glm::vec3> light, std::span<const float> kernel,
                     std::span<const glm::vec3> directions, std::span<glm::vec3> out, BlockRange blocks) noexcept;
void evaluate_glossy(const TransferTable& table, std::span<const glm::vec3> light, std::span<const float> kernel,
                     std::span<const glm::vec3> directions, std::span<glm::vec3> out) noexcept;
void evaluate_glossy_scalar(const TransferTable& table, std::span<const glm::vec3> light, std::span<const float> kernel,
                            std::span<const glm::vec3> directions, std::span<glm::vec3> out) noexcept;

} // namespace alpenglow::prt
