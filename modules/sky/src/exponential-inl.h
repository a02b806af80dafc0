// e^x for SIMD vectors, relative error 2e-7; included once for each instruction set.
#if defined(ALPENGLOW_SKY_EXPONENTIAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ALPENGLOW_SKY_EXPONENTIAL_INL_H_
#undef ALPENGLOW_SKY_EXPONENTIAL_INL_H_
#else
#define ALPENGLOW_SKY_EXPONENTIAL_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sky::HWY_NAMESPACE {

// x is held to -87 .. 88: 2^n times a polynomial on -ln2/2 .. ln2/2 (Cephes).
template <class V>
HWY_INLINE V exponential(V x) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::DFromV<V> d;
    const hn::RebindToSigned<hn::DFromV<V>> di;
    const V held = hn::Max(hn::Min(x, hn::Set(d, 88.0F)), hn::Set(d, -87.0F));
    const V n = hn::Round(hn::Mul(held, hn::Set(d, 1.44269504F)));
    const V r = hn::NegMulAdd(n, hn::Set(d, -2.12194440e-4F), hn::NegMulAdd(n, hn::Set(d, 0.693359375F), held));
    V p = hn::Set(d, 1.9875691500e-4F);
    p = hn::MulAdd(p, r, hn::Set(d, 1.3981999507e-3F));
    p = hn::MulAdd(p, r, hn::Set(d, 8.3334519073e-3F));
    p = hn::MulAdd(p, r, hn::Set(d, 4.1665795894e-2F));
    p = hn::MulAdd(p, r, hn::Set(d, 1.6666665459e-1F));
    p = hn::MulAdd(p, r, hn::Set(d, 5.0000001201e-1F));
    p = hn::MulAdd(hn::Mul(p, r), r, hn::Add(r, hn::Set(d, 1.0F)));
    const auto bits = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127)));
    return hn::Mul(p, hn::BitCast(d, bits));
}

// 2^x for x <= 126, held to x >= -126; relative error 4e-7: five multiplications.
template <class V>
HWY_INLINE V power_of_two(V x) {
    namespace hn = hwy::HWY_NAMESPACE;
    const hn::DFromV<V> d;
    const hn::RebindToSigned<hn::DFromV<V>> di;
    const V held = hn::Max(x, hn::Set(d, -126.0F));
    const V magic = hn::Set(d, 12582912.0F); // rounds to a whole number in the low bits
    const V shifted = hn::Add(held, magic);
    const V r = hn::Sub(held, hn::Sub(shifted, magic));
    V p = hn::Set(d, 0.00133813025F);
    p = hn::MulAdd(p, r, hn::Set(d, 0.00966636852F));
    p = hn::MulAdd(p, r, hn::Set(d, 0.0555038101F));
    p = hn::MulAdd(p, r, hn::Set(d, 0.24022349F));
    p = hn::MulAdd(p, r, hn::Set(d, 0.693147181F));
    p = hn::MulAdd(p, r, hn::Set(d, 1.0F));
    const auto bits = hn::Add(hn::ShiftLeft<23>(hn::BitCast(di, shifted)), hn::BitCast(di, p));
    return hn::BitCast(d, bits);
}

} // namespace alpenglow::sky::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
