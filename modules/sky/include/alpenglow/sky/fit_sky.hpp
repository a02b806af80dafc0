// The fitting tool: any sky as a black box -> a SkyFit with its error report.
#pragma once

#include <alpenglow/core/result.hpp>
#include <alpenglow/sky/sky_fit.hpp>

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace alpenglow::sky {

// A sky's coefficients for parameters in the order of the axes: bands * bands values for a sun in the +X meridian (m <
// 0 is not read), converged. Returns the least luminance over the sky, L_min of the error measures, > 0.
using SkyBlackBox =
    std::function<double(std::span<const double> parameters, int bands, std::span<glm::dvec3> coefficients)>;

struct SkyFitBox {
    std::vector<FitAxis> axes;
    std::vector<int> nodes;   // Chebyshev nodes an axis, 2 .. 64: degrees up to nodes - 1
    double max_e_mean = 5e-5; // E_mean that pruning may reach, as a fraction: all bands; 0.4 of it at 3, 0.6 at 5
};

struct SkyFitReport {
    double worst_e_mean = 0.0; // Habel et al. 2008, eq. 3: over channels, nodes; fractions, not percent
    double worst_e_max = 0.0;  // eq. 2
    double mean_e_mean = 0.0;
    std::size_t samples = 0;
    std::size_t rows = 0; // kept
};

// Samples the box, fits and prunes: rows are dropped, smallest first, while the worst E_mean over the nodes stays
// within max_e_mean. Samples in parallel; the result does not depend on the number of threads.
[[nodiscard]] Result<SkyFitPart> fit_sky_box(const SkyFitBox& box, FitNormaliser normaliser, int bands,
                                             const SkyBlackBox& sky, SkyFitReport& report);

// E_mean and E_max of a fit against the black box at one set of parameters (worst channel).
struct FitError {
    double e_mean, e_max;
};
[[nodiscard]] FitError fit_error(const SkyFit& fit, std::span<const double> parameters, int bands,
                                 const SkyBlackBox& sky);

// Preetham's sky as a black box: parameters are the sun's zenith angle and the turbidity.
[[nodiscard]] SkyBlackBox preetham_black_box(int elevations, int azimuths);

// The scattering atmosphere as a black box: parameters are the sun's zenith angle (0 .. 108 degrees), the turbidity and
// a grey ground albedo; `height_km` the observer's. Built from fine tables, which are kept for each turbidity and
// albedo.
[[nodiscard]] SkyBlackBox scattering_black_box(double height_km, int elevations, int azimuths);

// The fit as a C header: plain arrays `NAME_...` for sky_fit_eval.h, the evaluator for other engines
// (modules/sky/export).
[[nodiscard]] std::string fit_as_c_header(const SkyFit& fit, const std::string& name);

} // namespace alpenglow::sky
