// What the vectorised kernels share. Included once for each instruction set by Highway's foreach_target.
#if defined(ALPENGLOW_SH_SIMD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALPENGLOW_SH_SIMD_INL_H_
#undef ALPENGLOW_SH_SIMD_INL_H_
#else
#define ALPENGLOW_SH_SIMD_INL_H_
#endif

#include <alpenglow/sh/batch.hpp>

#include "tables.hpp"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
inline constexpr D d;

HWY_INLINE V constant(double value) {
    return hn::Set(d, static_cast<float>(value));
}
HWY_INLINE V load(const float* p) {
    return hn::LoadU(d, p);
}
HWY_INLINE void store(V v, float* p) {
    hn::StoreU(v, d, p);
}
HWY_INLINE std::size_t lanes() {
    return hn::Lanes(d);
}

// Q_l^m(z), with Y_l^m = Q_l^m(z) {Re, Im}(-(x + iy))^|m|: a polynomial in z^2 up to degree 5, the recurrence beyond,
// where the polynomial would lose digits.
template <int L, int M_>
HWY_INLINE V legendre(V z, V z2, V previous, V before) {
    constexpr int degree = L - M_;
    constexpr const double* p = detail::basis_tables.poly[L][M_];
    if constexpr (degree == 0) {
        return constant(p[0]);
    } else if constexpr (degree == 1) {
        return hn::Mul(constant(p[0]), z);
    } else if constexpr (degree == 2) {
        return hn::MulAdd(constant(p[1]), z2, constant(p[0]));
    } else if constexpr (degree == 3) {
        return hn::Mul(hn::MulAdd(constant(p[1]), z2, constant(p[0])), z);
    } else if constexpr (degree == 4) {
        return hn::MulAdd(hn::MulAdd(constant(p[2]), z2, constant(p[1])), z2, constant(p[0]));
    } else if constexpr (degree == 5) {
        return hn::Mul(hn::MulAdd(hn::MulAdd(constant(p[2]), z2, constant(p[1])), z2, constant(p[0])), z);
    } else {
        const V scaled = hn::Mul(constant(detail::basis_tables.a[L][M_]), z);
        return hn::MulSub(scaled, previous, hn::Mul(constant(detail::basis_tables.b[L][M_]), before));
    }
}

template <int Order, int M_, int L, class Sink>
HWY_INLINE void basis_column(V z, V z2, V re, V im, V previous, V before, Sink& sink) {
    const V q = legendre<L, M_>(z, z2, previous, before);
    if constexpr (M_ == 0) {
        sink.template put<index(L, 0)>(q);
    } else {
        sink.template put<index(L, -M_)>(hn::Mul(q, im));
        sink.template put<index(L, M_)>(hn::Mul(q, re));
    }
    if constexpr (L + 1 < Order) {
        basis_column<Order, M_, L + 1>(z, z2, re, im, q, previous, sink);
    }
}

template <int Order, int M_, class Sink>
HWY_INLINE void basis_columns(V x, V y, V z, V z2, V re, V im, Sink& sink) {
    basis_column<Order, M_, M_>(z, z2, re, im, z, z, sink);
    if constexpr (M_ + 1 < Order) {
        if constexpr (M_ == 0) {
            basis_columns<Order, 1>(x, y, z, z2, x, y, sink);
        } else {
            const V next_re = hn::MulSub(x, re, hn::Mul(y, im));
            const V next_im = hn::MulAdd(x, im, hn::Mul(y, re));
            basis_columns<Order, M_ + 1>(x, y, z, z2, next_re, next_im, sink);
        }
    }
}

// Calls sink.put<i>(Y_i) for every i of the order, once each.
template <int Order, class Sink>
HWY_INLINE void basis(V x, V y, V z, Sink& sink) {
    basis_columns<Order, 0>(hn::Neg(x), hn::Neg(y), z, hn::Mul(z, z), x, y, sink);
}

struct StoreSink {
    float* out;
    std::size_t stride;
    template <int I>
    HWY_INLINE void put(V v) const {
        store(v, out + I * stride);
    }
};

// Calls kernel.run<Order>() for the order given at run time.
template <class Kernel>
HWY_INLINE void for_order(int order, const Kernel& kernel) {
    switch (order) {
    case 1:
        return kernel.template run<1>();
    case 2:
        return kernel.template run<2>();
    case 3:
        return kernel.template run<3>();
    case 4:
        return kernel.template run<4>();
    case 5:
        return kernel.template run<5>();
    case 6:
        return kernel.template run<6>();
    case 7:
        return kernel.template run<7>();
    default:
        return kernel.template run<8>();
    }
}

} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
