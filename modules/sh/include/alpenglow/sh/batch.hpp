// Many at a time: structure-of-arrays batches, vectorised, with the instruction set chosen at run time
// (SSE4, AVX2, AVX-512 on x86; portable code below them). Every function here does what its scalar namesake does, item
// by item; no item ever influences another, so that a NaN stays where it is.
#pragma once

#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace alpenglow::sh {

// Kernels read and write whole groups of this many items. Every row must have room for count rounded up to it; what
// stands in the padding is ignored and may be overwritten.
inline constexpr std::size_t batch_group = 16;
[[nodiscard]] constexpr std::size_t padded(std::size_t count) noexcept {
    return (count + batch_group - 1) / batch_group * batch_group;
}

// Structure of arrays: component `row` of item k stands at data[row * stride + k]; stride >= padded(count). Rows need
// no alignment, but 64 bytes is faster, and so is a stride that is no power of two.
struct ConstBatch {
    const float* data = nullptr;
    std::size_t count = 0;
    std::size_t stride = 0;

    [[nodiscard]] const float* row(std::size_t i) const noexcept { return data + i * stride; }
    // The rows from `first` on, and the items [begin, end); begin a multiple of batch_group.
    [[nodiscard]] ConstBatch from_row(std::size_t first) const noexcept { return {row(first), count, stride}; }
    [[nodiscard]] ConstBatch items(std::size_t begin, std::size_t end) const noexcept {
        assert(begin % batch_group == 0 && begin <= end && end <= count);
        return {data + begin, end - begin, stride};
    }
};

struct Batch {
    float* data = nullptr;
    std::size_t count = 0;
    std::size_t stride = 0;

    operator ConstBatch() const noexcept { return {data, count, stride}; } // NOLINT(google-explicit-constructor)
    [[nodiscard]] float* row(std::size_t i) const noexcept { return data + i * stride; }
    [[nodiscard]] Batch from_row(std::size_t first) const noexcept { return {row(first), count, stride}; }
    [[nodiscard]] Batch items(std::size_t begin, std::size_t end) const noexcept {
        assert(begin % batch_group == 0 && begin <= end && end <= count);
        return {data + begin, end - begin, stride};
    }
};

// Storage for a batch: aligned, zeroed, padded, with a stride that does not alias in the cache.
class BatchBuffer {
public:
    BatchBuffer(std::size_t rows, std::size_t count);

    [[nodiscard]] Batch view() noexcept { return {data_.get(), count_, stride_}; }
    [[nodiscard]] ConstBatch view() const noexcept { return {data_.get(), count_, stride_}; }
    [[nodiscard]] float* row(std::size_t i) noexcept { return data_.get() + i * stride_; }
    [[nodiscard]] const float* row(std::size_t i) const noexcept { return data_.get() + i * stride_; }
    [[nodiscard]] std::size_t rows() const noexcept { return rows_; }
    [[nodiscard]] std::size_t count() const noexcept { return count_; }
    operator Batch() noexcept { return view(); }            // NOLINT(google-explicit-constructor)
    operator ConstBatch() const noexcept { return view(); } // NOLINT(google-explicit-constructor)

private:
    struct Free {
        void operator()(float* p) const noexcept;
    };
    std::size_t rows_, count_, stride_;
    std::unique_ptr<float[], Free> data_;
};

// The instruction set in use: "AVX3" is AVX-512. limit_batch_target narrows the choice for tests and benchmarks and is
// not for use while a batch runs on another thread.
enum class BatchTarget { scalar, sse4, avx2, avx512, best };
[[nodiscard]] const char* batch_target_name();
// Returns false, and changes nothing, where the machine or the build lacks the target.
bool limit_batch_target(BatchTarget target);

// Basis: directions has rows x, y, z; out has order*order rows.
void evaluate_basis(int order, ConstBatch directions, Batch out);

// Values, one row: one coefficient vector in many directions, or each item's coefficients in its own direction. The
// is never stored. Error below 4e-7 of the coefficients' norm up to order 6, 1e-6 above.
void evaluate(int order, std::span<const float> coefficients, ConstBatch directions, Batch values);
void evaluate(int order, ConstBatch coefficients, ConstBatch directions, Batch values);

// out_lm = factors[l] in_lm: windows, zonal convolution, irradiance. In place is fine. `factors` has `order` values.
void scale_bands(int order, std::span<const float> factors, ConstBatch in, Batch out);

// One rotation for many vectors (in place is fine), and a rotation for each: rows x, y, z, w of unit quaternions
// (a length within 1e-3 of 1 is corrected). Error below 3e-7 of the vector's norm, for tilts of any size.
void rotate(const Rotation& rotation, ConstBatch in, Batch out);
void rotate(int order, ConstBatch quaternions, ConstBatch in, Batch out);

// About +Z, one angle for all, or rows cos, sin for each item. In place is fine.
void rotate_z(int order, double angle_rad, ConstBatch in, Batch out);
void rotate_z(int order, ConstBatch cos_sin, ConstBatch in, Batch out);

// Projections of the pointwise product f g on the bands below `order` (see product.hpp). out may be f or g.
void product(int order, ConstBatch f, ConstBatch g, Batch out);

// The integral of f g h over the sphere, one row: an entry a item.
void triple_product(int order, ConstBatch f, ConstBatch g, ConstBatch h, Batch out);

// The matrix of "multiply by f" of each item: entry (i, j) in row i * order^2 + j, order^4 rows. out is not f.
void product_matrix(int order, ConstBatch f, Batch out);

// One projection of many weighted samples: out[c * order^2 + i] = sum_k weights[k] values_c[k] Y_i(directions_k), with
// rows x, y, z of directions, one row of values a channel, and as many weights as samples (padding
// is not read). Sums of 32 terms are in float, then in double: error below 3e-7 of sum |weights values|.
void project_samples(int order, ConstBatch directions, ConstBatch values, int channels, std::span<const float> weights,
                     std::span<double> out);

// out = sum over eight corners of weight * probe: trilinear blending out of a grid. probes: coefficient vectors one
// after the other, `probe_stride` floats apart; receiver r blends probes corners[8 r + c] with weights[8 r + c] into
// out[r * probe_stride ..]. `coefficients` floats each (27 for RGB at order 3); both strides hold them rounded up
// to 16.
void blend(std::size_t coefficients, const float* probes, std::size_t probe_stride,
           std::span<const std::uint32_t> corners, std::span<const float> weights, float* out);

} // namespace alpenglow::sh
