// Sun and moon as cubics in time: the series are summed four times for six hours instead of once a frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <glm/vec3.hpp>

#include <alpenglow/ephemeris/series.hpp>

namespace alpenglow::ephemeris {

// Interpolates geocentric() by cubics through the four Chebyshev nodes of each span. Spans lie on a fixed grid, so the
// result depends on the instant alone and not on what was asked before. The last four spans are kept (2.7 kB).
class GeocentricCache {
public:
    static constexpr double span_s = 21600.0;
    // Bound on the angle between any direction here and that of geocentric(), over the dates of time.hpp: the moon's
    // fourth derivative (2 (2.7e-6 rad/s)^4) times span^4 / 3072, doubled; a test sweeps it.
    static constexpr double max_error_rad = 1.5e-8;

    // As geocentric(julian_centuries(tt_j2000_s)). Precondition: |tt_j2000_s| < 1e12.
    [[nodiscard]] Geocentric at(double tt_j2000_s);

    // How many spans were filled so far, each for four times the cost of geocentric().
    [[nodiscard]] std::uint64_t fills() const noexcept { return fills_; }

private:
    // Sun and moon; x and z axes of the moon's body and of J2000; the equation of the equinoxes in the last one's x.
    static constexpr std::size_t vectors = 7;
    using Sample = std::array<glm::dvec3, vectors>;
    struct Span {
        std::int64_t index = INT64_MIN;
        std::array<Sample, 4> coefficient; // of powers of the time in half spans from the middle
    };
    void fill(Span& span, std::int64_t index);

    std::array<Span, 4> spans_;
    std::uint64_t fills_ = 0;
};

} // namespace alpenglow::ephemeris
