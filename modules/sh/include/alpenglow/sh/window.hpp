// Windows: factors per band that taper a coefficient vector so that it rings less.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <span>

namespace alpenglow::sh {

// Every window is 1 at l = 0 and, but for none and gauss, 0 from l = cutoff on.
enum class Window {
    none,
    hann,  // (1 + cos(pi l / w)) / 2
    sinc,  // sin(pi l / w) / (pi l / w): Lanczos' sigma factor
    sinc4, // its fourth power, Sloan 2017 eq. 6 and Habel et al. 2008 eq. 5
    gauss, // exp(-l(l+1) / w^2): diffusion on the sphere, which never makes a minimum lower
};

// factors[l] for l = 0 .. order-1. cutoff w > 0, infinity meaning no window.
void window_factors(Window window, double cutoff, int order, std::span<double> factors) noexcept;
// The Lanczos window of `lobes` lobes, sinc(l/w) sinc(l/(w lobes)), zero from l = w on.
void lanczos_factors(double cutoff, double lobes, int order, std::span<double> factors) noexcept;

// out_lm = factors[l] in_lm; in place is fine.
void apply_window(int order, std::span<const double> factors, std::span<const double> in,
                  std::span<double> out) noexcept;
void apply_window(int order, std::span<const double> factors, std::span<const float> in, std::span<float> out) noexcept;

} // namespace alpenglow::sh
