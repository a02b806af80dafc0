// Sky -> spherical harmonics by a fitted table: microseconds of quadrature become a few hundred multiplications.
//
// After Habel, Mustata and Wimmer 2008, "Efficient Spherical Harmonics Lighting with the Preetham Skylight Model": the
// azimuth is a rotation about z, the coefficients are smooth in the sun's zenith angle and the other parameters.
// Instead of the paper's monomials (condition number near 1e19) the basis is Chebyshev in tan(theta/2) and in
// log(turbidity - 1.2), the smooth bulk of the brightness is divided out first, and only the products of degrees that
// matter are kept.
#pragma once

#include <alpenglow/core/result.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace alpenglow::sky {

// How a parameter becomes the Chebyshev variable before it is scaled to -1 .. 1.
enum class FitMap : std::uint32_t {
    linear = 0,       // x
    half_tangent = 1, // tan(x / 2): for the sun's zenith angle, free of trigonometry when it comes from a vector
    log_offset = 2    // log(x - offset)
};

struct FitAxis {
    FitMap map = FitMap::linear;
    double low = 0.0, high = 1.0; // the parameter's range, in its own unit
    double offset = 0.0;          // of log_offset
};

// The factor that is divided out before fitting.
enum class FitNormaliser : std::uint32_t {
    none = 0,
    preetham = 1, // close to Preetham's zenith luminance over F(0, theta_s); axis 1 is the turbidity
    exponent = 2  // e to a small table of its own
};

inline constexpr std::size_t max_fit_axes = 4;
inline constexpr std::size_t max_fit_functions = 84; // 28 pairs (l, m >= 0) of 7 bands x R, G, B

// Fits over a box of parameters. Axis 0 is the sun's zenith angle. A row holds, for one product of Chebyshev degrees,
// the coefficients of all functions, ordered by band l, then m = 0 .. l, then channel; rows are sorted by the degree in
// axis 0.
struct SkyFitPart {
    std::vector<FitAxis> axes;
    std::vector<std::uint8_t> degrees;     // rows x axes
    std::vector<float> rows;               // rows x functions
    std::vector<std::uint8_t> log_degrees; // of the exponent normaliser: terms x axes
    std::vector<float> log_terms;
};

struct SkyFit {
    FitNormaliser normaliser = FitNormaliser::none;
    int bands = 0;
    std::vector<SkyFitPart> parts; // boxes that together cover the domain

    [[nodiscard]] std::size_t functions() const { return static_cast<std::size_t>(3 * bands * (bands + 1) / 2); }
    [[nodiscard]] std::size_t bytes() const; // of coefficients and degrees
};

// The table as bytes, and back; little-endian. Reading checks sizes, ranges and a checksum, and says what is wrong.
enum class FitStorage : std::uint32_t {
    float32 = 1,
    int16 = 2 // all but the largest rows in 16 bits with a scale each: about half the size
};
[[nodiscard]] std::vector<std::uint8_t> write_fit(const SkyFit& fit, FitStorage storage = FitStorage::float32);
[[nodiscard]] Result<SkyFit> read_fit(std::span<const std::uint8_t> bytes, const std::string& name);

// The shipped fits. Preetham: turbidity 2 .. 10, sun from the zenith to the horizon, 7 bands; worst E_mean (Habel et
// al. eq. 3, least luminance of the sky as L_min) in docs/sky.md.
[[nodiscard]] const SkyFit& preetham_fit();

// The scattering atmosphere at sea level: sun from the zenith to 18 degrees below the horizon, turbidity 2 .. 8, grey
// ground albedo 0 .. 0.8; 7 bands. Axes: zenith angle, turbidity, albedo.
[[nodiscard]] const SkyFit& scattering_fit();

// Straight evaluation in double precision, the reference for SkyFitEvaluator. Parameters as the axes name them (angles
// in radians), held at the ends of the domain. Writes bands * bands coefficients for a sun in the +X meridian.
void evaluate_fit(const SkyFit& fit, std::span<const double> parameters, int bands, std::span<glm::dvec3> out);

// Evaluates a fit in single precision with the widest SIMD at hand, and keeps, part by part, the sums over every
// parameter but the sun's angle while those stay the same. Holds a reference to the fit. Error against evaluate_fit:
// 2e-6 of the vector's norm, 1e-5 where the normaliser is an exponent.
class SkyFitEvaluator {
public:
    explicit SkyFitEvaluator(const SkyFit& fit);

    // Bands 1 .. fit.bands, in the frame of `to_sun` (unit, local), azimuth applied. `others` are the parameters after
    // the sun's angle, held at the ends of the domain, as is the sun. out holds bands * bands values or more.
    void evaluate(const glm::vec3& to_sun, std::span<const float> others, int bands, std::span<glm::vec3> out);

    // Once through, without looking at or filling the cache: for parameters that change every time.
    void evaluate_uncached(const glm::vec3& to_sun, std::span<const float> others, int bands,
                           std::span<glm::vec3> out) const;

    struct Free {
        void operator()(float* p) const noexcept;
    };
    using Floats = std::unique_ptr<float[], Free>;

private:
    struct Part {
        Floats rows;                                              // padded to whole vectors
        std::vector<std::int32_t> first;                          // first row of each degree in axis 0, and the end
        std::vector<std::int16_t> position;                       // of two axes: where rows find their weights
        std::array<float, max_fit_axes> low{}, high{};            // of axis 0: tan(theta / 2)
        std::array<float, max_fit_axes> scale{}, shift{};         // mapped parameter -> Chebyshev variable
        std::array<std::size_t, max_fit_axes> most{}, log_most{}; // largest degrees
    };
    struct Normaliser {
        float zenith_slope = 0, zenith_offset = 0, chi_slope = 0, horizon = 1, c = 0, d = 0, e = 0;
    };
    static constexpr std::size_t factor_terms = 16;
    struct Cache {
        std::array<float, max_fit_axes> others{};
        int bands = 0;
        Normaliser normaliser{};
        std::array<float, factor_terms> factor{}; // Chebyshev series of what was divided out, over the sun's variable
        bool series = false;                      // whether it holds to single precision
        Floats sums;                              // over all axes but the first
    };
    struct Sun;
    [[nodiscard]] static float fast_variable(const Part& part, const FitAxis& axis, std::size_t a, float x);
    [[nodiscard]] std::size_t part_for(float half_tangent, std::span<const float> others) const;
    void cut_into_cells();
    void weights(std::size_t part, std::span<const float> others, float* out, Normaliser& normaliser) const;
    [[nodiscard]] float factor(std::size_t part, float x, float r, float z, std::span<const float> others,
                               const Normaliser& normaliser) const;
    void fill(std::size_t part, std::span<const float> others, int bands);

    const SkyFit* fit_;
    std::vector<Part> parts_;
    std::vector<Cache> caches_; // one for each part
    // The parts' borders cut every axis; which part holds a cell of the grid that they make, axis 0 slowest.
    std::array<std::vector<float>, max_fit_axes> cuts_;
    std::vector<std::uint16_t> cells_;
};

} // namespace alpenglow::sky
