#include <alpenglow/clouds/beam.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/parallel_for.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>

namespace alpenglow::clouds {
namespace {

// The angle that a table has to resolve: the width of the forward peak.
double peak_width(const Phase& phase) {
    const double g = phase.kind == PhaseKind::rayleigh ? 0.0
                     : phase.kind == PhaseKind::double_henyey_greenstein
                         ? std::max(std::abs(double(phase.g)), std::abs(double(phase.g2)))
                         : std::abs(double(phase.g));
    return std::clamp(0.5 * (1.0 - g), 2e-4, 0.5);
}

double one_minus_cos(double angle) {
    const double s = std::sin(0.5 * angle);
    return 2.0 * s * s;
}

} // namespace

ScaledMedium scaled_medium(const Medium& medium) {
    std::array<double, 5> chi{};
    phase_moments(medium.phase, chi);
    const double albedo = std::clamp(double(medium.albedo), 0.0, 1.0);
    ScaledMedium out;
    double f = std::max(0.0, chi[4]);
    for (std::size_t l = 1; l < 4; ++l) {
        if (chi[l] < f) { // a backward or a many-lobed phase function
            f = 0.0;
        }
    }
    out.forward = f;
    out.extinction = 1.0 - albedo * f;
    out.albedo = albedo * (1.0 - f) / out.extinction;
    for (std::size_t l = 0; l < 4; ++l) {
        out.moments[l] = (chi[l] - f) / (1.0 - f);
    }
    return out;
}

void BeamTable::resize(double decay, double max_depth, double narrow) {
    decay_ = static_cast<float>(decay);
    max_depth_ = static_cast<float>(max_depth);
    narrow_ = static_cast<float>(narrow);
    values_.assign(std::size_t(angles) * depths, 0.0F);
}

double BeamTable::depth_at(int i, double max_depth) {
    const double u = double(i) / (depths - 1);
    return max_depth * u * u;
}

double BeamTable::angle_at(int i, double narrow) {
    return narrow * std::sinh(double(i) / (angles - 1) * std::asinh(pi / narrow));
}

float BeamTable::angle_coordinate(float omc, float narrow) {
    const float sine = std::sqrt(std::clamp(0.5F * omc, 0.0F, 1.0F));
    const float angle = 2.0F * std::asin(sine);
    const float scale = static_cast<float>(angles - 1) / std::asinh(static_cast<float>(pi) / narrow);
    return std::clamp(std::asinh(angle / narrow) * scale, 0.0F, static_cast<float>(angles - 1));
}

float BeamTable::value(float depth, float omc) const {
    const float a = angle_coordinate(omc);
    const int ia = std::min(static_cast<int>(a), angles - 2);
    const float u = std::min(std::sqrt(std::max(depth, 0.0F) / max_depth_), 1.0F) * static_cast<float>(depths - 1);
    const int iu = std::min(static_cast<int>(u), depths - 2);
    const float ta = a - static_cast<float>(ia);
    const float tu = u - static_cast<float>(iu);
    const float* row = values_.data() + std::size_t(ia) * depths + std::size_t(iu);
    const float low = row[0] + tu * (row[1] - row[0]);
    const float high = row[depths] + tu * (row[depths + 1] - row[depths]);
    return std::exp(-decay_ * depth) * (low + ta * (high - low));
}

BeamTable BeamTable::product(double decay, double max_depth, double narrow, const std::vector<double>& of_depth,
                             const std::vector<double>& of_angle) {
    BeamTable table;
    table.resize(decay, max_depth, narrow);
    for (std::size_t a = 0; a < angles; ++a) {
        for (std::size_t d = 0; d < depths; ++d) {
            table.values_[a * depths + d] = static_cast<float>(of_depth[d] * of_angle[a]);
        }
    }
    return table;
}

BeamTable BeamTable::single_scattering(const Medium& medium) {
    const double narrow = peak_width(medium.phase);
    std::vector<double> of_angle(angles);
    for (int a = 0; a < angles; ++a) {
        of_angle[std::size_t(a)] =
            double(medium.albedo) *
            double(phase_value(medium.phase, static_cast<float>(one_minus_cos(angle_at(a, narrow)))));
    }
    return product(1.0, 64.0, narrow, std::vector<double>(depths, 1.0), of_angle);
}

BeamTable BeamTable::octaves(const Medium& medium, const Octaves& o) {
    BeamTable table;
    const double last = std::pow(double(o.extinction), o.count - 1);
    table.resize(last, 128.0, peak_width(medium.phase));
    for (int a = 0; a < angles; ++a) {
        const auto omc = static_cast<float>(one_minus_cos(angle_at(a, double(table.narrow_))));
        for (int d = 0; d < depths; ++d) {
            const double depth = depth_at(d, double(table.max_depth_));
            double sum = 0.0;
            for (int i = 0; i < o.count; ++i) {
                Phase phase = medium.phase;
                phase.g *= std::pow(o.phase, static_cast<float>(i));
                phase.g2 *= std::pow(o.phase, static_cast<float>(i));
                sum += std::pow(double(o.scatter), i) * double(medium.albedo) * double(phase_value(phase, omc)) *
                       std::exp((last - std::pow(double(o.extinction), i)) * depth);
            }
            table.values_[std::size_t(a) * depths + std::size_t(d)] = static_cast<float>(sum);
        }
    }
    return table;
}

BeamTable BeamTable::broadened(const Medium& medium) {
    // Peaks narrower than a series of this length resolves are widened: beyond |g| = 0.995 the table is that of 0.995.
    constexpr int terms = 1536;
    Medium held = medium;
    held.phase.g = std::clamp(held.phase.g, -0.995F, 0.995F);
    held.phase.g2 = std::clamp(held.phase.g2, -0.995F, 0.995F);
    const ScaledMedium scaled = scaled_medium(medium);
    const ScaledMedium scaled_held = scaled_medium(held);
    const double albedo = std::clamp(double(medium.albedo), 0.0, 1.0);
    const double f = scaled_held.forward;
    std::vector<double> chi(terms);
    phase_moments(held.phase, chi);
    int used = terms;
    while (used > 8 && std::abs(chi[std::size_t(used - 1)]) < 1e-9) {
        --used;
    }
    BeamTable table;
    table.resize(scaled.extinction, std::clamp(24.0 / scaled_held.extinction, 48.0, 300.0), peak_width(held.phase));
    // coefficient[depth][l], with exp(-decay * depth) taken out.
    std::vector<double> coefficients(std::size_t(depths) * std::size_t(used));
    for (int d = 0; d < depths; ++d) {
        const double tau = depth_at(d, double(table.max_depth_));
        const double unscattered = std::exp(-albedo * f * tau); // exp(-tau) over exp(-decay tau)
        for (int l = 0; l < used; ++l) {
            const double x = chi[std::size_t(l)];
            const double retained = l <= 3 ? f : x;
            const double beam = std::exp(-albedo * (f - retained) * tau); // B_l over exp(-decay tau)
            // A smooth end of the series for peaks that it only just resolves.
            const double taper = l < used / 2 || std::abs(chi[std::size_t(used - 1)]) < 1e-8
                                     ? 1.0
                                     : 0.5 + 0.5 * std::cos(pi * (2.0 * double(l) / used - 1.0));
            coefficients[std::size_t(d) * std::size_t(used) + std::size_t(l)] =
                taper * albedo * (2.0 * l + 1.0) / (4.0 * pi) * ((x - f) * beam + f * unscattered);
        }
    }
    parallel_for(angles, 8, [&](std::size_t begin, std::size_t end) {
        std::vector<double> legendre(static_cast<std::size_t>(used));
        for (std::size_t a = begin; a < end; ++a) {
            const double c = std::cos(angle_at(static_cast<int>(a), double(table.narrow_)));
            legendre[0] = 1.0;
            legendre[1] = c;
            for (int l = 2; l < used; ++l) {
                legendre[std::size_t(l)] =
                    ((2.0 * l - 1.0) * c * legendre[std::size_t(l - 1)] - (l - 1.0) * legendre[std::size_t(l - 2)]) / l;
            }
            for (std::size_t d = 0; d < depths; ++d) {
                const double* row = coefficients.data() + d * std::size_t(used);
                double sum = 0.0;
                for (std::size_t l = 0; l < std::size_t(used); ++l) {
                    sum += row[l] * legendre[l];
                }
                table.values_[a * depths + d] = static_cast<float>(sum);
            }
        }
    });
    return table;
}

} // namespace alpenglow::clouds
