// Deringing: the least window that keeps a projected light from going negative.
//
// Two ways to bound the minimum, and a choice of window families:
//   paper  Sloan, "Deringing Spherical Harmonics" (2017): a conservative bound for order 3, and a search in his table.
//   exact  the true minimum: for order 3 a quadratic form on the sphere (3 x 3 eigenvalues and a secular equation), for
//          orders 4 to 8 a branch and bound; both with a certificate.
// Everything here is scalar and in double, the reference of the batches in dering_batch.hpp.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <array>
#include <cstdint>
#include <span>

namespace alpenglow::sh {

// What must not be negative: the light itself, or the irradiance it gives (the coefficients stay those of radiance).
enum class Signal { irradiance, radiance };

// One-parameter families of windows. At strength 0 nothing is changed, at strength 1 the average alone is left, so that
// a light of positive average always has a window.
enum class WindowFamily {
    blend, // every band but the mean times 1 - t: towards the average. The least change in the L2 norm, and a closed
           // form
    gauss, // diffusion, factors g^(l(l+1)/2): never lowers a minimum; takes the false light opposite the sun away too
    sloan, // Table 1 of the paper, linear between its columns (t = 6/7 is its last), then towards the average
    hann,  // window.hpp, cut-off 1 / t
    sinc,
    sinc4,
};

// Factors of the bands 0 .. order-1. strength 0 .. 1. The sloan family goes up to order 4, as the table does.
void family_factors(WindowFamily family, double strength, int order, std::span<double> factors) noexcept;

// A minimum over directions. lower_bound <= true minimum <= value = f(direction).
struct Minimum {
    double value = 0.0;
    double lower_bound = 0.0;
    glm::dvec3 direction{0.0, 0.0, 1.0};
};

// Directions within an angle of an axis: the half space that a receiver with a known normal can see has cos_angle 0.
struct Cap {
    glm::dvec3 axis{0.0, 0.0, 1.0};
    double cos_angle = -1.0; // -1: the whole sphere
};

// Order 3, exact: lower_bound is the value of the Lagrange dual, and differs from value by rounding (1e-13 of the
// norm), also where the minimum is not unique. Finite coefficients.
[[nodiscard]] Minimum quadratic_minimum(std::span<const double> coefficients) noexcept;

// Any order, over the sphere or a cap, to an absolute tolerance: branch and bound on the faces of a cube. A cell that
// holds the minimum has f(centre) - min <= K r^2 / 2 with K = sum_l l^2 sqrt((2l+1) / 4 pi) |f_l| (Bernstein's
// inequality along great circles). Stops early, with a looser but still certified lower_bound, after 400 000 cells.
// Finite coefficients.
[[nodiscard]] Minimum certified_minimum(int order, std::span<const double> coefficients, double tolerance,
                                        const Cap& cap = {});

// Sloan's conservative bound of the minimum of an order 3 function (section 2.3): exact but for the |m| = 1 pair, which
// gets the worst phase. The paper gives it that phase below the equator of the linear direction alone; since the linear
// band is positive above, the upper half is never lower, and the bound holds on the whole sphere.
[[nodiscard]] double paper_bound(std::span<const double> coefficients) noexcept;

// What became of an input.
enum class DeringOutcome : std::uint8_t {
    unchanged,  // nowhere negative: factors are all 1, to the bit
    windowed,   // factors in `factors`
    dark,       // the average is zero or negative (with anything else non-zero): no window helps, factors are all 0
    not_finite, // a NaN or an infinity: factors are all 0, and the output is zero, not 0 * NaN
};

enum class DeringMethod { paper, exact };

struct DeringOptions {
    Signal signal = Signal::irradiance;
    DeringMethod method = DeringMethod::exact;
    WindowFamily family = WindowFamily::blend; // of exact; paper uses its table, to its last column and no further
    Cap cap{};                                 // of exact: where it must not be negative
};

struct Dering {
    DeringOutcome outcome = DeringOutcome::unchanged;
    double strength = 0.0;
    std::array<double, max_order> factors{}; // of the bands
};

// Negative values of this size relative to the average count as none.
inline constexpr double dering_tolerance = 3e-7;

// The least window for one or several channels, each order*order coefficients, one after the other: the strongest that
// any channel needs, so that colours keep their hue (section 3). orders 1 .. 8; paper wants order <= 3. No value of the
// windowed signal is below -4e-7 of its average (order <= 3) or -1e-4 (above), and no window is used where none is
// needed by more.
[[nodiscard]] Dering find_window(int order, std::span<const double> channels, const DeringOptions& options = {});

// Writes channels times the factors of `dering`; all zero where it says not_finite. In place is fine.
void apply_dering(int order, const Dering& dering, std::span<const double> channels, std::span<double> out) noexcept;
void apply_dering(int order, const Dering& dering, std::span<const float> channels, std::span<float> out) noexcept;

// Sloan's extra window for punctual lights, before they are added: bands 1 and 2 (section 3). With the last column of
// the table it makes the irradiance of a single light positive; the table alone does not (it leaves -3 % of the
// average).
inline constexpr std::array<double, 3> punctual_window{1.0, 0.92, 0.73};

// Direct and indirect light windowed apart and added (section 3): `direct` gets punctual_window and then its own
// window, `indirect` its own. Order 3, channels one after the other. Outcomes of the two in `first` and `second`.
struct DeringPair {
    Dering direct, indirect;
};
DeringPair dering_apart(std::span<const double> direct, std::span<const double> indirect, std::span<double> out,
                        const DeringOptions& options = {});

} // namespace alpenglow::sh
