// Products of many pairs of coefficient vectors.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_product.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include "simd-inl.h"

#include "gaunt.hpp"
#include "product_transform.hpp"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

// Orders 1 to 3: the Gaunt coefficients as constants in straight-line code.
template <int Order, int I, int J, int K>
HWY_INLINE void add_pair(V pair, V* out) {
    if constexpr (K < Order * Order) {
        constexpr double value = detail::gaunt_table_3.value[I][J][K];
        if constexpr (value != 0.0) {
            out[K] = hn::MulAdd(pair, constant(value), out[K]);
        }
        add_pair<Order, I, J, K + 1>(pair, out);
    }
}

template <int Order, int I, int J>
HWY_INLINE void add_pairs(const V* f, const V* g, V* out) {
    if constexpr (J < Order * Order) {
        if constexpr (I == J) {
            add_pair<Order, I, J, 0>(hn::Mul(f[I], g[I]), out);
        } else {
            add_pair<Order, I, J, 0>(hn::MulAdd(f[I], g[J], hn::Mul(f[J], g[I])), out);
        }
        add_pairs<Order, I, J + 1>(f, g, out);
    } else if constexpr (I + 1 < Order * Order) {
        add_pairs<Order, I + 1, I + 1>(f, g, out);
    }
}

// Orders 4 and up: through values. In z, at Gauss-Legendre nodes that integrate a product of three functions exactly;
// in azimuth as Fourier coefficients, whose product is a convolution. About a third of the work of the sparse sum at
// order 6, and better conditioned. Nodes z and -z share their sums: Q_l^m is even or odd with l - m.
template <int Order>
struct Fourier {
    V re[Order], im[Order]; // of exp(i m phi), m >= 0; im[0] is unused
};

template <int Order>
HWY_INLINE void to_nodes(const float* q, ConstBatch in, std::size_t k, Fourier<Order>& north, Fourier<Order>& south) {
    HWY_UNROLL(64)
    for (int m = 0; m < Order; ++m) {
        V even_re = hn::Zero(d), odd_re = hn::Zero(d), even_im = hn::Zero(d), odd_im = hn::Zero(d);
        HWY_UNROLL(64)
        for (int l = m; l < Order; ++l) {
            const V w = hn::Set(d, *q++);
            const V re = load(in.row(static_cast<std::size_t>(index(l, m))) + k);
            V& sum_re = (l - m) % 2 == 0 ? even_re : odd_re;
            sum_re = l < m + 2 ? hn::Mul(w, re) : hn::MulAdd(w, re, sum_re);
            if (m > 0) {
                const V im = load(in.row(static_cast<std::size_t>(index(l, -m))) + k);
                V& sum_im = (l - m) % 2 == 0 ? even_im : odd_im;
                sum_im = l < m + 2 ? hn::Mul(w, im) : hn::MulAdd(w, im, sum_im);
            }
        }
        north.re[m] = hn::Add(even_re, odd_re);
        south.re[m] = hn::Sub(even_re, odd_re);
        north.im[m] = hn::Add(even_im, odd_im);
        south.im[m] = hn::Sub(even_im, odd_im);
    }
}

// c_k = sum_m a_m b_(k-m) over m from k-Order+1 to Order-1, with a_-m the conjugate of a_m.
template <int Order>
HWY_INLINE void convolve(const Fourier<Order>& a, const Fourier<Order>& b, Fourier<Order>& c) {
    V dc = hn::Zero(d);
    HWY_UNROLL(64)
    for (int m = 1; m < Order; ++m) {
        dc = hn::MulAdd(a.re[m], b.re[m], dc);
        dc = hn::MulAdd(a.im[m], b.im[m], dc);
    }
    c.re[0] = hn::MulAdd(a.re[0], b.re[0], hn::Add(dc, dc));
    c.im[0] = hn::Zero(d);
    HWY_UNROLL(64)
    for (int k = 1; k < Order; ++k) {
        V re = hn::MulAdd(a.re[0], b.re[k], hn::Mul(a.re[k], b.re[0]));
        V im = hn::MulAdd(a.re[0], b.im[k], hn::Mul(a.im[k], b.re[0]));
        HWY_UNROLL(64)
        for (int m = 1; m < k; ++m) {
            re = hn::MulAdd(a.re[m], b.re[k - m], re);
            re = hn::NegMulAdd(a.im[m], b.im[k - m], re);
            im = hn::MulAdd(a.re[m], b.im[k - m], im);
            im = hn::MulAdd(a.im[m], b.re[k - m], im);
        }
        HWY_UNROLL(64)
        for (int m = k + 1; m < Order; ++m) { // a_m conj(b_(m-k)) + conj(a_(m-k)) b_m
            re = hn::MulAdd(a.re[m], b.re[m - k], re);
            re = hn::MulAdd(a.im[m], b.im[m - k], re);
            im = hn::MulAdd(a.im[m], b.re[m - k], im);
            im = hn::NegMulAdd(a.re[m], b.im[m - k], im);
            re = hn::MulAdd(a.re[m - k], b.re[m], re);
            re = hn::MulAdd(a.im[m - k], b.im[m], re);
            im = hn::MulAdd(a.re[m - k], b.im[m], im);
            im = hn::NegMulAdd(a.im[m - k], b.re[m], im);
        }
        c.re[k] = re;
        c.im[k] = im;
    }
}

// Adds the projection of the node pair.
template <int Order>
HWY_INLINE void from_nodes(const float* q, const Fourier<Order>& north, const Fourier<Order>& south, V* out) {
    HWY_UNROLL(64)
    for (int m = 0; m < Order; ++m) {
        const V even_re = hn::Add(north.re[m], south.re[m]), odd_re = hn::Sub(north.re[m], south.re[m]);
        const V even_im = hn::Add(north.im[m], south.im[m]), odd_im = hn::Sub(north.im[m], south.im[m]);
        HWY_UNROLL(64)
        for (int l = m; l < Order; ++l) {
            const V w = hn::Set(d, *q++);
            const V re = (l - m) % 2 == 0 ? even_re : odd_re;
            V& plus = out[index(l, m)];
            plus = hn::MulAdd(w, re, plus);
            if (m > 0) {
                const V im = (l - m) % 2 == 0 ? even_im : odd_im;
                V& minus = out[index(l, -m)];
                minus = hn::MulAdd(w, im, minus);
            }
        }
    }
}

struct Product {
    const detail::ProductTransform* transform;
    ConstBatch f, g;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        constexpr int n = Order * Order;
        for (std::size_t k = 0; k < f.count; k += lanes()) {
            V sum[n];
            HWY_UNROLL(64)
            for (int i = 0; i < n; ++i) {
                sum[i] = hn::Zero(d);
            }
            if constexpr (Order <= 3) {
                V a[n], b[n];
                HWY_UNROLL(64)
                for (int i = 0; i < n; ++i) {
                    a[i] = load(f.row(static_cast<std::size_t>(i)) + k);
                    b[i] = load(g.row(static_cast<std::size_t>(i)) + k);
                }
                add_pairs<Order, 0, 0>(a, b, sum);
            } else {
                for (int pair = 0; pair < transform->pairs; ++pair) {
                    Fourier<Order> a_north, a_south, b_north, b_south, c_north, c_south;
                    to_nodes<Order>(transform->forward[pair], f, k, a_north, a_south);
                    to_nodes<Order>(transform->forward[pair], g, k, b_north, b_south);
                    convolve<Order>(a_north, b_north, c_north);
                    convolve<Order>(a_south, b_south, c_south);
                    from_nodes<Order>(transform->backward[pair], c_north, c_south, sum);
                }
            }
            HWY_UNROLL(64)
            for (int i = 0; i < n; ++i) {
                store(sum[i], out.row(static_cast<std::size_t>(i)) + k);
            }
        }
    }
};

void product_kernel(int order, const detail::ProductTransform* transform, ConstBatch f, ConstBatch g, Batch out) {
    for_order(order, Product{transform, f, g, out});
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(product_kernel);

void product(int order, ConstBatch f, ConstBatch g, Batch out) {
    assert(order >= 1 && order <= max_order && f.count == g.count && f.count == out.count);
    HWY_DYNAMIC_DISPATCH(product_kernel)(order, order > 3 ? &detail::product_transform(order) : nullptr, f, g, out);
}

} // namespace alpenglow::sh
#endif
