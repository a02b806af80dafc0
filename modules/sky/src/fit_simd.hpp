// The inner loops of fit evaluation, dispatched to the widest instruction set at run time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace alpenglow::sky {

// Floats from one row to the next: 84 functions and what whole vectors run over; rows start at 64-byte borders.
inline constexpr std::size_t fit_stride = 96;

// Rows of a part, at most.
inline constexpr std::size_t max_fit_rows = 4096;

// A sun, and where its coefficients go.
struct FitSun {
    float x;                    // Chebyshev variable of its zenith angle
    float factor;               // what was divided out
    const float* factor_series; // or its Chebyshev series in x, 16 terms; null: the number counts
    float cos_a, sin_a;         // its azimuth
    int bands;
    float* out; // bands * bands times three floats: l(l+1)+m, channel
};

// Weights a degree where all share them; w holds as many, zeros at its end.
inline constexpr std::size_t fit_weights = 64;

// Rows sorted by their degree i in x: those of a degree are first[i] <= r < first[i + 1].
struct FitRows {
    const float* rows;
    const std::int32_t* first;
    std::size_t degrees;
    // Null: row r has the weight w[r]. Else the weights of a degree's rows are w[0], w[1] .. for every degree, and this
    // says where a row finds its own in a table of fit_weights a degree.
    const std::int16_t* position;
};

// sums[i][f] = sum over the rows of degree i of weight times row.
void fit_sum_rows(const FitRows& rows, const float* w, std::size_t functions, float* sums);
// From those sums to the coefficients of a sun.
void fit_from_sums(const float* sums, std::size_t degrees, const FitSun& sun);
// From the rows, once through.
void fit_from_rows(const FitRows& rows, const float* w, const FitSun& sun);

// T_0 .. T_(n-1) at x, n >= 2, by halves: T_i = 2 T_ceil(i/2) T_floor(i/2) - T_(i mod 2). The usual recurrence waits
// for itself at every step; this one is a few steps deep. out may be written one past the end.
template <class Real>
inline void chebyshev(Real x, std::size_t n, Real* out) {
    out[0] = Real(1);
    out[1] = x;
    for (std::size_t i = 2; i < n; i += 2) {
        const Real half = out[i / 2];
        out[i] = Real(2) * half * half - Real(1);
        out[i + 1] = Real(2) * half * out[i / 2 + 1] - x;
    }
}

} // namespace alpenglow::sky
