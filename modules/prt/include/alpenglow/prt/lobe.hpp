// Circular reflection lobes as convolution kernels: kernel[l] = alpha_l G*_l = 2 pi int G(z) P_l(z) dz (eq. 6), scaled
// so that kernel[0] = 1: white light comes back white.
#pragma once

#include <span>

namespace alpenglow::prt {

// max(z, 0)^exponent about the reflection direction, exponent >= 0. kernel[l] = I_l / I_0 with
// I_l = I_(l-2) (s - l + 2) / (s + l + 1): exact.
void phong_kernel(double exponent, std::span<float> kernel) noexcept;

// The GGX distribution of half vectors (Walter et al. 2007) as a lobe about the reflection direction, half vectors at
// half the angle: G(theta) ~ D(cos(theta / 2)), theta 0 .. pi/2. alpha = roughness^2, 0 < alpha <= 1. By quadrature,
// relative error below 1e-5 for alpha >= 0.01. What a normal-incidence view sees; grazing lobes are longer.
void ggx_kernel(double alpha, std::span<float> kernel) noexcept;

} // namespace alpenglow::prt
