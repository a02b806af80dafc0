// Projection of cube maps and equirectangular maps.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_image.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include <alpenglow/sh/image.hpp>

#include "cube_tables.hpp"
#include "image_check.hpp"
#include "simd-inl.h"
#include <alpenglow/sh/gauss_legendre.hpp>

#include <alpenglow/core/constants.hpp>

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

// Three channels of as many pixels as the tag has lanes; bad pixels turn black and are counted.
template <class Tag>
struct Pixels {
    hn::Vec<Tag> channel[3];
};

template <class Tag>
HWY_INLINE Pixels<Tag> load_pixels(Tag tag, const float* p, std::size_t& bad) {
    Pixels<Tag> v;
    hn::LoadInterleaved3(tag, p, v.channel[0], v.channel[1], v.channel[2]);
    const auto fine =
        hn::And(hn::IsFinite(v.channel[0]), hn::And(hn::IsFinite(v.channel[1]), hn::IsFinite(v.channel[2])));
    if (HWY_UNLIKELY(!hn::AllTrue(tag, fine))) {
        bad += hn::Lanes(tag) - hn::CountTrue(tag, fine);
        for (auto& c : v.channel) {
            c = hn::IfThenElseZero(fine, c);
        }
    }
    return v;
}

// The eight pixels of one cell of the octant, at the corners (+-x, +-y, +-z): out[p] gets their sum with the signs of
// parity p, whose bits are x, y, z. in[corner] has the same bits, set for the negative side.
template <class Vec>
HWY_INLINE void fold(Vec (&v)[8]) {
    for (int bit = 1; bit < 8; bit *= 2) {
        for (int i = 0; i < 8; ++i) {
            if ((i & bit) == 0) {
                const Vec a = v[i], b = v[i | bit];
                v[i] = hn::Add(a, b);
                v[i | bit] = hn::Sub(a, b);
            }
        }
    }
}

// How a face lies in the world: the axis of its columns and of its rows and whether they run the negative way.
struct FaceFrame {
    int s_axis, t_axis;
    bool s_negative, t_negative;
};
constexpr FaceFrame face_frames[6] = {{2, 1, true, true},  {2, 1, false, true}, {0, 2, false, false},
                                      {0, 2, false, true}, {0, 1, false, true}, {0, 1, true, true}};

// Rows [begin, end) of the octant on the face pair of `axis`; parity p of channel c goes to out + (3 p + c) * plane.
template <class Tag>
HWY_INLINE void fold_rows(Tag tag, const CubeMap& map, int axis, std::size_t begin, std::size_t end,
                          std::size_t row_floats, float* out, std::size_t plane, std::size_t& bad) {
    const auto size = static_cast<std::size_t>(map.size);
    const std::size_t half = (size + 1) / 2, n = hn::Lanes(tag);
    for (std::size_t i = begin; i < end; ++i) {
        float* target = out + (i - begin) * row_floats;
        // Cell (i, j) counts from the middle outwards. The pixels of a corner: row and column on the side of its sign.
        const std::size_t low_row = half - 1 - i, high_row = size - half + i;
        std::size_t j = 0;
        for (; j + n <= half; j += n) {
            hn::Vec<Tag> corner[3][8];
            for (int side = 0; side < 2; ++side) {
                const int face = 2 * axis + side;
                const FaceFrame f = face_frames[face];
                const float* pixels = map.faces[static_cast<std::size_t>(face)].data();
                for (int t = 0; t < 2; ++t) {
                    const float* row = pixels + 3 * size * (t == 0 ? low_row : high_row);
                    const int bits = (side << axis) | ((t == 0) != f.t_negative ? 1 << f.t_axis : 0);
                    const Pixels<Tag> right = load_pixels(tag, row + 3 * (size - half + j), bad);
                    const Pixels<Tag> left = load_pixels(tag, row + 3 * (half - j - n), bad);
                    for (int c = 0; c < 3; ++c) {
                        corner[c][bits | (f.s_negative ? 1 << f.s_axis : 0)] = right.channel[c];
                        corner[c][bits | (f.s_negative ? 0 : 1 << f.s_axis)] = hn::Reverse(tag, left.channel[c]);
                    }
                }
            }
            for (int c = 0; c < 3; ++c) {
                fold(corner[c]);
                for (int p = 0; p < 8; ++p) {
                    hn::StoreU(corner[c][p], tag, target + static_cast<std::size_t>(3 * p + c) * plane + j);
                }
            }
        }
        for (; j < half; ++j) {
            float corner[3][8];
            for (int side = 0; side < 2; ++side) {
                const int face = 2 * axis + side;
                const FaceFrame f = face_frames[face];
                const float* pixels = map.faces[static_cast<std::size_t>(face)].data();
                for (int t = 0; t < 2; ++t) {
                    for (int s = 0; s < 2; ++s) {
                        const std::size_t column = s == 0 ? half - 1 - j : size - half + j;
                        const float* p = pixels + 3 * (size * (t == 0 ? low_row : high_row) + column);
                        const int bits = (side << axis) | ((t == 0) != f.t_negative ? 1 << f.t_axis : 0) |
                                         ((s == 0) != f.s_negative ? 1 << f.s_axis : 0);
                        const bool fine = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
                        bad += fine ? 0 : 1;
                        for (int c = 0; c < 3; ++c) {
                            corner[c][bits] = fine ? p[c] : 0.0F;
                        }
                    }
                }
            }
            for (int c = 0; c < 3; ++c) {
                for (int p = 0; p < 8; ++p) {
                    float sum = 0.0F;
                    for (int k = 0; k < 8; ++k) {
                        const int negatives = (p & k & 1) + ((p & k) >> 1 & 1) + ((p & k) >> 2 & 1);
                        sum += negatives % 2 != 0 ? -corner[c][k] : corner[c][k];
                    }
                    target[static_cast<std::size_t>(3 * p + c) * plane + j] = sum;
                }
            }
        }
        for (; j < row_floats; ++j) {
            for (std::size_t p = 0; p < 24; ++p) {
                target[p * plane + j] = 0.0F;
            }
        }
    }
}

// The basis times the solid angles of rows [begin, end) of the octant, coefficient i from out + i * stride on.
struct CubeWeights {
    detail::CubeTables tables;
    int axis;
    std::size_t half, begin, end;
    float* out;
    std::size_t stride;

    struct Sink {
        V weight;
        float* out;
        std::size_t stride;
        template <int I>
        HWY_INLINE void put(V v) const {
            store(hn::Mul(weight, v), out + I * stride);
        }
    };
    template <int Order>
    HWY_INLINE void run() const {
        const std::size_t plane = half * tables.row_floats;
        for (std::size_t i = begin; i < end; ++i) {
            const float* scales = tables.table + i * tables.row_floats;
            for (std::size_t j = 0; j < tables.row_floats; j += lanes()) {
                const V scale = load(scales + j);
                const V s = hn::Mul(load(tables.centre + j), scale), t = hn::Mul(hn::Set(d, tables.centre[i]), scale);
                Sink sink{load(scales + plane + j), out + (i - begin) * tables.row_floats + j, stride};
                basis<Order>(axis == 0 ? scale : s, axis == 1 ? scale : t, axis == 2 ? scale : axis == 1 ? t : s, sink);
            }
        }
    }
};

void cube_kernel(const CubeMap& map, int order, const detail::CubeTables& tables, double* sums, std::size_t* bad_out) {
    const auto half = static_cast<std::size_t>((map.size + 1) / 2);
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    const std::size_t row_floats = tables.row_floats, plane_floats = half * row_floats;
    // Blocks of rows small enough for the second-level cache; planes that do not alias in the first.
    const std::size_t rows = std::clamp<std::size_t>(512 / row_floats, 1, half);
    const std::size_t plane = rows * row_floats + 16;
    const std::size_t weight_floats = tables.centre != nullptr ? count * plane : 0;
    const hwy::AlignedFreeUniquePtr<float[]> folded =
        hwy::AllocateAligned<float>(24 * plane + weight_floats + 3 * count * lanes());
    float* const made = folded.get() + 24 * plane;
    float* const partial = made + weight_floats; // sums not yet added up, of `pending` terms
    std::fill_n(partial, 3 * count * lanes(), 0.0F);
    std::size_t pending = 0, bad = 0;
    // Float sums of 32 terms, then double.
    constexpr std::size_t most_terms = 32;
    const auto add_up = [&]() HWY_ATTR {
        for (std::size_t i = 0; i < 3 * count && pending > 0; ++i) {
            sums[i] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, load(partial + i * lanes()))));
            store(hn::Zero(d), partial + i * lanes());
        }
        pending = 0;
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (std::size_t begin = 0; begin < half; begin += rows) {
            const std::size_t end = std::min(half, begin + rows);
            if (half % 16 == 0) {
                fold_rows(d, map, axis, begin, end, row_floats, folded.get(), plane, bad);
            } else {
                fold_rows(hn::CappedTag<float, 8>(), map, axis, begin, end, row_floats, folded.get(), plane, bad);
            }
            if (tables.centre != nullptr) {
                for_order(order, CubeWeights{tables, axis, half, begin, end, made, plane});
            }
            const std::size_t floats = (end - begin) * row_floats;
            for (std::size_t first = 0; first < floats; first += most_terms * lanes()) {
                const std::size_t last = std::min(floats, first + most_terms * lanes());
                if (pending + (last - first) / lanes() > most_terms) {
                    add_up();
                }
                pending += (last - first) / lanes();
                for (int l = 0; l < order; ++l) {
                    for (int m = -l; m <= l; ++m) {
                        const auto i = static_cast<std::size_t>(index(l, m));
                        const int am = m < 0 ? -m : m;
                        const int parity = ((am + (m < 0 ? 1 : 0)) % 2) | (m < 0 ? 2 : 0) | ((l - am) % 2 != 0 ? 4 : 0);
                        const float* weights = tables.centre != nullptr
                                                   ? made + i * plane
                                                   : tables.table +
                                                         (static_cast<std::size_t>(axis) * count + i) * plane_floats +
                                                         begin * row_floats;
                        const float* values = folded.get() + static_cast<std::size_t>(3 * parity) * plane;
                        float* sum = partial + 3 * i * lanes();
                        V r = load(sum), g = load(sum + lanes()), b = load(sum + 2 * lanes());
                        for (std::size_t k = first; k < last; k += lanes()) {
                            const V w = load(weights + k);
                            r = hn::MulAdd(w, load(values + k), r);
                            g = hn::MulAdd(w, load(values + plane + k), g);
                            b = hn::MulAdd(w, load(values + 2 * plane + k), b);
                        }
                        store(r, sum);
                        store(g, sum + lanes());
                        store(b, sum + 2 * lanes());
                    }
                }
            }
        }
    }
    add_up();
    *bad_out = bad;
}

// sums[3 (2 m + k) + c]: of channel c with cos (k = 0) or sin (k = 1) of m phi along one row, pixels `half` apart
// folded.
struct RowSums {
    const float* row;
    std::size_t width, span; // span = width / 2 where the row folds, else width
    const float* cosines;    // [m][padded(span)]
    const float* sines;
    double* sums;
    std::size_t* bad;

    template <int Order>
    HWY_INLINE void run() const {
        const bool folds = span < width;
        const std::size_t stride = padded(span);
        std::fill_n(sums, 6 * Order, 0.0);
        // Float sums of 32 terms, then double.
        for (std::size_t first = 0; first < span; first += 32 * lanes()) {
            add<Order>(first, HWY_MIN(span, first + 32 * lanes()), folds, stride);
        }
    }

    template <int Order>
    HWY_INLINE void add(std::size_t first, std::size_t last, bool folds, std::size_t stride) const {
        V sum[3][2 * Order];
        HWY_UNROLL(64)
        for (int i = 0; i < 2 * Order; ++i) {
            sum[0][i] = sum[1][i] = sum[2][i] = hn::Zero(d);
        }
        HWY_ALIGN float tail[2][3 * 16] = {};
        for (std::size_t k = first; k < last; k += lanes()) {
            const float* near = row + 3 * k;
            const float* far = near + 3 * span;
            if (k + lanes() > span) { // the last pixels, with black after them
                std::copy_n(near, 3 * (span - k), tail[0]);
                near = tail[0];
                if (folds) {
                    std::copy_n(far, 3 * (span - k), tail[1]);
                    far = tail[1];
                }
            }
            Pixels<D> a = load_pixels(d, near, *bad), b = a;
            if (folds) {
                b = load_pixels(d, far, *bad);
                for (int c = 0; c < 3; ++c) {
                    const V even = hn::Add(a.channel[c], b.channel[c]);
                    b.channel[c] = hn::Sub(a.channel[c], b.channel[c]);
                    a.channel[c] = even;
                }
            }
            HWY_UNROLL(64)
            for (int m = 0; m < Order; ++m) {
                const V cosine = load(cosines + static_cast<std::size_t>(m) * stride + k);
                const V sine = load(sines + static_cast<std::size_t>(m) * stride + k);
                HWY_UNROLL(4)
                for (int c = 0; c < 3; ++c) {
                    const V value = m % 2 == 0 ? a.channel[c] : b.channel[c];
                    sum[c][2 * m] = hn::MulAdd(cosine, value, sum[c][2 * m]);
                    if (m > 0) {
                        sum[c][2 * m + 1] = hn::MulAdd(sine, value, sum[c][2 * m + 1]);
                    }
                }
            }
        }
        HWY_UNROLL(64)
        for (int i = 0; i < 2 * Order; ++i) {
            HWY_UNROLL(4)
            for (int c = 0; c < 3; ++c) {
                sums[3 * i + c] += static_cast<double>(hn::GetLane(hn::SumOfLanes(d, sum[c][i])));
            }
        }
    }
};

void row_kernel(int order, const float* row, std::size_t width, std::size_t span, const float* cosines,
                const float* sines, double* sums, std::size_t* bad) {
    for_order(order, RowSums{row, width, span, cosines, sines, sums, bad});
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(cube_kernel);
HWY_EXPORT(row_kernel);

Result<CubeProjector> CubeProjector::make(int size, int order, int supersampling) {
    assert(order >= 1 && order <= max_order);
    if (size < 1 || size > 16384) {
        return Error{"size is " + std::to_string(size), "cube map", "1 to 16384 pixels a side"};
    }
    if (supersampling < 1 || supersampling > 64) {
        return Error{"supersampling is " + std::to_string(supersampling), "cube map", "1 to 64"};
    }
    CubeProjector p;
    p.size_ = size;
    p.order_ = order;
    p.supersampling_ = supersampling;
    const int half = (size + 1) / 2;
    p.row_ = half == 8 ? 8 : padded(static_cast<std::size_t>(half)); // whole vectors: 8 rows of 8 are
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    const std::size_t plane = static_cast<std::size_t>(half) * p.row_;
    const bool compact = half >= 64 && supersampling == 1;
    p.table_.assign((compact ? 2 : 3 * count) * plane, 0.0F);
    p.centre_.assign(compact ? p.row_ : 0, 0.0F);
    const bool odd = size % 2 != 0;
    std::array<double, max_coefficients> y;
    for (int i = 0; i < half; ++i) {
        for (int j = 0; j < half; ++j) {
            // The cell from the middle outwards; on an odd size the middle ones are half cells of mirrored pixels.
            const double first = odd ? -1.0 : 0.0;
            const auto edge = [&](int k) { return std::max(0.0, (2.0 * k + first) / size); };
            if (compact) {
                const std::size_t at = static_cast<std::size_t>(i) * p.row_ + static_cast<std::size_t>(j);
                const double s = 0.5 * (edge(j) + edge(j + 1)), t = 0.5 * (edge(i) + edge(i + 1));
                p.table_[at] = static_cast<float>(1.0 / std::sqrt(1.0 + s * s + t * t));
                p.table_[plane + at] = static_cast<float>(cube_solid_angle(edge(j), edge(j + 1), edge(i), edge(i + 1)));
                p.centre_[static_cast<std::size_t>(j)] = static_cast<float>(s);
                continue;
            }
            std::array<std::array<double, max_coefficients>, 3> integral{};
            for (int a = 0; a < supersampling; ++a) {
                for (int b = 0; b < supersampling; ++b) {
                    const double dt = (edge(i + 1) - edge(i)) / supersampling,
                                 ds = (edge(j + 1) - edge(j)) / supersampling;
                    const double t0 = edge(i) + a * dt, s0 = edge(j) + b * ds;
                    const double weight = cube_solid_angle(s0, s0 + ds, t0, t0 + dt);
                    const double s = s0 + 0.5 * ds, t = t0 + 0.5 * dt;
                    const double scale = 1.0 / std::sqrt(1.0 + s * s + t * t);
                    const glm::dvec3 directions[3] = {
                        {scale, t * scale, s * scale}, {s * scale, scale, t * scale}, {s * scale, t * scale, scale}};
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        evaluate_basis(order, directions[axis], y);
                        for (std::size_t k = 0; k < count; ++k) {
                            integral[axis][k] += weight * y[k];
                        }
                    }
                }
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (std::size_t k = 0; k < count; ++k) {
                    p.table_[(axis * count + k) * plane + static_cast<std::size_t>(i) * p.row_ +
                             static_cast<std::size_t>(j)] = static_cast<float>(integral[axis][k]);
                }
            }
        }
    }
    return p;
}

Result<std::size_t> CubeProjector::project(const CubeMap& map, std::span<glm::vec3> out) const {
    const auto count = static_cast<std::size_t>(coefficient_count(order_));
    assert(out.size() >= count && map.size == size_);
    if (auto error = detail::check(map, supersampling_)) {
        return *error;
    }
    std::array<double, 3 * max_coefficients> sums{};
    std::size_t bad = 0;
    HWY_DYNAMIC_DISPATCH(cube_kernel)
    (map, order_, detail::CubeTables{table_.data(), centre_.empty() ? nullptr : centre_.data(), row_}, sums.data(),
     &bad);
    for (std::size_t i = 0; i < count; ++i) {
        out[i] = glm::vec3(sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]);
    }
    if (bad > 0 && size_ % 2 != 0) { // the middle ones were met several times: count again
        bad = 0;
        for (const std::span<const float> face : map.faces) {
            for (std::size_t i = 0; i < face.size(); i += 3) {
                bad += std::isfinite(face[i]) && std::isfinite(face[i + 1]) && std::isfinite(face[i + 2]) ? 0 : 1;
            }
        }
    }
    return bad;
}

Result<std::size_t> project(const CubeMap& map, int order, std::span<glm::vec3> out, int supersampling) {
    if (auto error = detail::check(map, supersampling)) {
        return *error;
    }
    const Result<CubeProjector> projector = CubeProjector::make(map.size, order, supersampling);
    return projector ? projector->project(map, out) : Result<std::size_t>(projector.error());
}

Result<std::size_t> project(const EquirectMap& map, int order, std::span<glm::vec3> out) {
    const auto count = static_cast<std::size_t>(coefficient_count(order));
    assert(order >= 1 && order <= max_order && out.size() >= count);
    if (auto error = detail::check(map, 1)) {
        return *error;
    }
    const auto width = static_cast<std::size_t>(map.width);
    const std::size_t span = width % 2 == 0 ? width / 2 : width;
    const std::size_t stride = padded(span);
    // The integral of cos(m phi) over a pixel is its value in the middle times 2 sin(m step / 2) / m.
    const double step = two_pi / map.width;
    std::vector<float> cosines(static_cast<std::size_t>(order) * stride), sines(cosines.size());
    for (int m = 0; m < order; ++m) {
        const double factor = m == 0 ? step : 2.0 * std::sin(0.5 * m * step) / m;
        for (std::size_t j = 0; j < span; ++j) {
            const double phi = step * (static_cast<double>(j) + 0.5) - pi;
            cosines[static_cast<std::size_t>(m) * stride + j] = static_cast<float>(factor * std::cos(m * phi));
            sines[static_cast<std::size_t>(m) * stride + j] = static_cast<float>(factor * std::sin(m * phi));
        }
    }
    std::vector<double> nodes, weights;
    gauss_legendre(map.height >= 32 ? 5 : 24, nodes, weights);
    std::array<double, 3 * max_coefficients> sums{};
    std::array<double, 6 * max_order> fourier{};
    std::size_t bad = 0;
    for (int row = 0; row < map.height; ++row) {
        HWY_DYNAMIC_DISPATCH(row_kernel)
        (order, map.pixels.data() + 3 * width * static_cast<std::size_t>(row), width, span, cosines.data(),
         sines.data(), fourier.data(), &bad);
        // The integral of the latitude part over the row, in the polar angle, where it is a trigonometric polynomial.
        const double middle = pi * (row + 0.5) / map.height, half = 0.5 * pi / map.height;
        std::array<double, max_coefficients> integral{}, y;
        for (std::size_t k = 0; k < nodes.size(); ++k) {
            const double theta = middle + half * nodes[k];
            evaluate_basis(order, glm::dvec3(std::sin(theta), 0.0, std::cos(theta)), y);
            for (int l = 0; l < order; ++l) {
                for (int m = 0; m <= l; ++m) {
                    const auto i = static_cast<std::size_t>(index(l, m));
                    integral[i] += half * weights[k] * std::sin(theta) * y[i];
                }
            }
        }
        for (int l = 0; l < order; ++l) {
            for (int m = -l; m <= l; ++m) {
                const auto am = static_cast<std::size_t>(m < 0 ? -m : m);
                const double latitude = integral[static_cast<std::size_t>(index(l, static_cast<int>(am)))];
                for (std::size_t c = 0; c < 3; ++c) {
                    sums[3 * static_cast<std::size_t>(index(l, m)) + c] +=
                        latitude * fourier[3 * (2 * am + (m < 0 ? 1 : 0)) + c];
                }
            }
        }
    }
    for (std::size_t i = 0; i < count; ++i) {
        out[i] = glm::vec3(sums[3 * i], sums[3 * i + 1], sums[3 * i + 2]);
    }
    return bad;
}

} // namespace alpenglow::sh
#endif
