#include <alpenglow/ephemeris/geocentric_cache.hpp>

#include <alpenglow/ephemeris/time.hpp>

#include <cassert>
#include <cmath>

#include <glm/geometric.hpp>

namespace alpenglow::ephemeris {
namespace {

// The rotation whose first and last columns are near x and z: interpolated axes are unit and square to 1e-8 only.
glm::dmat3 orthonormal(const glm::dvec3& x, const glm::dvec3& z) {
    const glm::dvec3 last = glm::normalize(z);
    const glm::dvec3 middle = glm::normalize(glm::cross(last, x));
    return {glm::cross(middle, last), middle, last};
}

} // namespace

void GeocentricCache::fill(Span& span, std::int64_t index) {
    // Nodes cos((2 k + 1) pi / 8), ascending.
    constexpr double outer = 0.92387953251128675613;
    constexpr double inner = 0.38268343236508977173;
    constexpr std::array<double, 4> node{-outer, -inner, inner, outer};
    std::array<Sample, 4> f;
    const double middle_s = (static_cast<double>(index) + 0.5) * span_s;
    for (std::size_t i = 0; i < 4; ++i) {
        const Geocentric g = geocentric(julian_centuries(middle_s + 0.5 * span_s * node[i]));
        f[i] = {g.sun_m,
                g.moon_m,
                g.equatorial_from_moon[0],
                g.equatorial_from_moon[2],
                g.true_from_j2000[0],
                g.true_from_j2000[2],
                glm::dvec3(g.equation_of_equinoxes_rad, 0.0, 0.0)};
    }
    // Even and odd parts of the cubic through symmetric nodes.
    constexpr double gap = outer * outer - inner * inner;
    for (std::size_t v = 0; v < vectors; ++v) {
        const glm::dvec3 even_outer = 0.5 * (f[3][v] + f[0][v]);
        const glm::dvec3 even_inner = 0.5 * (f[2][v] + f[1][v]);
        const glm::dvec3 odd_outer = (f[3][v] - f[0][v]) / (2.0 * outer);
        const glm::dvec3 odd_inner = (f[2][v] - f[1][v]) / (2.0 * inner);
        span.coefficient[2][v] = (even_outer - even_inner) / gap;
        span.coefficient[0][v] = even_inner - inner * inner * span.coefficient[2][v];
        span.coefficient[3][v] = (odd_outer - odd_inner) / gap;
        span.coefficient[1][v] = odd_inner - inner * inner * span.coefficient[3][v];
    }
    span.index = index;
    ++fills_;
}

Geocentric GeocentricCache::at(double tt_j2000_s) {
    assert(std::abs(tt_j2000_s) < 1e12);
    const double position = std::floor(tt_j2000_s / span_s);
    const auto index = static_cast<std::int64_t>(position);
    Span& span = spans_[static_cast<std::uint64_t>(index) % spans_.size()];
    if (span.index != index) {
        fill(span, index);
    }
    const double x = 2.0 * (tt_j2000_s - position * span_s) / span_s - 1.0;
    const auto& c = span.coefficient;
    const auto value = [&](std::size_t v) { return c[0][v] + x * (c[1][v] + x * (c[2][v] + x * c[3][v])); };
    Geocentric g;
    g.sun_m = value(0);
    g.moon_m = value(1);
    g.equatorial_from_moon = orthonormal(value(2), value(3));
    g.true_from_j2000 = orthonormal(value(4), value(5));
    g.equation_of_equinoxes_rad = value(6).x;
    return g;
}

} // namespace alpenglow::ephemeris
