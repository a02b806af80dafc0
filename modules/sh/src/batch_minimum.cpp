// Certified minima of coefficient vectors of orders 4 to 6: branch and bound on the faces of a cube as in dering.cpp,
// with many cells of one vector at a time, and a bound of third order.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_minimum.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include <alpenglow/sh/dering_batch.hpp>

#include "simd-inl.h"

#include "folded.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

using detail::Folded;

// f restricted to the sphere about a point n: value, gradient and Hessian in an orthonormal frame u, v of the tangent
// plane. With F any polynomial that is f on the sphere, Hess(u, v) = u^T F'' v - (n . F') u . v.
struct Local {
    V value, gu, gv, huu, huv, hvv;
    V u[3], v[3];
};

// p, its derivative and half its second derivative at z, by Horner.
template <int Degree>
HWY_INLINE void horner(const float* c, V z, V (&p)[3]) {
    p[0] = hn::Set(d, c[Degree]);
    p[1] = p[2] = hn::Zero(d);
    HWY_UNROLL(16)
    for (int k = Degree - 1; k >= 0; --k) {
        p[2] = hn::MulAdd(p[2], z, p[1]);
        p[1] = hn::MulAdd(p[1], z, p[0]);
        p[0] = hn::MulAdd(p[0], z, hn::Set(d, c[k]));
    }
}

struct Derivatives {
    V f, x, y, z, xx, xy, xz, yz, zz; // yy = -xx
};

// The part of (x + iy)^m and up; (re, im), (re1, im1), (re2, im2) are (-(x + iy)) to the powers m, m - 1, m - 2.
template <int Order, int M_>
HWY_INLINE void add_terms(const Folded& folded, V x, V y, V z, V re, V im, V re1, V im1, V re2, V im2, Derivatives& s) {
    if constexpr (M_ < Order) {
        V c[3], q[3];
        horner<Order - 1 - M_>(folded.cosine[M_], z, c);
        horner<Order - 1 - M_>(folded.sine[M_], z, q);
        const V minus_m = constant(-M_);
        s.f = hn::MulAdd(c[0], re, hn::MulAdd(q[0], im, s.f));
        s.z = hn::MulAdd(c[1], re, hn::MulAdd(q[1], im, s.z));
        s.zz = hn::MulAdd(hn::Add(c[2], c[2]), re, hn::MulAdd(hn::Add(q[2], q[2]), im, s.zz));
        s.x = hn::MulAdd(minus_m, hn::MulAdd(c[0], re1, hn::Mul(q[0], im1)), s.x);
        s.y = hn::MulAdd(minus_m, hn::MulSub(q[0], re1, hn::Mul(c[0], im1)), s.y);
        s.xz = hn::MulAdd(minus_m, hn::MulAdd(c[1], re1, hn::Mul(q[1], im1)), s.xz);
        s.yz = hn::MulAdd(minus_m, hn::MulSub(q[1], re1, hn::Mul(c[1], im1)), s.yz);
        if constexpr (M_ >= 2) {
            const V pairs = constant(M_ * (M_ - 1));
            s.xx = hn::MulAdd(pairs, hn::MulAdd(c[0], re2, hn::Mul(q[0], im2)), s.xx);
            s.xy = hn::MulAdd(pairs, hn::MulSub(q[0], re2, hn::Mul(c[0], im2)), s.xy);
        }
        const V next_re = hn::MulSub(y, im, hn::Mul(x, re)), next_im = hn::Neg(hn::MulAdd(x, im, hn::Mul(y, re)));
        add_terms<Order, M_ + 1>(folded, x, y, z, next_re, next_im, re, im, re1, im1, s);
    }
}

template <int Order>
HWY_INLINE Local look_around(const Folded& folded, V x, V y, V z) {
    const V zero = hn::Zero(d), one = constant(1.0);
    V zonal[3];
    horner<Order - 1>(folded.cosine[0], z, zonal);
    Derivatives s{zonal[0], zero, zero, zonal[1], zero, zero, zero, zero, hn::Add(zonal[2], zonal[2])};
    add_terms<Order, 1>(folded, x, y, z, hn::Neg(x), hn::Neg(y), one, zero, zero, zero, s);
    // A frame (Duff et al. 2017).
    Local at;
    const V sign = hn::CopySign(one, z), k = hn::Neg(hn::Div(one, hn::Add(sign, z))), xy = hn::Mul(hn::Mul(x, y), k);
    at.u[0] = hn::MulAdd(hn::Mul(sign, x), hn::Mul(x, k), one);
    at.u[1] = hn::Mul(sign, xy);
    at.u[2] = hn::Neg(hn::Mul(sign, x));
    at.v[0] = xy;
    at.v[1] = hn::MulAdd(hn::Mul(y, y), k, sign);
    at.v[2] = hn::Neg(y);
    const auto dot = [](const V(&a)[3], V bx, V by, V bz)
                         HWY_ATTR { return hn::MulAdd(a[0], bx, hn::MulAdd(a[1], by, hn::Mul(a[2], bz))); };
    const auto times = [&](const V(&a)[3], V(&out)[3]) HWY_ATTR {
        out[0] = dot(a, s.xx, s.xy, s.xz);
        out[1] = dot(a, s.xy, hn::Neg(s.xx), s.yz);
        out[2] = dot(a, s.xz, s.yz, s.zz);
    };
    V hu[3], hv[3];
    times(at.u, hu);
    times(at.v, hv);
    const V radial = hn::MulAdd(x, s.x, hn::MulAdd(y, s.y, hn::Mul(z, s.z)));
    at.value = s.f;
    at.gu = dot(at.u, s.x, s.y, s.z);
    at.gv = dot(at.v, s.x, s.y, s.z);
    at.huu = hn::Sub(dot(at.u, hu[0], hu[1], hu[2]), radial);
    at.huv = dot(at.v, hu[0], hu[1], hu[2]);
    at.hvv = hn::Sub(dot(at.v, hv[0], hv[1], hv[2]), radial);
    return at;
}

template <int Order, int M_>
HWY_INLINE V value_terms(const Folded& folded, V x, V y, V z, V re, V im, V sum) {
    if constexpr (M_ < Order) {
        V c = hn::Set(d, folded.cosine[M_][Order - 1 - M_]), q = hn::Set(d, folded.sine[M_][Order - 1 - M_]);
        HWY_UNROLL(16)
        for (int k = Order - 2 - M_; k >= 0; --k) {
            c = hn::MulAdd(c, z, hn::Set(d, folded.cosine[M_][k]));
            q = hn::MulAdd(q, z, hn::Set(d, folded.sine[M_][k]));
        }
        sum = hn::MulAdd(re, c, hn::MulAdd(im, q, sum));
        const V next_re = hn::MulSub(y, im, hn::Mul(x, re)), next_im = hn::Neg(hn::MulAdd(x, im, hn::Mul(y, re)));
        return value_terms<Order, M_ + 1>(folded, x, y, z, next_re, next_im, sum);
    }
    return sum;
}
template <int Order>
HWY_INLINE V value_at(const Folded& folded, V x, V y, V z) {
    return value_terms<Order, 0>(folded, x, y, z, constant(1.0), hn::Zero(d), hn::Zero(d));
}

// The best point so far, lane by lane.
struct Best {
    V value, x, y, z;
    HWY_INLINE void offer(V v, V px, V py, V pz) {
        const M better = hn::Lt(v, value);
        value = hn::IfThenElse(better, v, value);
        x = hn::IfThenElse(better, px, x);
        y = hn::IfThenElse(better, py, y);
        z = hn::IfThenElse(better, pz, z);
    }
};

// Cells of one size, face by face: centres u, v on the face.
struct Level {
    std::array<std::vector<float>, 6> u, v, value;
    [[nodiscard]] std::size_t size() const {
        std::size_t n = 0;
        for (const std::vector<float>& face : u) {
            n += face.size();
        }
        return n;
    }
    void clear() {
        for (std::size_t face = 0; face < 6; ++face) {
            u[face].clear();
            v[face].clear();
        }
    }
};

// The point above (u, v) on a face.
HWY_INLINE void direction_on(std::size_t face, V u, V v, V& x, V& y, V& z) {
    const V one = constant(1.0);
    const V scale = hn::Div(one, hn::Sqrt(hn::MulAdd(u, u, hn::MulAdd(v, v, one))));
    const V w = face % 2 != 0 ? hn::Neg(scale) : scale;
    const V a = hn::Mul(u, scale), b = hn::Mul(v, scale);
    x = face < 2 ? w : a;
    y = face < 2 ? a : face < 4 ? w : b;
    z = face < 4 ? b : w;
}

// The greatest angle from the centre of a cell to its rim, from above: the gnomonic map shortens by sqrt(1 + rho^2).
HWY_INLINE V radius_of(V u, V v, float half) {
    const V h = hn::Set(d, half), zero = hn::Zero(d);
    const V near_u = hn::Max(hn::Sub(hn::Abs(u), h), zero), near_v = hn::Max(hn::Sub(hn::Abs(v), h), zero);
    const V rho2 = hn::MulAdd(near_u, near_u, hn::Mul(near_v, near_v));
    return hn::Mul(hn::Set(d, half * 1.4142137F), hn::Div(constant(1.0), hn::Sqrt(hn::Add(rho2, constant(1.0)))));
}

struct Search {
    Level level, next;
    std::vector<float> u, v; // the cells of one face that need a closer look
};

struct Found {
    float lower, value, x, y, z;
};

constexpr std::size_t most_cells = 40'000; // of a level, then the bound stays as it is
constexpr int first_cells = 8;             // along a face's edge

template <int Order>
HWY_INLINE Found find_minimum(const float* f, float tolerance, float floor, Search& search) {
    // Bernstein's inequality along great circles, band by band: bounds of the value, and of the second and third
    // derivative.
    double amplitude = 0.0, second = 0.0, third = 0.0;
    for (int l = 1; l < Order; ++l) {
        double sum = 0.0;
        for (int m = -l; m <= l; ++m) {
            sum += static_cast<double>(f[index(l, m)]) * static_cast<double>(f[index(l, m)]);
        }
        const double sup = std::sqrt(sum * (2.0 * l + 1.0) / (4.0 * pi));
        amplitude += sup;
        second += static_cast<double>(l * l) * sup;
        third += static_cast<double>(l * l * l) * sup;
    }
    const float mean = static_cast<float>(detail::basis_tables.seed[0]) * f[0];
    const auto rounding = static_cast<float>(2e-6 * (amplitude + std::abs(static_cast<double>(mean))));
    // Nothing below the floor is possible.
    if (static_cast<double>(mean) - amplitude - static_cast<double>(rounding) >= static_cast<double>(floor)) {
        return {mean - static_cast<float>(amplitude) - rounding, mean, 0.0F, 0.0F, 1.0F};
    }
    const Folded folded(Order, f);
    const std::size_t n = lanes();
    const V half_second = hn::Set(d, static_cast<float>(0.5 * second)),
            most_slope = hn::Set(d, static_cast<float>(second));
    const V sixth_third = hn::Set(d, static_cast<float>(third / 6.0));
    Best best{constant(std::numeric_limits<float>::max()), hn::Zero(d), hn::Zero(d), constant(1.0)};
    float dropped = std::numeric_limits<float>::max();
    Level* level = &search.level;
    Level* next = &search.next;
    level->clear();
    for (std::size_t face = 0; face < 6; ++face) {
        for (int i = 0; i < first_cells; ++i) {
            for (int j = 0; j < first_cells; ++j) {
                level->u[face].push_back(static_cast<float>(2 * i + 1) / first_cells - 1.0F);
                level->v[face].push_back(static_cast<float>(2 * j + 1) / first_cells - 1.0F);
            }
        }
    }
    for (float half = 1.0F / first_cells; level->size() > 0; half *= 0.5F) {
        const std::size_t cells = level->size();
        // Values first: a good upper bound drops more.
        for (std::size_t face = 0; face < 6; ++face) {
            std::vector<float>&us = level->u[face], &vs = level->v[face];
            const std::size_t count = us.size(), room = (count + n - 1) / n * n;
            us.resize(room, count > 0 ? us[count - 1] : 0.0F);
            vs.resize(room, count > 0 ? vs[count - 1] : 0.0F);
            level->value[face].resize(room);
            for (std::size_t k = 0; k < room; k += n) {
                V x, y, z;
                direction_on(face, load(&us[k]), load(&vs[k]), x, y, z);
                const V value = value_at<Order>(folded, x, y, z);
                best.offer(value, x, y, z);
                store(value, &level->value[face][k]);
            }
            us.resize(count);
            vs.resize(count);
        }
        const bool full = cells > most_cells;
        next->clear();
        for (std::size_t face = 0; face < 6; ++face) {
            const float found = hn::GetLane(hn::MinOfLanes(d, best.value));
            float threshold = std::min(found - std::max(tolerance * (mean - found), 2.0F * rounding), floor);
            const std::vector<float>&us = level->u[face], &vs = level->v[face], &values = level->value[face];
            search.u.clear();
            search.v.clear();
            for (std::size_t k = 0; k < us.size(); k += n) {
                // The last vector's lanes past the end repeat its last cell.
                std::array<float, 16> u, v, bound;
                for (std::size_t i = 0; i < n; ++i) {
                    const std::size_t cell = std::min(k + i, us.size() - 1);
                    u[i] = us[cell];
                    v[i] = vs[cell];
                }
                const V r = radius_of(load(u.data()), load(v.data()), half);
                store(hn::NegMulAdd(hn::Mul(half_second, r), r, load(&values[k])), bound.data());
                for (std::size_t i = 0; i < n && k + i < us.size(); ++i) {
                    if (bound[i] < threshold) {
                        search.u.push_back(u[i]);
                        search.v.push_back(v[i]);
                    } else {
                        dropped = std::min(dropped, bound[i]);
                    }
                }
            }
            const std::size_t count = search.u.size(), room = (count + n - 1) / n * n;
            search.u.resize(room, count > 0 ? search.u[count - 1] : 0.0F);
            search.v.resize(room, count > 0 ? search.v[count - 1] : 0.0F);
            for (std::size_t k = 0; k < room; k += n) {
                const V u = load(&search.u[k]), v = load(&search.v[k]), zero = hn::Zero(d), tiny = constant(1e-30);
                V x, y, z;
                direction_on(face, u, v, x, y, z);
                const Local at = look_around<Order>(folded, x, y, z);
                const V r = radius_of(u, v, half);
                // Where the minimum is in the cell, at a distance t <= r along e: f >= value + t g.e + t^2 e.H e / 2 -
                // third t^3 / 6; and of the quadratic on the disc the dual value at any s >= 0 with H + s > 0 is a
                // lower bound.
                const V slope = hn::Sqrt(hn::MulAdd(at.gu, at.gu, hn::Mul(at.gv, at.gv)));
                const V middle = hn::Mul(constant(0.5), hn::Add(at.huu, at.hvv));
                const V off = hn::Mul(constant(0.5), hn::Sub(at.huu, at.hvv));
                const V least = hn::Sub(middle, hn::Sqrt(hn::MulAdd(off, off, hn::Mul(at.huv, at.huv))));
                const V s = hn::Max(hn::Sub(hn::Div(slope, r), least), zero);
                const V a = hn::Add(at.huu, s), c = hn::Add(at.hvv, s);
                const V inverse = hn::Div(constant(1.0), hn::Max(hn::MulSub(a, c, hn::Mul(at.huv, at.huv)), tiny));
                V du = hn::Mul(hn::MulSub(at.huv, at.gv, hn::Mul(c, at.gu)), inverse);
                V dv = hn::Mul(hn::MulSub(at.huv, at.gu, hn::Mul(a, at.gv)), inverse);
                const V drop = hn::Max(hn::NegMulAdd(at.gu, du, hn::Neg(hn::Mul(at.gv, dv))), zero);
                const V loss = hn::MulAdd(hn::Mul(s, r), r, hn::Min(drop, hn::Mul(slope, r)));
                V bound = hn::NegMulAdd(constant(0.5), loss, at.value);
                bound = hn::NegMulAdd(hn::Mul(sixth_third, r), hn::Mul(r, r), bound);
                bound = hn::Max(bound, hn::NegMulAdd(hn::Mul(half_second, r), r, at.value));
                // Too steep for a stationary point.
                const M flat = hn::Le(slope, hn::MulAdd(most_slope, r, hn::Set(d, rounding)));
                // A step towards the minimum, for a better upper bound.
                du = hn::Min(hn::Max(du, hn::Neg(r)), r);
                dv = hn::Min(hn::Max(dv, hn::Neg(r)), r);
                const V px = hn::MulAdd(du, at.u[0], hn::MulAdd(dv, at.v[0], x));
                const V py = hn::MulAdd(du, at.u[1], hn::MulAdd(dv, at.v[1], y));
                const V pz = hn::MulAdd(du, at.u[2], hn::MulAdd(dv, at.v[2], z));
                const V scale =
                    hn::Div(constant(1.0), hn::Sqrt(hn::MulAdd(px, px, hn::MulAdd(py, py, hn::Mul(pz, pz)))));
                const V qx = hn::Mul(px, scale), qy = hn::Mul(py, scale), qz = hn::Mul(pz, scale);
                best.offer(value_at<Order>(folded, qx, qy, qz), qx, qy, qz);
                std::array<float, 16> bounds;
                store(hn::IfThenElse(flat, bound, constant(std::numeric_limits<float>::max())), bounds.data());
                const float now = hn::GetLane(hn::MinOfLanes(d, best.value));
                threshold = std::min(now - std::max(tolerance * (mean - now), 2.0F * rounding), floor);
                for (std::size_t i = 0; i < n && k + i < count; ++i) {
                    if (bounds[i] >= threshold || full) {
                        dropped = std::min(dropped, bounds[i]);
                        continue;
                    }
                    for (const float su : {-0.5F, 0.5F}) {
                        for (const float sv : {-0.5F, 0.5F}) {
                            next->u[face].push_back(search.u[k + i] + su * half);
                            next->v[face].push_back(search.v[k + i] + sv * half);
                        }
                    }
                }
            }
        }
        std::swap(level, next);
    }
    std::array<float, 16> value, x, y, z;
    store(best.value, value.data());
    store(best.x, x.data());
    store(best.y, y.data());
    store(best.z, z.data());
    const auto at = static_cast<std::size_t>(
        std::min_element(value.begin(), value.begin() + static_cast<std::ptrdiff_t>(n)) - value.begin());
    return {std::min(dropped, value[at]) - rounding, value[at], x[at], y[at], z[at]};
}

struct Minima {
    ConstBatch in;
    float tolerance;
    const float* floors;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        Search search;
        std::array<float, static_cast<std::size_t>(Order * Order)> f;
        for (std::size_t k = 0; k < in.count; ++k) {
            float largest = 0.0F;
            for (std::size_t i = 0; i < f.size(); ++i) {
                f[i] = in.row(i)[k];
                largest = std::max(largest, std::abs(f[i]));
            }
            // By a power of two to the order of 1, which changes no digit.
            int exponent = 0;
            static_cast<void>(std::frexp(largest, &exponent));
            for (float& v : f) {
                v = std::ldexp(v, -exponent);
            }
            const float floor =
                floors != nullptr ? std::ldexp(floors[k], -exponent) : std::numeric_limits<float>::max();
            const Found found = find_minimum<Order>(f.data(), tolerance, floor, search);
            out.row(0)[k] = std::ldexp(found.lower, exponent);
            out.row(1)[k] = std::ldexp(found.value, exponent);
            out.row(2)[k] = found.x;
            out.row(3)[k] = found.y;
            out.row(4)[k] = found.z;
        }
    }
};

void minima_kernel(int order, ConstBatch in, float tolerance, const float* floors, Batch out) {
    const Minima minima{in, tolerance, floors, out};
    switch (order) {
    case 2:
        return minima.run<2>();
    case 3:
        return minima.run<3>();
    case 4:
        return minima.run<4>();
    case 5:
        return minima.run<5>();
    default:
        return minima.run<6>();
    }
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(minima_kernel);

void certified_minimum(int order, ConstBatch coefficients, float tolerance, Batch out, std::span<const float> floors) {
    assert(order >= 2 && order <= 6 && coefficients.count == out.count && tolerance > 0.0F);
    assert(floors.empty() || floors.size() >= coefficients.count);
    HWY_DYNAMIC_DISPATCH(minima_kernel)
    (order, coefficients, tolerance, floors.empty() ? nullptr : floors.data(), out);
}

} // namespace alpenglow::sh
#endif
