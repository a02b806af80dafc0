// Rotation of many vectors: by one matrix, each by its own quaternion, and about z.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_rotate.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include "simd-inl.h"

#include "rotation_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

// One band: blocks of four vectors of items by a few rows of the matrix stay in registers, so that each element is
// broadcast once for the four. `in` is not `out`.
template <int L, int Rows>
HWY_INLINE void rotate_rows(const float* matrix, const float* in, std::size_t in_stride, float* out,
                            std::size_t out_stride) {
    constexpr int width = 2 * L + 1;
    V sum[Rows][4];
    HWY_UNROLL(16)
    for (int n = 0; n < width; ++n) {
        const float* source = in + static_cast<std::size_t>(n) * in_stride;
        V e[Rows];
        HWY_UNROLL(4)
        for (int m = 0; m < Rows; ++m) {
            e[m] = hn::Set(d, matrix[m * width + n]);
        }
        HWY_UNROLL(4)
        for (int block = 0; block < 4; ++block) {
            const V s = load(source + static_cast<std::size_t>(block) * lanes());
            HWY_UNROLL(4)
            for (int m = 0; m < Rows; ++m) {
                sum[m][block] = n == 0 ? hn::Mul(e[m], s) : hn::MulAdd(e[m], s, sum[m][block]);
            }
        }
    }
    HWY_UNROLL(4)
    for (int m = 0; m < Rows; ++m) {
        HWY_UNROLL(4)
        for (int block = 0; block < 4; ++block) {
            store(sum[m][block],
                  out + static_cast<std::size_t>(m) * out_stride + static_cast<std::size_t>(block) * lanes());
        }
    }
}

template <int L>
HWY_INLINE void rotate_band(const float* matrix, const float* in, std::size_t in_stride, float* out,
                            std::size_t out_stride, std::size_t count) {
    constexpr int width = 2 * L + 1;
    HWY_ALIGN float copy[width * 4 * hn::MaxLanes(d)];
    std::size_t k = 0;
    // Sixteen lanes fetch an element with the operation that uses it.
    for (; hn::MaxLanes(d) < 16 && k + 4 * lanes() <= padded(count); k += 4 * lanes()) {
        const float* source = in + k;
        std::size_t stride = in_stride;
        if (in == out) {
            stride = 4 * lanes();
            for (std::size_t n = 0; n < static_cast<std::size_t>(width); ++n) {
                std::copy_n(source + n * in_stride, stride, copy + n * stride);
            }
            source = copy;
        }
        // Three rows at a time, and twos where that leaves fewer.
        constexpr int threes = (width % 3 == 1 && width > 1 ? width - 4 : width - width % 3);
        constexpr int rest = width % 3 == 0 || width == 1 ? 1 : 2;
        for (int m = 0; m < width; m += m < threes ? 3 : rest) {
            const float* rows = matrix + m * width;
            float* target = out + static_cast<std::size_t>(m) * out_stride + k;
            if (m < threes) {
                rotate_rows<L, 3>(rows, source, stride, target, out_stride);
            } else {
                rotate_rows<L, rest>(rows, source, stride, target, out_stride);
            }
        }
    }
    for (; k < count; k += lanes()) {
        V source[width];
        HWY_UNROLL(64)
        for (int n = 0; n < width; ++n) {
            source[n] = load(in + static_cast<std::size_t>(n) * in_stride + k);
        }
        const float* element = matrix;
        for (int m = 0; m < width; ++m, element += width) {
            V sum = hn::Mul(source[0], hn::Set(d, element[0]));
            HWY_UNROLL(64)
            for (int n = 1; n < width; ++n) {
                sum = hn::MulAdd(source[n], hn::Set(d, element[n]), sum);
            }
            store(sum, out + static_cast<std::size_t>(m) * out_stride + k);
        }
    }
}

template <int Order, int L>
HWY_INLINE void rotate_bands(const float* matrix, ConstBatch in, Batch out) {
    if constexpr (L < Order) {
        constexpr auto first = static_cast<std::size_t>(L * L);
        rotate_band<L>(matrix + Rotation::band_offset(L), in.row(first), in.stride, out.row(first), out.stride,
                       in.count);
        rotate_bands<Order, L + 1>(matrix, in, out);
    }
}

struct RotateShared {
    const float* matrix;
    ConstBatch in;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        rotate_bands<Order, 0>(matrix, in, out);
    }
};

// A rotation about z of the bands 1 .. Order-1 in registers: the pair (m, -m) turns by m times the angle.
template <int Order>
HWY_INLINE void turn(const V (&c)[max_order], const V (&s)[max_order], V* v) {
    HWY_UNROLL(64)
    for (int m = 1; m < Order; ++m) {
        HWY_UNROLL(64)
        for (int l = m; l < Order; ++l) {
            const V a = v[index(l, m)];
            const V b = v[index(l, -m)];
            v[index(l, m)] = hn::MulSub(a, c[m], hn::Mul(b, s[m]));
            v[index(l, -m)] = hn::MulAdd(a, s[m], hn::Mul(b, c[m]));
        }
    }
}

// cos and sin of m times the angle by products of short depth.
template <int Order, class Vec>
HWY_INLINE void multiples(Vec c1, Vec s1, Vec (&c)[max_order], Vec (&s)[max_order]) {
    if constexpr (Order > 1) {
        c[1] = c1;
        s[1] = s1;
        HWY_UNROLL(64)
        for (int m = 2; m < Order; ++m) {
            const int a = m / 2, b = m - a;
            c[m] = hn::MulSub(c[a], c[b], hn::Mul(s[a], s[b]));
            s[m] = hn::MulAdd(s[a], c[b], hn::Mul(c[a], s[b]));
        }
    }
}

// The reflection y <-> z of one band: a constant symmetric matrix, three quarters of it zero.
template <int L, int Row, int Column>
HWY_INLINE V swap_row(const V* source, V sum, bool& started) {
    constexpr double element = detail::swap_tables.element[Rotation::band_offset(L) + Row * (2 * L + 1) + Column];
    if constexpr (element != 0.0) {
        sum = started ? hn::MulAdd(source[Column], constant(element), sum) : hn::Mul(source[Column], constant(element));
        started = true;
    }
    if constexpr (Column < 2 * L) {
        return swap_row<L, Row, Column + 1>(source, sum, started);
    } else {
        return sum;
    }
}

template <int L, int Row>
HWY_INLINE void swap_rows(const V* source, V* out) {
    bool started = false;
    out[Row] = swap_row<L, Row, 0>(source, source[0], started);
    if constexpr (Row < 2 * L) {
        swap_rows<L, Row + 1>(source, out);
    }
}

template <int Order, int L>
HWY_INLINE void swap_yz(V* v) {
    if constexpr (L < Order) {
        V source[2 * L + 1];
        HWY_UNROLL(64)
        for (int i = 0; i < 2 * L + 1; ++i) {
            source[i] = v[L * L + i];
        }
        swap_rows<L, 0>(source, v + L * L);
        swap_yz<Order, L + 1>(v);
    }
}

// The angles of a block of rotations, as cosines and sines of their multiples.
//
// R = Rz(alpha) Ry(beta) Rz(gamma), with Ry(beta) = S Rz(-beta) S and S the reflection y <-> z (Pinchon and Hoggan
// 2007). The angles never appear: with q = (w, x, y, z), w + iz = cos(beta/2) e^(i(alpha+gamma)/2) and y - ix =
// sin(beta/2) e^(i(alpha-gamma)/2), so that products of the two, normalised, are e^(i alpha) and e^(i gamma). Nothing
// cancels, whatever the tilt. In double, since the multiples would cost float a digit.
struct Angles {
    static constexpr std::size_t items = 64;
    enum { gamma, minus_beta, alpha };
    alignas(64) float cosine[3][max_order][items];
    alignas(64) float sine[3][max_order][items];
};

using DD = hn::CappedTag<double, 16>;
using DF = hn::Rebind<float, DD>; // as many floats as a vector of doubles has lanes
using VD = hn::Vec<DD>;

// One vector of floats from those of the vectors of doubles that it takes.
template <class Half>
HWY_INLINE Half join(const Half (&parts)[1]) {
    return parts[0];
}
#if HWY_TARGET != HWY_SCALAR
template <class Half>
HWY_INLINE V join(const Half (&parts)[2]) {
    return hn::Combine(d, parts[1], parts[0]);
}
#endif

// Orders up to 3 by the 3 x 3 matrix R itself: b -> R b, and A -> R A R^T for the quadratic part, a symmetric matrix
// without trace. R is found in double: its own rounding would double the error.
struct Matrix {
    V r[3][3];
};
HWY_INLINE Matrix matrix_of(ConstBatch quaternions, std::size_t k) {
    constexpr DD dd;
    constexpr DF df;
    using Half = hn::Vec<DF>;
    constexpr std::size_t parts = hn::MaxLanes(d) / hn::MaxLanes(dd);
    Half entry[3][3][parts];
    for (std::size_t at = 0; at < parts; ++at) {
        const auto part = [&](std::size_t i) HWY_ATTR {
            return hn::PromoteTo(dd, hn::LoadU(df, quaternions.row(i) + k + at * hn::Lanes(dd)));
        };
        const auto put = [&](VD v, int row, int column) HWY_ATTR { entry[row][column][at] = hn::DemoteTo(df, v); };
        const VD x = part(0), y = part(1), z = part(2), w = part(3), one = hn::Set(dd, 1.0), two = hn::Set(dd, 2.0);
        const VD sum = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::MulAdd(z, z, hn::Mul(w, w))));
        // 1 / sum by Newton from 2 - sum: the quaternion is of unit length to 1e-3 at worst.
        const VD first = hn::Sub(two, sum), inverse = hn::Mul(first, hn::NegMulAdd(sum, first, two));
        const VD scale = hn::Add(inverse, inverse);
        const VD sx = hn::Mul(scale, x), sy = hn::Mul(scale, y), sz = hn::Mul(scale, z);
        const VD wx = hn::Mul(sx, w), wy = hn::Mul(sy, w), wz = hn::Mul(sz, w);
        const VD not_x = hn::NegMulAdd(sx, x, one), zz = hn::Mul(sz, z);
        put(hn::NegMulAdd(sy, y, hn::Sub(one, zz)), 0, 0);
        put(hn::Sub(not_x, zz), 1, 1);
        put(hn::NegMulAdd(sy, y, not_x), 2, 2);
        put(hn::MulSub(sx, y, wz), 0, 1);
        put(hn::MulAdd(sx, y, wz), 1, 0);
        put(hn::MulAdd(sx, z, wy), 0, 2);
        put(hn::MulSub(sx, z, wy), 2, 0);
        put(hn::MulSub(sy, z, wx), 1, 2);
        put(hn::MulAdd(sy, z, wx), 2, 1);
    }
    Matrix m;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            m.r[i][j] = join(entry[i][j]);
        }
    }
    return m;
}

template <int Order>
HWY_INLINE void rotate_quadratic(const Matrix& m, ConstBatch in, std::size_t k, Batch out) {
    const auto row = [&](std::size_t i) HWY_ATTR { return load(in.row(i) + k); };
    const auto dot = [](const V(&a)[3], V x, V y, V z)
                         HWY_ATTR { return hn::MulAdd(a[0], x, hn::MulAdd(a[1], y, hn::Mul(a[2], z))); };
    const auto& r = m.r;
    const V x = row(3), y = row(1), z = hn::Neg(row(2)); // -b
    V f[Order * Order];
    f[0] = row(0);
    f[1] = dot(r[1], x, y, z);
    f[2] = hn::Neg(dot(r[2], x, y, z));
    f[3] = dot(r[0], x, y, z);
    if constexpr (Order == 3) {
        const V third_root = constant(0.57735026918962576);
        const V e = hn::Mul(third_root, row(6)), g = row(8), zz = hn::Add(e, e);
        const V xx = hn::Sub(g, e), yy = hn::Neg(hn::Add(g, e)), xy = row(4), yz = hn::Neg(row(5)),
                xz = hn::Neg(row(7));
        // A R^T, row by row of R, then what is needed of R times it.
        V t[3][3];
        HWY_UNROLL(4)
        for (int i = 0; i < 3; ++i) {
            t[i][0] = dot(r[i], xx, xy, xz);
            t[i][1] = dot(r[i], xy, yy, yz);
            t[i][2] = dot(r[i], xz, yz, zz);
        }
        f[4] = dot(r[0], t[1][0], t[1][1], t[1][2]);
        f[5] = hn::Neg(dot(r[1], t[2][0], t[2][1], t[2][2]));
        f[6] = hn::Mul(constant(0.86602540378443865), dot(r[2], t[2][0], t[2][1], t[2][2]));
        f[7] = hn::Neg(dot(r[0], t[2][0], t[2][1], t[2][2]));
        // (xx - yy) / 2, from xx and zz: xx + yy = -zz.
        const V new_xx = dot(r[0], t[0][0], t[0][1], t[0][2]), new_zz = dot(r[2], t[2][0], t[2][1], t[2][2]);
        f[8] = hn::MulAdd(constant(0.5), new_zz, new_xx);
    }
    HWY_UNROLL(16)
    for (int i = 0; i < Order * Order; ++i) {
        store(f[i], out.row(static_cast<std::size_t>(i)) + k);
    }
}

template <int Order>
HWY_INLINE void store_multiples(VD c1, VD s1, Angles& angles, int which, std::size_t item) {
    constexpr DF df;
    VD c[max_order], s[max_order];
    multiples<Order>(c1, s1, c, s);
    HWY_UNROLL(64)
    for (int m = 1; m < Order; ++m) {
        hn::StoreU(hn::DemoteTo(df, c[m]), df, angles.cosine[which][m] + item);
        hn::StoreU(hn::DemoteTo(df, s[m]), df, angles.sine[which][m] + item);
    }
}

template <int Order>
HWY_INLINE void find_angles(ConstBatch quaternions, std::size_t begin, std::size_t end, Angles& angles) {
    constexpr DD dd;
    constexpr DF df;
    for (std::size_t k = begin; k < end; k += hn::Lanes(dd)) {
        VD px = hn::PromoteTo(dd, hn::LoadU(df, quaternions.row(3) + k));
        VD py = hn::PromoteTo(dd, hn::LoadU(df, quaternions.row(2) + k)); // w + iz
        VD mx = hn::PromoteTo(dd, hn::LoadU(df, quaternions.row(1) + k));
        VD my = hn::Neg(hn::PromoteTo(dd, hn::LoadU(df, quaternions.row(0) + k))); // y - ix
        VD p2 = hn::MulAdd(px, px, hn::Mul(py, py));
        VD m2 = hn::MulAdd(mx, mx, hn::Mul(my, my));
        const VD one = hn::Set(dd, 1.0), zero = hn::Zero(dd);
        const VD sum = hn::Add(p2, m2);
        // 1 / sum by Newton from 2 - sum: the quaternion is of unit length to 1e-3 at worst.
        const VD two = hn::Set(dd, 2.0), first = hn::Sub(two, sum);
        const VD inverse = hn::Mul(first, hn::NegMulAdd(sum, first, two));
        const VD cos_beta = hn::Mul(hn::Sub(p2, m2), inverse);
        // Where one of the two vanishes, its azimuth means nothing, and any will do.
        const auto p_fine = hn::Gt(p2, hn::Set(dd, 1e-200)), m_fine = hn::Gt(m2, hn::Set(dd, 1e-200));
        px = hn::IfThenElse(p_fine, px, one);
        py = hn::IfThenElse(p_fine, py, zero);
        p2 = hn::IfThenElse(p_fine, p2, one);
        mx = hn::IfThenElse(m_fine, mx, one);
        my = hn::IfThenElse(m_fine, my, zero);
        m2 = hn::IfThenElse(m_fine, m2, one);
        const VD length = hn::Sqrt(hn::Mul(p2, m2));
        const VD sin_beta = hn::IfThenElse(hn::And(p_fine, m_fine), hn::Mul(hn::Add(length, length), inverse), zero);
        const VD scale = hn::Div(one, length);
        px = hn::Mul(px, scale);
        py = hn::Mul(py, scale);
        const std::size_t item = k - begin;
        // gamma: (w + iz) conj(y - ix); alpha: (w + iz) (y - ix)
        store_multiples<Order>(hn::MulAdd(px, mx, hn::Mul(py, my)), hn::MulSub(py, mx, hn::Mul(px, my)), angles,
                               Angles::gamma, item);
        store_multiples<Order>(cos_beta, hn::Neg(sin_beta), angles, Angles::minus_beta, item);
        store_multiples<Order>(hn::MulSub(px, mx, hn::Mul(py, my)), hn::MulAdd(px, my, hn::Mul(py, mx)), angles,
                               Angles::alpha, item);
    }
}

struct RotateOwn {
    ConstBatch quaternions, in;
    Batch out;

    template <int Order>
    static HWY_INLINE void turn_by(const Angles& angles, int which, std::size_t item, V* v) {
        V c[max_order], s[max_order];
        HWY_UNROLL(64)
        for (int m = 1; m < Order; ++m) {
            c[m] = load(angles.cosine[which][m] + item);
            s[m] = load(angles.sine[which][m] + item);
        }
        turn<Order>(c, s, v);
    }

    template <int Order>
    HWY_INLINE void run() const {
        if constexpr (Order == 2 || Order == 3) {
            for (std::size_t k = 0; k < in.count; k += lanes()) {
                rotate_quadratic<Order>(matrix_of(quaternions, k), in, k, out);
            }
            return;
        }
        Angles angles;
        for (std::size_t begin = 0; begin < in.count; begin += Angles::items) {
            const std::size_t end = HWY_MIN(begin + Angles::items, padded(in.count));
            find_angles<Order>(quaternions, begin, end, angles);
            for (std::size_t k = begin; k < end; k += lanes()) {
                V v[static_cast<std::size_t>(Order * Order)];
                HWY_UNROLL(64)
                for (int i = 0; i < Order * Order; ++i) {
                    v[i] = load(in.row(static_cast<std::size_t>(i)) + k);
                }
                turn_by<Order>(angles, Angles::gamma, k - begin, v);
                swap_yz<Order, 1>(v);
                turn_by<Order>(angles, Angles::minus_beta, k - begin, v);
                swap_yz<Order, 1>(v);
                turn_by<Order>(angles, Angles::alpha, k - begin, v);
                HWY_UNROLL(64)
                for (int i = 0; i < Order * Order; ++i) {
                    store(v[i], out.row(static_cast<std::size_t>(i)) + k);
                }
            }
        }
    }
};

struct TurnShared {
    const float* cos_m;
    const float* sin_m;
    ConstBatch in;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        for (int l = 0; l < Order; ++l) {
            for (int m = 0; m <= l; ++m) {
                const auto plus = static_cast<std::size_t>(index(l, m)), minus = static_cast<std::size_t>(index(l, -m));
                const V c = hn::Set(d, cos_m[m]), s = hn::Set(d, sin_m[m]);
                for (std::size_t k = 0; k < in.count; k += lanes()) {
                    const V a = load(in.row(plus) + k);
                    if (m == 0) {
                        store(a, out.row(plus) + k);
                        continue;
                    }
                    const V b = load(in.row(minus) + k);
                    store(hn::MulSub(a, c, hn::Mul(b, s)), out.row(plus) + k);
                    store(hn::MulAdd(a, s, hn::Mul(b, c)), out.row(minus) + k);
                }
            }
        }
    }
};

struct TurnOwn {
    ConstBatch cos_sin, in;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        for (std::size_t k = 0; k < in.count; k += lanes()) {
            V c[max_order], s[max_order], v[static_cast<std::size_t>(Order * Order)];
            HWY_UNROLL(64)
            for (int i = 0; i < Order * Order; ++i) {
                v[i] = load(in.row(static_cast<std::size_t>(i)) + k);
            }
            multiples<Order>(load(cos_sin.row(0) + k), load(cos_sin.row(1) + k), c, s);
            turn<Order>(c, s, v);
            HWY_UNROLL(64)
            for (int i = 0; i < Order * Order; ++i) {
                store(v[i], out.row(static_cast<std::size_t>(i)) + k);
            }
        }
    }
};

void rotate_shared_kernel(int order, const float* matrix, ConstBatch in, Batch out) {
    for_order(order, RotateShared{matrix, in, out});
}
void rotate_own_kernel(int order, ConstBatch quaternions, ConstBatch in, Batch out) {
    for_order(order, RotateOwn{quaternions, in, out});
}
void turn_shared_kernel(int order, const float* cos_m, const float* sin_m, ConstBatch in, Batch out) {
    for_order(order, TurnShared{cos_m, sin_m, in, out});
}
void turn_own_kernel(int order, ConstBatch cos_sin, ConstBatch in, Batch out) {
    for_order(order, TurnOwn{cos_sin, in, out});
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(rotate_shared_kernel);
HWY_EXPORT(rotate_own_kernel);
HWY_EXPORT(turn_shared_kernel);
HWY_EXPORT(turn_own_kernel);

void rotate(const Rotation& rotation, ConstBatch in, Batch out) {
    assert(in.count == out.count);
    std::array<float, Rotation::band_offset(max_order)> matrix;
    for (std::size_t i = 0; i < rotation.elements().size(); ++i) {
        matrix[i] = static_cast<float>(rotation.elements()[i]);
    }
    HWY_DYNAMIC_DISPATCH(rotate_shared_kernel)(rotation.order(), matrix.data(), in, out);
}

void rotate(int order, ConstBatch quaternions, ConstBatch in, Batch out) {
    assert(order >= 1 && order <= max_order && in.count == out.count && quaternions.count == in.count);
    HWY_DYNAMIC_DISPATCH(rotate_own_kernel)(order, quaternions, in, out);
}

void rotate_z(int order, double angle_rad, ConstBatch in, Batch out) {
    assert(order >= 1 && order <= max_order && in.count == out.count);
    std::array<float, max_order> cos_m, sin_m;
    for (int m = 0; m < max_order; ++m) {
        cos_m[static_cast<std::size_t>(m)] = static_cast<float>(std::cos(m * angle_rad));
        sin_m[static_cast<std::size_t>(m)] = static_cast<float>(std::sin(m * angle_rad));
    }
    HWY_DYNAMIC_DISPATCH(turn_shared_kernel)(order, cos_m.data(), sin_m.data(), in, out);
}

void rotate_z(int order, ConstBatch cos_sin, ConstBatch in, Batch out) {
    assert(order >= 1 && order <= max_order && in.count == out.count && cos_sin.count == in.count);
    HWY_DYNAMIC_DISPATCH(turn_own_kernel)(order, cos_sin, in, out);
}

} // namespace alpenglow::sh
#endif
