// Inner loops of build_scattered_field: rows of sun angles, a multiple of 16 long, for all azimuths and channels of one
// ray at one shell. [azimuth][channel], `row` apart, each padded before and after.
#pragma once

#include "scattering_field.hpp"

#include <cstddef>

namespace alpenglow::sky {

inline constexpr std::size_t row_pad = 16; // before and after each row
inline constexpr std::size_t most_azimuths = 16;

template <class T>
struct SweepShape {
    std::size_t bands, azimuths, count, row;
    T cosine[most_azimuths][most_field_bands]; // of m times the azimuth
    T g, twice, forward;                       // aerosol's g, the square of its mean cosine, its share straight on
};

// Light scattered once at a shell: phase functions of nu = mu mu_s + s cos(azimuth) sine_s, times the sun's light
// [channel][count].
template <class T>
void single_source(const SweepShape<T>& shape, T mu, T s, const T* mu_s, const T* sine_s, const T* sun, T* rayleigh,
                   T* mie);
// to = light - aureole times Cornette-Shanks.
template <class T>
void without_aureole(const SweepShape<T>& shape, T mu, T s, const T* mu_s, const T* sine_s, const T* aureole,
                     const T* light, T* to);
// mie += aureole times what aerosol makes of it.
template <class T>
void aureole_source(const SweepShape<T>& shape, T mu, T s, const T* mu_s, const T* sine_s, const T* aureole, T* mie);
// The field's own source at a shell: y in the order of field_function(), of_mie and of_rayleigh [function][channel]
// [count].
template <class T>
void field_source(const SweepShape<T>& shape, const T* y, const T* of_rayleigh, const T* of_mie, T* rayleigh, T* mie);

// Through one layer: the far end's light and sources, shifted by the sun's angle, and the near end's sources.
template <class T>
struct CarryWeights {
    T left[3], rayleigh_near[3], rayleigh_far[3], mie_near[3], mie_far[3];
};
template <class T>
void carry_light(const SweepShape<T>& shape, const CarryWeights<T>& weights, double shift_per_cosine,
                 const T* rayleigh_near, const T* mie_near, const T* rayleigh_far, const T* mie_far, T* light,
                 T* scratch);

// field += y times the light's azimuthal modes; ground += ground_weight times its mean over the azimuths.
template <class T>
void gather_light(const SweepShape<T>& shape, const T* y, const T* light, T* field, T ground_weight, T* ground);

} // namespace alpenglow::sky
