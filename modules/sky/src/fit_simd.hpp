// The inner loops of fit evaluation, dispatched to the widest instruction set at run time.
#pragma once

#include <cstddef>
#include <cstdint>

namespace alpenglow::sky {

// Floats from one row to the next: 84 functions and what whole vectors run over; rows start at 64-byte borders.
inline constexpr std::size_t fit_stride = 96;

// A sun, and where its coefficients go.
struct FitSun {
    float x;            // Chebyshev variable of its zenith angle
    float factor;       // what was divided out
    float cos_a, sin_a; // its azimuth
    int bands;
    float* out; // bands * bands times three floats: l(l+1)+m, channel
};

// sums[i][f] = sum of w[index[r]] rows[r][f] over the rows r of degree i, first[i] <= r < first[i + 1].
void fit_sum_rows(const float* rows, const std::int32_t* first, const std::int32_t* index, std::size_t degrees,
                  const float* w, std::size_t functions, float* sums);
// From those sums to the coefficients of a sun.
void fit_from_sums(const float* sums, std::size_t degrees, const FitSun& sun);
// From the rows, once through.
void fit_from_rows(const float* rows, const std::int32_t* first, const std::int32_t* index, std::size_t degrees,
                   const float* w, const FitSun& sun);

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
