// Products of many pairs of coefficient vectors.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_product.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include "simd-inl.h"

#include "gaunt.hpp"
#include "matrix_terms.hpp"
#include "product_transform.hpp"

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

// Orders 1 and 2: the Gaunt coefficients as constants in straight-line code.
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

// Order 3: as c + b.n + n^T A n with A symmetric and without trace, 63 products where the sparse table takes 81 and a
// constant for each entry. With b and A scaled by t = sqrt(3/5), up to the factor k0 = sqrt(1 / 4 pi) of the basis,
//     c'' = c c' + 5/3 (b.b' + A:A' / 2)
//     b'' = c b' + c' b + A b' + A' b
//     A'' = c A' + c' A + b b'^T + b' b^T + 5/7 (A A' + A' A), less its trace.
// A = (g - e, -g - e, 2 e) on the diagonal.
struct Quadratic {
    V c, x, y, z, xy, yz, xz, g, e, xx, yy, zz;
    HWY_INLINE Quadratic(ConstBatch f, std::size_t k) {
        constexpr double t = 0.77459666924148338, third_root = 0.57735026918962576;
        const auto row = [&](std::size_t i, double scale)
                             HWY_ATTR { return hn::Mul(constant(scale), load(f.row(i) + k)); };
        c = load(f.row(0) + k);
        y = row(1, -t);
        z = row(2, t);
        x = row(3, -t);
        xy = row(4, t);
        yz = row(5, -t);
        e = row(6, t * third_root);
        xz = row(7, -t);
        g = row(8, t);
        xx = hn::Sub(g, e);
        yy = hn::Neg(hn::Add(g, e));
        zz = hn::Add(e, e);
    }
};

HWY_INLINE void multiply_quadratics(const Quadratic& p, const Quadratic& q, V* out) {
    constexpr double k0 = detail::basis_tables.seed[0], t = 0.77459666924148338, root_3 = 1.7320508075688773;
    constexpr double k = k0 / t;
    const V seventh = constant(5.0 / 7.0), scale = constant(k), minus = constant(-k);
    // a b' + a' b
    const auto both = [](V a, V b, V a2, V b2, V sum) HWY_ATTR { return hn::MulAdd(a, b2, hn::MulAdd(a2, b, sum)); };
    const auto both_of = [](V a, V b, V a2, V b2) HWY_ATTR { return hn::MulAdd(a, b2, hn::Mul(a2, b)); };
    const V dx = hn::Mul(p.x, q.x), dy = hn::Mul(p.y, q.y), dz = hn::Mul(p.z, q.z);
    const V gg = hn::Mul(p.g, q.g), ee = hn::Mul(p.e, q.e);
    const V pxy = hn::Mul(p.xy, q.xy), pxz = hn::Mul(p.xz, q.xz), pyz = hn::Mul(p.yz, q.yz);
    const V level = hn::Add(dx, dy), steep = hn::Add(pxz, pyz);
    const V squares = hn::MulAdd(constant(3.0), ee, hn::Add(hn::Add(gg, pxy), hn::Add(steep, hn::Add(level, dz))));
    out[0] = hn::MulAdd(hn::Mul(p.c, q.c), constant(k0), hn::Mul(squares, constant(5.0 / 3.0 * k0)));
    const V bx =
        both(p.xz, p.z, q.xz, q.z, both(p.xy, p.y, q.xy, q.y, both(p.xx, p.x, q.xx, q.x, both_of(p.c, p.x, q.c, q.x))));
    const V by =
        both(p.yz, p.z, q.yz, q.z, both(p.yy, p.y, q.yy, q.y, both(p.xy, p.x, q.xy, q.x, both_of(p.c, p.y, q.c, q.y))));
    const V bz =
        both(p.zz, p.z, q.zz, q.z, both(p.yz, p.y, q.yz, q.y, both(p.xz, p.x, q.xz, q.x, both_of(p.c, p.z, q.c, q.z))));
    out[1] = hn::Mul(minus, by);
    out[2] = hn::Mul(scale, bz);
    out[3] = hn::Mul(minus, bx);
    // Off the diagonal A A' + A' A uses the trace: A_xx + A_yy = -A_zz.
    const V axy = hn::Sub(both_of(p.xz, p.yz, q.xz, q.yz), both_of(p.zz, p.xy, q.zz, q.xy));
    const V ayz = hn::Sub(both_of(p.xy, p.xz, q.xy, q.xz), both_of(p.xx, p.yz, q.xx, q.yz));
    const V axz = hn::Sub(both_of(p.xy, p.yz, q.xy, q.yz), both_of(p.yy, p.xz, q.yy, q.xz));
    const V hxy = both(p.c, p.xy, q.c, q.xy, both_of(p.x, p.y, q.x, q.y));
    const V hyz = both(p.c, p.yz, q.c, q.yz, both_of(p.y, p.z, q.y, q.z));
    const V hxz = both(p.c, p.xz, q.c, q.xz, both_of(p.x, p.z, q.x, q.z));
    out[4] = hn::Mul(scale, hn::MulAdd(seventh, axy, hxy));
    out[5] = hn::Mul(minus, hn::MulAdd(seventh, ayz, hyz));
    out[7] = hn::Mul(minus, hn::MulAdd(seventh, axz, hxz));
    const V ag = hn::NegMulAdd(constant(2.0), both_of(p.g, p.e, q.g, q.e), hn::Sub(pxz, pyz));
    const V hg = both(p.c, p.g, q.c, q.g, hn::Sub(dx, dy));
    out[8] = hn::Mul(scale, hn::MulAdd(seventh, ag, hg));
    const V ae = hn::MulAdd(constant(2.0), ee,
                            hn::MulSub(constant(1.0 / 3.0), steep, hn::Mul(constant(2.0 / 3.0), hn::Add(gg, pxy))));
    const V he = both(p.c, p.e, q.c, q.e, hn::MulSub(constant(2.0 / 3.0), dz, hn::Mul(constant(1.0 / 3.0), level)));
    out[6] = hn::Mul(constant(k * root_3), hn::MulAdd(seventh, ae, he));
}

// Orders 4 and up: through values. In z, at Gauss-Lobatto nodes that integrate a product of three functions exactly; in
// azimuth as Fourier coefficients, whose product is a convolution. A third to a quarter of the work of the sparse sum
// at order 6, and better conditioned. Nodes z and -z share their sums: Q_l^m is even or odd with l - m.
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
        if (m == Order - 1) { // nothing odd
            north.re[m] = south.re[m] = even_re;
            north.im[m] = south.im[m] = even_im;
            continue;
        }
        north.re[m] = hn::Add(even_re, odd_re);
        south.re[m] = hn::Sub(even_re, odd_re);
        if (m > 0) {
            north.im[m] = hn::Add(even_im, odd_im);
            south.im[m] = hn::Sub(even_im, odd_im);
        }
    }
}

// At z = 0 what is odd in z vanishes.
template <int Order>
HWY_INLINE void to_middle(const float* q, ConstBatch in, std::size_t k, Fourier<Order>& middle) {
    HWY_UNROLL(64)
    for (int m = 0; m < Order; ++m) {
        HWY_UNROLL(64)
        for (int l = m; l < Order; l += 2) {
            const V w = hn::Set(d, q[l - m]);
            const V re = load(in.row(static_cast<std::size_t>(index(l, m))) + k);
            middle.re[m] = l == m ? hn::Mul(w, re) : hn::MulAdd(w, re, middle.re[m]);
            if (m > 0) {
                const V im = load(in.row(static_cast<std::size_t>(index(l, -m))) + k);
                middle.im[m] = l == m ? hn::Mul(w, im) : hn::MulAdd(w, im, middle.im[m]);
            }
        }
        q += Order - m;
    }
}

template <int Order>
HWY_INLINE void from_middle(const float* q, const Fourier<Order>& middle, V* out) {
    HWY_UNROLL(64)
    for (int m = 0; m < Order; ++m) {
        HWY_UNROLL(64)
        for (int l = m; l < Order; l += 2) {
            const V w = hn::Set(d, q[l - m]);
            out[index(l, m)] = hn::MulAdd(w, middle.re[m], out[index(l, m)]);
            if (m > 0) {
                out[index(l, -m)] = hn::MulAdd(w, middle.im[m], out[index(l, -m)]);
            }
        }
        q += Order - m;
    }
}

// What bands even and odd give at the north pole; at the south pole their difference.
template <int Order>
struct Pole {
    V even, odd;
};
template <int Order>
HWY_INLINE Pole<Order> to_poles(const float* q, ConstBatch in, std::size_t k) {
    Pole<Order> p{hn::Zero(d), hn::Zero(d)};
    HWY_UNROLL(16)
    for (int l = 0; l < Order; ++l) {
        const V f = load(in.row(static_cast<std::size_t>(index(l, 0))) + k), w = hn::Set(d, q[l]);
        (l % 2 == 0 ? p.even : p.odd) = hn::MulAdd(w, f, l % 2 == 0 ? p.even : p.odd);
    }
    return p;
}
// Starts the sums: all but m = 0 at zero.
template <int Order>
HWY_INLINE void from_poles(const float* q, const Pole<Order>& a, const Pole<Order>& b, V* out) {
    const V even = hn::MulAdd(a.even, b.even, hn::Mul(a.odd, b.odd));
    const V odd = hn::MulAdd(a.even, b.odd, hn::Mul(a.odd, b.even));
    const V even2 = hn::Add(even, even), odd2 = hn::Add(odd, odd); // both poles
    HWY_UNROLL(64)
    for (int i = 0; i < Order * Order; ++i) {
        out[i] = hn::Zero(d);
    }
    HWY_UNROLL(16)
    for (int l = 0; l < Order; ++l) {
        out[index(l, 0)] = hn::Mul(hn::Set(d, q[l]), l % 2 == 0 ? even2 : odd2);
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
        V even_im = even_re, odd_im = even_re;
        if (m > 0) {
            even_im = hn::Add(north.im[m], south.im[m]);
            odd_im = hn::Sub(north.im[m], south.im[m]);
        }
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

// out = the product's coefficients of the items at k.
template <int Order>
HWY_INLINE void multiply(const detail::ProductTransform* transform, ConstBatch f, ConstBatch g, std::size_t k, V* out) {
    constexpr int n = Order * Order;
    if constexpr (Order <= 2) {
        V a[n], b[n];
        HWY_UNROLL(64)
        for (int i = 0; i < n; ++i) {
            a[i] = load(f.row(static_cast<std::size_t>(i)) + k);
            b[i] = load(g.row(static_cast<std::size_t>(i)) + k);
            out[i] = hn::Zero(d);
        }
        add_pairs<Order, 0, 0>(a, b, out);
    } else if constexpr (Order == 3) {
        multiply_quadratics(Quadratic(f, k), Quadratic(g, k), out);
    } else {
        from_poles<Order>(transform->pole_backward, to_poles<Order>(transform->pole_forward, f, k),
                          to_poles<Order>(transform->pole_forward, g, k), out);
        for (int pair = 0; pair < transform->pairs; ++pair) {
            Fourier<Order> a_north, a_south, b_north, b_south, c_north, c_south;
            to_nodes<Order>(transform->forward[pair], f, k, a_north, a_south);
            to_nodes<Order>(transform->forward[pair], g, k, b_north, b_south);
            convolve<Order>(a_north, b_north, c_north);
            convolve<Order>(a_south, b_south, c_south);
            from_nodes<Order>(transform->backward[pair], c_north, c_south, out);
        }
        if constexpr (3 * (Order - 1) / 2 % 2 != 0) {
            Fourier<Order> a, b, c;
            to_middle<Order>(transform->forward[transform->pairs], f, k, a);
            to_middle<Order>(transform->forward[transform->pairs], g, k, b);
            convolve<Order>(a, b, c);
            from_middle<Order>(transform->backward[transform->pairs], c, out);
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
            multiply<Order>(transform, f, g, k, sum);
            HWY_UNROLL(64)
            for (int i = 0; i < n; ++i) {
                store(sum[i], out.row(static_cast<std::size_t>(i)) + k);
            }
        }
    }
};

struct TripleProduct {
    const detail::ProductTransform* transform;
    ConstBatch f, g, h;
    Batch out;
    template <int Order>
    HWY_INLINE void run() const {
        constexpr int n = Order * Order;
        for (std::size_t k = 0; k < f.count; k += lanes()) {
            V product[n], sum[2] = {hn::Zero(d), hn::Zero(d)};
            multiply<Order>(transform, f, g, k, product);
            HWY_UNROLL(64)
            for (int i = 0; i < n; ++i) {
                sum[i % 2] = hn::MulAdd(product[i], load(h.row(static_cast<std::size_t>(i)) + k), sum[i % 2]);
            }
            store(hn::Add(sum[0], sum[1]), out.data + k);
        }
    }
};

void product_kernel(int order, const detail::ProductTransform* transform, ConstBatch f, ConstBatch g, Batch out) {
    for_order(order, Product{transform, f, g, out});
}

void triple_product_kernel(int order, const detail::ProductTransform* transform, ConstBatch f, ConstBatch g,
                           ConstBatch h, Batch out) {
    for_order(order, TripleProduct{transform, f, g, h, out});
}

// Each entry of the upper triangle is a sparse sum of coefficients, stored twice.
void product_matrix_kernel(std::size_t n, const detail::MatrixTerms& terms, ConstBatch f, Batch out) {
    for (std::size_t k = 0; k < f.count; k += lanes()) {
        std::size_t term = 0;
        for (const detail::MatrixEntry& entry : terms.entries) {
            V sum = hn::Zero(d);
            for (; term < entry.end; ++term) {
                sum = hn::MulAdd(hn::Set(d, terms.factors[term]), load(f.row(terms.rows[term]) + k), sum);
            }
            store(sum, out.row(entry.row * n + entry.column) + k);
            if (entry.row != entry.column) {
                store(sum, out.row(entry.column * n + entry.row) + k);
            }
        }
    }
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(product_kernel);
HWY_EXPORT(triple_product_kernel);
HWY_EXPORT(product_matrix_kernel);

void product(int order, ConstBatch f, ConstBatch g, Batch out) {
    assert(order >= 1 && order <= max_order && f.count == g.count && f.count == out.count);
    HWY_DYNAMIC_DISPATCH(product_kernel)(order, order > 3 ? &detail::product_transform(order) : nullptr, f, g, out);
}

void triple_product(int order, ConstBatch f, ConstBatch g, ConstBatch h, Batch out) {
    assert(order >= 1 && order <= max_order && f.count == g.count && f.count == h.count && f.count == out.count);
    HWY_DYNAMIC_DISPATCH(triple_product_kernel)
    (order, order > 3 ? &detail::product_transform(order) : nullptr, f, g, h, out);
}

void product_matrix(int order, ConstBatch f, Batch out) {
    assert(order >= 1 && order <= max_order && f.count == out.count);
    HWY_DYNAMIC_DISPATCH(product_matrix_kernel)
    (static_cast<std::size_t>(coefficient_count(order)), detail::matrix_terms(order), f, out);
}

} // namespace alpenglow::sh
#endif
