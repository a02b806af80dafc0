// Deringing of many order 3 coefficient vectors: dering.cpp's exact and paper methods in float, sixteen lanes at a
// time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "batch_dering.cpp"
#include <hwy/foreach_target.h> // must come before what is compiled for each target

#include <alpenglow/sh/dering_batch.hpp>
#include <alpenglow/sh/irradiance.hpp>

#include "simd-inl.h"

#include "dering_orders.hpp"
#include "window_path.hpp"

#include <alpenglow/core/constants.hpp>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace alpenglow::sh::HWY_NAMESPACE {
namespace {

// Float finds the minimum to about 3e-7 of the average; less than this below zero counts as rounding.
constexpr double tolerance = 5e-7;

HWY_INLINE V reciprocal(V x) {
    return hn::Div(constant(1.0), x);
}

// 1 / sqrt(x) to the last bit or two.
HWY_INLINE V reciprocal_sqrt(V x) {
    V r = hn::ApproximateReciprocalSqrt(x);
    const V half = hn::Mul(x, constant(0.5));
    r = hn::Mul(r, hn::NegMulAdd(hn::Mul(half, r), r, constant(1.5)));
    return hn::Mul(r, hn::NegMulAdd(hn::Mul(half, r), r, constant(1.5)));
}

// The quadratic c + w1 b.n + w2 n^T A n by the terms of its diagonal form; Terms = 3 on the sphere, 2 for the paper's
// bound.
template <int Terms>
struct Form {
    V mean;    // c, but for what w2 scales
    V lowest;  // w2 times this is the constant part of the quadratic at the lowest eigenvalue
    V half[3]; // beta_i / 2
    V gap[3];  // lambda_i - lambda_min
};

struct Value {
    V dual;           // a lower bound of the minimum, and the minimum to rounding
    V slope1, slope2; // its derivatives by w1 and w2
};

// One step of Newton on 1 / |n| = 1 for nu, n_i = -b_i / (g_i + nu); from below it stays below.
template <int Terms>
HWY_INLINE V newton(const V (&b)[Terms], const V (&g)[Terms], V nu) {
    const V tiny = constant(1e-30), zero = hn::Zero(d);
    V sum = zero, slope = tiny;
    HWY_UNROLL(4)
    for (int i = 0; i < Terms; ++i) {
        const V rough = hn::ApproximateReciprocal(hn::Max(hn::Add(g[i], nu), tiny));
        const V n = hn::Mul(b[i], rough);
        const V square = hn::Mul(n, n);
        sum = hn::Add(sum, square);
        slope = hn::MulAdd(square, rough, slope);
    }
    // nu may only grow: a rough reciprocal must not step back over the pole.
    const V length = hn::Mul(sum, hn::ApproximateReciprocalSqrt(hn::Max(sum, tiny)));
    return hn::MulAdd(hn::Mul(sum, hn::Max(hn::Sub(length, constant(1.0)), zero)), hn::ApproximateReciprocal(slope),
                      nu);
}

// The dual of the minimum over unit n, after a few Newton steps on 1 / |n| = 1 (see quadratic.cpp). A lower bound for
// any number of steps; where a small b stands over a small gap it takes more than three to be near.
template <int Terms, bool Slopes, int Steps = 3>
HWY_INLINE Value minimum(const Form<Terms>& form, V w1, V w2) {
    const V tiny = constant(1e-30), zero = hn::Zero(d);
    V b[Terms], g[Terms], r[Terms], n2[Terms], large[Terms];
    V most = zero;
    HWY_UNROLL(4)
    for (int i = 0; i < Terms; ++i) {
        b[i] = hn::Mul(w1, form.half[i]);
        g[i] = hn::Mul(w2, form.gap[i]);
        most = hn::Max(most, hn::Abs(b[i]));
    }
    // First without the terms that hardly matter: with a small b over a small gap Newton would start beside a pole, and
    // only double nu at each step. Leaving terms out can only make nu too small, which is the safe side.
    V nu = zero, full = zero;
    HWY_UNROLL(4)
    for (int i = 0; i < Terms; ++i) {
        const V size = hn::Abs(b[i]);
        large[i] = hn::IfThenElseZero(hn::Gt(size, hn::Mul(constant(0.03), most)), b[i]);
        nu = hn::Max(nu, hn::Sub(hn::Abs(large[i]), g[i]));
        full = hn::Max(full, hn::Sub(size, g[i]));
    }
    // The paper's bound is conservative anyhow, and does without.
    if constexpr (Terms == 3) {
        for (int iteration = 0; iteration < 3; ++iteration) {
            nu = newton<Terms>(large, g, nu);
        }
    }
    nu = hn::Max(nu, full);
    for (int iteration = 0; iteration < Steps; ++iteration) {
        nu = newton<Terms>(b, g, nu);
    }
    V loss = nu;
    HWY_UNROLL(4)
    for (int i = 0; i < Terms; ++i) {
        const V gap = hn::Max(hn::Add(g[i], nu), tiny);
        const V rough = hn::ApproximateReciprocal(gap);
        r[i] = hn::Mul(rough, hn::NegMulAdd(gap, rough, constant(2.0)));
        loss = hn::MulAdd(hn::Mul(b[i], b[i]), r[i], loss);
    }
    Value value;
    value.dual = hn::Sub(hn::MulAdd(w2, form.lowest, form.mean), loss);
    if constexpr (Slopes) {
        // Envelope theorem: n_i = -b_i r_i, and the lowest axis takes what is missing, where its gap is 0.
        V linear = zero, quadratic = zero;
        HWY_UNROLL(4)
        for (int i = 0; i < Terms; ++i) {
            const V n = hn::Mul(b[i], r[i]);
            n2[i] = hn::Mul(n, n);
            linear = hn::MulAdd(form.half[i], n, linear);
            quadratic = hn::MulAdd(form.gap[i], n2[i], quadratic);
        }
        value.slope1 = hn::Neg(hn::Add(linear, linear));
        value.slope2 = hn::Add(form.lowest, quadratic);
    } else {
        value.slope1 = value.slope2 = zero;
    }
    return value;
}

// A Jacobi rotation of the symmetric matrix a that makes a[p][q] vanish, of the vector b with it. The angle may be
// rough as long as it is the same angle everywhere.
template <int P, int Q>
HWY_INLINE void jacobi(V (&a)[3][3], V (&b)[3]) {
    constexpr int O = 3 - P - Q;
    const V gap = hn::Sub(a[Q][Q], a[P][P]);
    const V twice = hn::Add(a[P][Q], a[P][Q]);
    const V squares = hn::MulAdd(gap, gap, hn::MulAdd(twice, twice, constant(1e-30)));
    const V length = hn::MulAdd(squares, hn::ApproximateReciprocalSqrt(squares), hn::Abs(gap));
    const V t = hn::CopySign(hn::Mul(twice, hn::ApproximateReciprocal(length)), hn::Xor(gap, twice));
    const V c = reciprocal_sqrt(hn::MulAdd(t, t, constant(1.0)));
    const V s = hn::Mul(t, c);
    const V apq = a[P][Q];
    const V move = hn::Mul(s, hn::MulSub(s, gap, hn::Mul(hn::Add(c, c), apq)));
    a[P][P] = hn::Add(a[P][P], move);
    a[Q][Q] = hn::Sub(a[Q][Q], move);
    a[P][Q] = hn::MulSub(hn::MulSub(c, c, hn::Mul(s, s)), apq, hn::Mul(hn::Mul(c, s), gap));
    a[Q][P] = a[P][Q];
    const V op = a[O][P], oq = a[O][Q];
    a[O][P] = a[P][O] = hn::MulSub(c, op, hn::Mul(s, oq));
    a[O][Q] = a[Q][O] = hn::MulAdd(s, op, hn::Mul(c, oq));
    const V bp = b[P], bq = b[Q];
    b[P] = hn::MulSub(c, bp, hn::Mul(s, bq));
    b[Q] = hn::MulAdd(s, bp, hn::Mul(c, bq));
}

struct Polynomial {
    V mean;
    V b[3];
    V a[3][3];
};

HWY_INLINE Form<3> exact_form(const Polynomial& p) {
    V a[3][3], b[3];
    HWY_UNROLL(4)
    for (int i = 0; i < 3; ++i) {
        b[i] = p.b[i];
        HWY_UNROLL(4)
        for (int j = 0; j < 3; ++j) {
            a[i][j] = p.a[i][j];
        }
    }
    for (int sweep = 0; sweep < 4; ++sweep) {
        jacobi<0, 1>(a, b);
        jacobi<0, 2>(a, b);
        jacobi<1, 2>(a, b);
    }
    Form<3> form;
    form.mean = p.mean;
    form.lowest = hn::Min(a[0][0], hn::Min(a[1][1], a[2][2]));
    HWY_UNROLL(4)
    for (int i = 0; i < 3; ++i) {
        form.gap[i] = hn::Sub(a[i][i], form.lowest);
        form.half[i] = hn::Mul(constant(0.5), b[i]);
    }
    return form;
}

HWY_INLINE V dot(const V (&p)[3], const V (&q)[3]) {
    return hn::MulAdd(p[0], q[0], hn::MulAdd(p[1], q[1], hn::Mul(p[2], q[2])));
}
HWY_INLINE void times(const V (&a)[3][3], const V (&p)[3], V (&out)[3]) {
    for (int i = 0; i < 3; ++i) {
        out[i] = dot(a[i], p);
    }
}

// The paper's bound: in the frame of the linear direction a z^2 + b z + c + q z sqrt(1 - z^2), which is a quadratic
// form on the circle (sqrt(1 - z^2), z).
HWY_INLINE Form<2> paper_form(const Polynomial& p) {
    const V zero = hn::Zero(d), one = constant(1.0), half = constant(0.5);
    const V length2 = dot(p.b, p.b);
    const M fine = hn::Gt(length2, constant(1e-30));
    const V scale = reciprocal_sqrt(hn::IfThenElse(fine, length2, one));
    V axis[3], u[3], v[3], along[3], across[3];
    for (int i = 0; i < 3; ++i) {
        axis[i] = hn::IfThenElse(fine, hn::Mul(p.b[i], scale), i == 2 ? one : zero);
    }
    const V sign = hn::CopySign(one, axis[2]);
    const V k = hn::Neg(reciprocal(hn::Add(sign, axis[2])));
    const V xy = hn::Mul(hn::Mul(axis[0], axis[1]), k);
    u[0] = hn::MulAdd(hn::Mul(sign, axis[0]), hn::Mul(axis[0], k), one);
    u[1] = hn::Mul(sign, xy);
    u[2] = hn::Neg(hn::Mul(sign, axis[0]));
    v[0] = xy;
    v[1] = hn::MulAdd(hn::Mul(axis[1], axis[1]), k, sign);
    v[2] = hn::Neg(axis[1]);
    times(p.a, axis, along);
    times(p.a, u, across);
    const V zz = dot(axis, along);
    const V difference = hn::MulAdd(half, zz, dot(u, across)); // (uu - vv) / 2, with uu + vv = -zz
    const V uv = dot(v, across);
    const V q2 = hn::Sqrt(hn::MulAdd(difference, difference, hn::Mul(uv, uv)));
    const V ua = dot(u, along), va = dot(v, along);
    const V q1 = hn::Sqrt(hn::MulAdd(ua, ua, hn::Mul(va, va))); // q / 2
    // The matrix (0, q/2; q/2, a) and the linear part (0, b), turned to its axes; c scales with w2 too.
    const V a = hn::MulAdd(constant(1.5), zz, q2);
    const V b = hn::Mul(length2, hn::IfThenElseZero(fine, scale));
    const V middle = hn::Mul(half, a);
    const V radius = hn::Sqrt(hn::MulAdd(middle, middle, hn::Mul(q1, q1)));
    // Half the angle between the axes: tan = q1 / (radius + |middle|).
    const V t = hn::Div(q1, hn::Max(hn::Add(radius, hn::Abs(middle)), constant(1e-30)));
    const V c = reciprocal_sqrt(hn::MulAdd(t, t, one));
    const V s = hn::Mul(t, c);
    const M rising = hn::Ge(middle, zero); // then the larger eigenvalue goes with z
    Form<2> form;
    form.mean = p.mean;
    form.lowest = hn::Sub(hn::Sub(middle, radius), hn::MulAdd(half, zz, q2));
    form.gap[0] = zero;
    form.gap[1] = hn::Add(radius, radius);
    form.half[0] = hn::Mul(hn::Mul(half, b), hn::IfThenElse(rising, s, c));
    form.half[1] = hn::Mul(hn::Mul(half, b), hn::IfThenElse(rising, c, s));
    return form;
}

// Factors of bands 1 and 2 along the paper's table; u = 7 .. 0 counts columns from its end, so that u is accurate where
// the factors are small. Slopes are by u, to the left of a column.
struct Column {
    V w1, w2, slope1, slope2;
};
HWY_INLINE Column column(V u) {
    const hn::RebindToSigned<D> di;
    const auto index_of = hn::Min(hn::ConvertTo(di, u), hn::Set(di, detail::sloan_columns - 2));
    constexpr const detail::SloanRows& rows = detail::sloan_rows;
    const V first1 = hn::GatherIndex(d, rows.value[0], index_of), first2 = hn::GatherIndex(d, rows.value[1], index_of);
    const V along = hn::Sub(u, hn::ConvertTo(d, index_of));
    Column c;
    c.slope1 = hn::GatherIndex(d, rows.slope[0], index_of);
    c.slope2 = hn::GatherIndex(d, rows.slope[1], index_of);
    c.w1 = hn::MulAdd(along, c.slope1, first1);
    c.w2 = hn::MulAdd(along, c.slope2, first2);
    return c;
}

// Where along the table the minimum is zero, given that it is negative at u = 7; not below `end`.
template <int Terms>
HWY_INLINE V solve_sloan(const Form<Terms>& form, double end, M needed) {
    // Binary search over the columns; then Newton within one, where the minimum is concave and approached from below.
    const V zero = hn::Zero(d), limit = constant(end);
    V u = constant(detail::sloan_columns - 1);
    for (const double stride : {4.0, 2.0, 1.0}) {
        const V middle = hn::Max(hn::Sub(u, constant(stride)), limit);
        const Column c = column(middle);
        u = hn::IfThenElse(hn::Lt(minimum<Terms, false>(form, c.w1, c.w2).dual, zero), middle, u);
    }
    const V first = u, last = hn::Max(hn::Sub(u, constant(1.0)), limit);
    // The column between last and first.
    const Column c = column(last);
    M active = needed; // a lane stops by itself, whatever the others do
    for (int iteration = 0; iteration < 8; ++iteration) {
        const V along = hn::Sub(u, last);
        const Value value =
            minimum<Terms, true>(form, hn::MulAdd(along, c.slope1, c.w1), hn::MulAdd(along, c.slope2, c.w2));
        const V slope = hn::MulAdd(value.slope1, c.slope1, hn::Mul(value.slope2, c.slope2));
        const V step =
            hn::Div(iteration < 4 ? value.dual : hn::Min(value.dual, zero), hn::Min(slope, constant(-1e-12)));
        const V next = hn::Min(hn::Max(hn::Sub(u, step), last), first);
        const M open =
            hn::And(hn::Ne(next, u), hn::Gt(hn::Abs(value.dual), hn::Mul(constant(0.2 * tolerance), form.mean)));
        u = hn::IfThenElse(active, next, u);
        active = hn::And(active, open);
        if (hn::AllFalse(d, active)) {
            break;
        }
    }
    return u;
}

// p with a minimum of zero at the factors p, p^3. What the bands take away grows like p to a power between 0 and 3
// known from its slope: Halley's formula for that root converges from afar.
HWY_INLINE V solve_gauss(const Form<3>& form, V linear, M needed) {
    const V one = constant(1.0), tiny = constant(1e-30);
    // The linear band alone, and the lowest eigenvalue alone, whose cube root starts from its exponent.
    const V cube = hn::Div(form.mean, hn::Max(hn::Neg(form.lowest), tiny));
    const V guess = hn::ConvertTo(d, hn::BitCast(hn::RebindToSigned<D>(), cube));
    const V third = hn::BitCast(
        d, hn::ConvertTo(hn::RebindToSigned<D>(), hn::MulAdd(guess, constant(1.0 / 3.0), constant(709921077.0))));
    // f >= mean - p |b| - p |lambda_1| for p <= 1, and somewhere f <= mean - p^3 |lambda_1|.
    V good = hn::Min(one, hn::Div(form.mean, hn::Max(hn::Sub(linear, form.lowest), tiny)));
    const V ceiling = hn::Min(one, hn::Mul(third, constant(1.1)));
    V bad = ceiling;
    V p = hn::Max(good, hn::Min(bad, hn::Div(form.mean, hn::Max(linear, tiny))));
    for (int iteration = 0; iteration < 20; ++iteration) {
        const V square = hn::Mul(p, p);
        const Value value = minimum<3, true>(form, p, hn::Mul(square, p));
        const M open = hn::And(needed, hn::Gt(hn::Abs(value.dual), hn::Mul(constant(0.2 * tolerance), form.mean)));
        if (hn::AllFalse(d, open)) {
            break;
        }
        const V taken = hn::Max(hn::Sub(form.mean, value.dual), tiny);
        const V slope = hn::MulAdd(hn::Mul(constant(3.0), square), value.slope2, value.slope1);
        const V power = hn::Min(hn::Max(hn::Div(hn::Mul(hn::Neg(p), slope), taken), constant(1e-3)), constant(3.0));
        const V more = hn::Add(power, one), less = hn::Sub(power, one);
        const V top = hn::MulAdd(more, form.mean, hn::Mul(less, taken));
        const V bottom = hn::MulAdd(less, form.mean, hn::Mul(more, taken));
        // A step out of the bracket goes to its middle instead.
        const V before = p;
        const M fits = hn::Ge(value.dual, hn::Zero(d));
        good = hn::IfThenElse(hn::And(open, fits), p, good);
        bad = hn::IfThenElse(hn::AndNot(fits, open), p, bad);
        // Below the power 1 the tangent is the better guess.
        const V tangent = hn::Sub(p, hn::Div(value.dual, hn::Min(slope, constant(-1e-12))));
        const V halley = hn::Mul(p, hn::Div(hn::Max(top, tiny), hn::Max(bottom, tiny)));
        p = hn::IfThenElse(hn::Lt(power, one), tangent, halley);
        // With room for rounding, lest it throws back a root that is found.
        const M inside =
            hn::And(hn::Ge(p, hn::Mul(good, constant(1.0 - 1e-5))), hn::Le(p, hn::Mul(bad, constant(1.0 + 1e-5))));
        p = hn::IfThenElse(inside, p, hn::Sqrt(hn::Mul(good, bad)));
        p = hn::IfThenElse(open, p, before);
    }
    // The last step was not looked at: one more, downwards only, along the tangent.
    const V square = hn::Mul(p, p);
    const Value value = minimum<3, true>(form, p, hn::Mul(square, p));
    const V slope = hn::MulAdd(hn::Mul(constant(3.0), square), value.slope2, value.slope1);
    p = hn::Sub(p, hn::Div(hn::Min(value.dual, hn::Zero(d)), hn::Min(slope, constant(-1e-12))));
    p = hn::Min(p, one);
    // Looked at closely, the minimum may have been taken too low, and the root with it: bisection then, of all there is
    // above.
    const auto dual = [&](V q) HWY_ATTR { return minimum<3, false, 10>(form, q, hn::Mul(hn::Mul(q, q), q)).dual; };
    const V floor = hn::Mul(constant(-tolerance), form.mean), at_p = dual(p);
    const M fits = hn::Ge(at_p, floor);
    const M found = hn::And(fits, hn::Lt(at_p, hn::Mul(constant(1e-4), form.mean)));
    if (hn::AllFalse(d, hn::AndNot(found, needed))) {
        return p;
    }
    V low = hn::IfThenElse(fits, hn::Max(p, good), good), high = hn::IfThenElse(fits, ceiling, p);
    for (int iteration = 0; iteration < 14; ++iteration) {
        const V middle = hn::Mul(constant(0.5), hn::Add(low, high));
        const M fit = hn::Ge(dual(middle), floor);
        low = hn::IfThenElse(fit, middle, low);
        high = hn::IfThenElse(fit, high, middle);
    }
    return hn::IfThenElse(found, p, low);
}

struct Kernel {
    int order; // 3, or 4 where the third band is not seen
    int channels;
    ConstBatch in;
    Batch out;
    DeringMethod method;
    WindowFamily family;
    float signal[3];
    DeringOutcome* outcomes;
    Batch factors;

    static constexpr std::size_t chunk = 256;

    // What a chunk's items are found to be, by masks of 0 and 1.
    struct Items {
        HWY_ALIGN float kept[chunk]; // the factor (blend), p (gauss), or columns from the end of the table
        HWY_ALIGN float finite[chunk], dark[chunk], windowed[chunk];
    };
    // The items of a chunk that need a search: one in six of common lights, so that it pays to close ranks.
    struct Pending {
        HWY_ALIGN float mean[chunk + 16], lowest[chunk + 16], half[3][chunk + 16], gap[3][chunk + 16];
        HWY_ALIGN float linear[chunk + 16], item[chunk + 16];
        std::size_t count = 0;
    };
    static HWY_INLINE M mask_of(const float* p) { return hn::Gt(hn::Load(d, p), constant(0.5)); }
    static HWY_INLINE void set_mask(M mask, float* p) { hn::Store(hn::IfThenElseZero(mask, constant(1.0)), d, p); }

    template <int Terms>
    static HWY_INLINE void wait(const Form<Terms>& form, V linear, M needed, std::size_t k, Pending& pending) {
        const std::size_t at = pending.count;
        const auto put = [&](V v, float* row) HWY_ATTR { hn::CompressStore(v, needed, d, row + at); };
        put(form.mean, pending.mean);
        put(form.lowest, pending.lowest);
        for (int i = 0; i < Terms; ++i) {
            put(form.half[i], pending.half[i]);
            put(form.gap[i], pending.gap[i]);
        }
        put(linear, pending.linear);
        pending.count += hn::CompressStore(hn::Iota(d, static_cast<float>(k)), needed, d, pending.item + at);
    }

    template <int Terms>
    HWY_INLINE void solve(const Pending& pending, Items& items) const {
        for (std::size_t at = 0; at < pending.count; at += lanes()) {
            const std::size_t here = std::min(lanes(), pending.count - at);
            // Lanes past the end repeat nothing: a quadratic that is 1.
            const M inside = hn::FirstN(d, here);
            const auto get = [&](const float* row) HWY_ATTR { return hn::IfThenElseZero(inside, load(row + at)); };
            Form<Terms> form;
            form.mean = hn::IfThenElse(inside, load(pending.mean + at), constant(1.0));
            form.lowest = get(pending.lowest);
            for (int i = 0; i < Terms; ++i) {
                form.half[i] = get(pending.half[i]);
                form.gap[i] = get(pending.gap[i]);
            }
            V kept;
            if constexpr (Terms == 2) {
                kept = solve_sloan<2>(form, 1.0, inside);
            } else {
                kept = family == WindowFamily::gauss ? solve_gauss(form, get(pending.linear), inside)
                                                     : solve_sloan<3>(form, 0.0, inside);
            }
            HWY_ALIGN float found[16];
            hn::Store(kept, d, found);
            for (std::size_t i = 0; i < here; ++i) {
                const auto item = static_cast<std::size_t>(pending.item[at + i]);
                items.kept[item] = std::min(items.kept[item], found[i]);
                items.windowed[item] = 1.0F;
            }
        }
    }

    template <bool Paper>
    HWY_INLINE void run() const {
        for (std::size_t begin = 0; begin < in.count; begin += chunk) {
            run_chunk<Paper>(begin, std::min(chunk, padded(in.count - begin)));
        }
    }

    template <bool Paper>
    HWY_INLINE void run_chunk(std::size_t begin, std::size_t count) const {
        const int rows = order * order;
        const bool table = Paper || family == WindowFamily::sloan;
        const V zero = hn::Zero(d), one = constant(1.0);
        const V all = table ? constant(detail::sloan_columns - 1) : one;
        Items items;
        for (std::size_t k = 0; k < count; k += lanes()) {
            hn::Store(all, d, items.kept + k);
            hn::Store(one, d, items.finite + k);
            hn::Store(zero, d, items.dark + k);
            hn::Store(zero, d, items.windowed + k);
        }
        Pending pending;
        for (int channel = 0; channel < channels; ++channel) {
            pending.count = 0;
            for (std::size_t k = 0; k < count; k += lanes()) {
                const float* f = in.row(static_cast<std::size_t>(rows * channel)) + begin + k;
                V v[9];
                V largest = zero;
                const M finite = mask_of(items.finite + k);
                M own = finite;
                HWY_UNROLL(16)
                for (std::size_t i = 0; i < 9; ++i) {
                    v[i] = load(f + i * in.stride);
                    own = hn::And(own, hn::IsFinite(v[i]));
                }
                V unseen = zero;
                for (std::size_t i = 9; i < static_cast<std::size_t>(rows); ++i) {
                    const V third = load(f + i * in.stride);
                    const M fine = hn::IsFinite(third);
                    own = hn::And(own, fine);
                    unseen = hn::Max(unseen, hn::Abs(hn::IfThenElseZero(fine, third)));
                }
                set_mask(own, items.finite + k);
                HWY_UNROLL(16)
                for (int i = 0; i < 9; ++i) {
                    v[i] = hn::IfThenElseZero(own, v[i]);
                    largest = hn::Max(largest, hn::Abs(v[i]));
                }
                const M lit = hn::Gt(hn::Max(largest, hn::IfThenElseZero(own, unseen)), zero);
                largest = hn::IfThenElse(hn::Gt(largest, zero), largest, unseen);
                // Into the range where squares and reciprocals are safe, then to 1.
                const V range = hn::IfThenElse(
                    hn::Lt(largest, constant(1e-20)), constant(1152921504606846976.0),
                    hn::IfThenElse(hn::Gt(largest, constant(1e20)), constant(1.0 / 1152921504606846976.0), one));
                const V scale = reciprocal(hn::IfThenElse(lit, hn::Mul(largest, range), one));
                HWY_UNROLL(16)
                for (int i = 0; i < 9; ++i) {
                    v[i] = hn::Mul(hn::Mul(v[i], range), scale);
                }
                const M no_mean = hn::AndNot(hn::Gt(v[0], zero), lit);
                set_mask(hn::Or(mask_of(items.dark + k), no_mean), items.dark + k);
                const M usable = hn::AndNot(no_mean, lit);

                Polynomial p;
                const V s1 = hn::Set(d, signal[1]), s2 = hn::Set(d, signal[2]);
                p.mean = hn::Mul(constant(detail::basis_tables.poly[0][0][0]), v[0]);
                const V k1 = hn::Mul(s1, constant(detail::basis_tables.poly[1][0][0]));
                p.b[0] = hn::Neg(hn::Mul(k1, v[3]));
                p.b[1] = hn::Neg(hn::Mul(k1, v[1]));
                p.b[2] = hn::Mul(k1, v[2]);
                const V k2 = hn::Mul(s2, constant(detail::basis_tables.seed[2]));
                const V z20 = hn::Mul(hn::Mul(s2, constant(-detail::basis_tables.poly[2][0][0])), v[6]);
                const V x22 = hn::Mul(k2, v[8]);
                p.a[0][0] = hn::Sub(x22, z20);
                p.a[1][1] = hn::Neg(hn::Add(x22, z20));
                p.a[2][2] = hn::Add(z20, z20);
                p.a[0][1] = p.a[1][0] = hn::Mul(k2, v[4]);
                p.a[1][2] = p.a[2][1] = hn::Neg(hn::Mul(k2, v[5]));
                p.a[0][2] = p.a[2][0] = hn::Neg(hn::Mul(k2, v[7]));

                // Nothing negative is possible where the mean exceeds what both bands can take away.
                const V linear = hn::Sqrt(dot(p.b, p.b));
                V frobenius = zero;
                for (int i = 0; i < 3; ++i) {
                    frobenius = hn::Add(frobenius, dot(p.a[i], p.a[i]));
                }
                const V most = hn::MulAdd(constant(0.8164966), hn::Sqrt(frobenius), linear);
                if (hn::AllFalse(d, hn::And(usable, hn::Gt(most, p.mean)))) {
                    continue;
                }
                const V threshold = hn::Mul(constant(-tolerance), p.mean);
                if constexpr (Paper) {
                    const Form<2> form = paper_form(p);
                    const M needed = hn::And(usable, hn::Lt(minimum<2, false>(form, one, one).dual, threshold));
                    wait<2>(form, linear, needed, k, pending);
                } else {
                    const Form<3> form = exact_form(p);
                    const V least = minimum<3, false>(form, one, one).dual;
                    const M needed = hn::And(usable, hn::Lt(least, threshold));
                    if (family != WindowFamily::blend) {
                        wait<3>(form, linear, needed, k, pending);
                        continue;
                    }
                    // Towards the average the minimum is linear.
                    const V own_kept = hn::Div(p.mean, hn::Max(hn::Sub(p.mean, least), constant(1e-30)));
                    hn::Store(hn::Min(hn::Load(d, items.kept + k), hn::IfThenElse(needed, own_kept, all)), d,
                              items.kept + k);
                    set_mask(hn::Or(mask_of(items.windowed + k), needed), items.windowed + k);
                }
            }
            solve<Paper ? 2 : 3>(pending, items);
        }
        for (std::size_t k = 0; k < count; k += lanes()) {
            const M finite = mask_of(items.finite + k), dark = mask_of(items.dark + k);
            const M windowed = mask_of(items.windowed + k);
            const V kept = hn::Load(d, items.kept + k);
            const std::size_t at = begin + k;
            V w1 = kept, w2 = kept;
            if (table) {
                const Column c = column(kept);
                w1 = c.w1;
                w2 = c.w2;
            } else if (family == WindowFamily::gauss) {
                w2 = hn::Mul(hn::Mul(w1, w1), w1);
            }
            // A hair less, so that what float rounds away below zero stays within 1e-6 of the average.
            w1 = hn::IfThenElse(windowed, hn::Mul(w1, constant(1.0 - tolerance)), w1);
            w2 = hn::IfThenElse(windowed, hn::Mul(w2, constant(1.0 - tolerance)), w2);
            const M alive = hn::AndNot(dark, finite);
            w1 = hn::IfThenElseZero(alive, w1);
            w2 = hn::IfThenElseZero(alive, w2);
            if (factors.data != nullptr) {
                store(w1, factors.row(0) + at);
                for (int l = 2; l < order; ++l) {
                    store(w2, factors.row(static_cast<std::size_t>(l - 1)) + at);
                }
            }
            for (int channel = 0; channel < channels; ++channel) {
                for (int i = 0; i < rows; ++i) {
                    const auto row = static_cast<std::size_t>(rows * channel + i);
                    // Masked first: zero times NaN is NaN.
                    const V value = hn::IfThenElseZero(alive, load(in.row(row) + at));
                    store(i == 0 ? value : hn::Mul(value, i < 4 ? w1 : w2), out.row(row) + at);
                }
            }
            if (outcomes != nullptr) {
                write_outcomes(at, finite, dark, windowed);
            }
        }
    }

    HWY_INLINE void write_outcomes(std::size_t k, M finite, M dark, M windowed) const {
        V code = hn::IfThenElseZero(windowed, constant(static_cast<double>(DeringOutcome::windowed)));
        code = hn::IfThenElse(dark, constant(static_cast<double>(DeringOutcome::dark)), code);
        code = hn::IfThenElse(finite, code, constant(static_cast<double>(DeringOutcome::not_finite)));
        HWY_ALIGN float codes[16];
        hn::Store(code, d, codes);
        const std::size_t n = HWY_MIN(lanes(), in.count - HWY_MIN(in.count, k));
        for (std::size_t i = 0; i < n; ++i) {
            outcomes[k + i] = static_cast<DeringOutcome>(codes[i]);
        }
    }
};

void dering_kernel(int order, int channels, ConstBatch in, Batch out, const DeringOptions& options,
                   DeringOutcome* outcomes, Batch factors) {
    Kernel kernel{order, channels, in, out, options.method, options.family, {1.0F, 1.0F, 1.0F}, outcomes, factors};
    if (options.signal == Signal::irradiance) {
        kernel.signal[1] = static_cast<float>(2.0 / 3.0);
        kernel.signal[2] = 0.25F;
    }
    if (options.method == DeringMethod::paper) {
        kernel.template run<true>();
    } else {
        kernel.template run<false>();
    }
}

} // namespace
} // namespace alpenglow::sh::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace alpenglow::sh {

HWY_EXPORT(dering_kernel);

void dering(int channels, ConstBatch in, Batch out, const DeringOptions& options, std::span<DeringOutcome> outcomes,
            Batch factors) {
    assert(channels >= 1 && in.count == out.count && (outcomes.empty() || outcomes.size() >= in.count));
    assert(options.cap.cos_angle <= -1.0);
    assert(options.family == WindowFamily::blend || options.family == WindowFamily::gauss ||
           options.family == WindowFamily::sloan);
    HWY_DYNAMIC_DISPATCH(dering_kernel)
    (3, channels, in, out, options, outcomes.empty() ? nullptr : outcomes.data(), factors);
}

void dering(int order, int channels, ConstBatch in, Batch out, const DeringOptions& options,
            std::span<DeringOutcome> outcomes, Batch factors) {
    assert(order >= 3 && order <= 6 && channels >= 1 && in.count == out.count);
    assert(outcomes.empty() || outcomes.size() >= in.count);
    assert(options.method == DeringMethod::exact && options.family == WindowFamily::blend &&
           options.cap.cos_angle <= -1.0);
    if (order == 3 || (order == 4 && options.signal == Signal::irradiance)) {
        HWY_DYNAMIC_DISPATCH(dering_kernel)
        (order, channels, in, out, options, outcomes.empty() ? nullptr : outcomes.data(), factors);
    } else {
        detail::dering_by_search(order, channels, in, out, options.signal, outcomes, factors);
    }
}

} // namespace alpenglow::sh
#endif
