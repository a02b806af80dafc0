#include <alpenglow/sky/horizon_filter.hpp>

#include <alpenglow/core/constants.hpp>
#include <alpenglow/sh/basis.hpp>

#include <cassert>
#include <cmath>
#include <cstddef>

namespace alpenglow::sky {
namespace {

constexpr std::size_t stride = 7;

template <class Vec>
void sinc(int bands, std::span<Vec> c) {
    for (int l = 1; l < bands; ++l) {
        const double x = pi * l / bands;
        c[static_cast<std::size_t>(l * (l + 1))] *= static_cast<typename Vec::value_type>(std::sin(x) / x);
    }
}

template <class Vec>
void multiply(int bands, const std::array<std::array<double, 49>, 7>& matrix, std::span<Vec> c) {
    for (int m = -(bands - 1); m < bands; ++m) {
        const int a = std::abs(m);
        std::array<Vec, 7> column{};
        for (int l = a; l < bands; ++l) {
            Vec sum(0);
            for (int k = a; k < bands; ++k) {
                sum += static_cast<typename Vec::value_type>(matrix[static_cast<std::size_t>(
                           a)][static_cast<std::size_t>(l - a) * stride + static_cast<std::size_t>(k - a)]) *
                       c[static_cast<std::size_t>(k * (k + 1) + m)];
            }
            column[static_cast<std::size_t>(l)] = sum;
        }
        for (int l = a; l < bands; ++l) {
            c[static_cast<std::size_t>(l * (l + 1) + m)] = column[static_cast<std::size_t>(l)];
        }
    }
}

} // namespace

void filter_zonal_sinc(int bands, std::span<glm::dvec3> coefficients) {
    sinc(bands, coefficients);
}
void filter_zonal_sinc(int bands, std::span<glm::vec3> coefficients) {
    sinc(bands, coefficients);
}

HorizonFilter::HorizonFilter(int bands, double weight) : bands_(bands) {
    assert(bands >= 1 && bands <= 7 && weight >= 0.0);
    // Overlaps below the horizon: the product of two functions of the same m is a polynomial in z of degree 12 at most,
    // so that this many nodes are exact. At azimuth 0 the basis gives the shape over z; its square over azimuth is 2 pi
    // or pi.
    constexpr int nodes = 16;
    std::array<std::array<double, 49>, 7> system{};
    for (int i = 0; i < nodes; ++i) {
        double x = std::cos(pi * (i + 0.75) / (nodes + 0.5));
        double derivative = 1.0;
        for (int step = 0; step < 30; ++step) {
            double p0 = 1.0;
            double p1 = x;
            for (int k = 2; k <= nodes; ++k) {
                const double p2 = ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            derivative = nodes * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / derivative;
        }
        const double z = -0.5 * (1.0 + x);
        const double w = 1.0 / ((1.0 - x * x) * derivative * derivative);
        std::array<double, sh::max_coefficients> y{};
        sh::evaluate_basis(bands, glm::dvec3(std::sqrt(1.0 - z * z), 0.0, z), y);
        for (int m = 0; m < bands; ++m) {
            for (int l = m; l < bands; ++l) {
                for (int k = m; k < bands; ++k) {
                    system[static_cast<std::size_t>(m)]
                          [static_cast<std::size_t>(l - m) * stride + static_cast<std::size_t>(k - m)] +=
                        (weight - 1.0) * w * (m == 0 ? two_pi : pi) * y[static_cast<std::size_t>(sh::index(l, m))] *
                        y[static_cast<std::size_t>(sh::index(k, m))];
                }
            }
        }
    }
    // Inverses by Gauss-Jordan; symmetric positive definite, no pivoting.
    for (int m = 0; m < bands; ++m) {
        const auto n = static_cast<std::size_t>(bands - m);
        auto& a = system[static_cast<std::size_t>(m)];
        auto& inverse = matrix_[static_cast<std::size_t>(m)];
        for (std::size_t i = 0; i < n; ++i) {
            a[i * stride + i] += 1.0;
            inverse[i * stride + i] = 1.0;
        }
        for (std::size_t p = 0; p < n; ++p) {
            const double pivot = 1.0 / a[p * stride + p];
            for (std::size_t j = 0; j < n; ++j) {
                a[p * stride + j] *= pivot;
                inverse[p * stride + j] *= pivot;
            }
            for (std::size_t i = 0; i < n; ++i) {
                if (i != p) {
                    const double q = a[i * stride + p];
                    for (std::size_t j = 0; j < n; ++j) {
                        a[i * stride + j] -= q * a[p * stride + j];
                        inverse[i * stride + j] -= q * inverse[p * stride + j];
                    }
                }
            }
        }
    }
}

void HorizonFilter::apply(std::span<glm::dvec3> coefficients) const {
    multiply(bands_, matrix_, coefficients);
}
void HorizonFilter::apply(std::span<glm::vec3> coefficients) const {
    multiply(bands_, matrix_, coefficients);
}

namespace {

template <class F>
SkyFit with_rows_filtered(const SkyFit& fit, int bands, const F& filter) {
    assert(bands >= 1 && bands <= fit.bands);
    SkyFit out = fit;
    out.bands = bands;
    const std::size_t from = fit.functions();
    std::array<glm::dvec3, 49> c{};
    for (std::size_t p = 0; p < fit.parts.size(); ++p) {
        const std::vector<float>& rows = fit.parts[p].rows;
        std::vector<float>& filtered = out.parts[p].rows;
        filtered.clear();
        for (std::size_t row = 0; row < rows.size(); row += from) {
            // A row's first functions are those of the first bands.
            const float* in = rows.data() + row;
            for (int l = 0; l < bands; ++l) {
                for (int m = 0; m <= l; ++m, in += 3) {
                    c[static_cast<std::size_t>(l * (l + 1) + m)] = glm::dvec3(in[0], in[1], in[2]);
                }
            }
            filter(std::span(c).first(static_cast<std::size_t>(bands * bands)));
            for (int l = 0; l < bands; ++l) {
                for (int m = 0; m <= l; ++m) {
                    const glm::dvec3& value = c[static_cast<std::size_t>(l * (l + 1) + m)];
                    for (int k = 0; k < 3; ++k) {
                        filtered.push_back(static_cast<float>(value[k]));
                    }
                }
            }
        }
        assert(filtered.size() * from == rows.size() * out.functions());
    }
    return out;
}

} // namespace

SkyFit filtered_fit(const SkyFit& fit, const HorizonFilter& filter) {
    return with_rows_filtered(fit, filter.bands(), [&](std::span<glm::dvec3> c) { filter.apply(c); });
}
SkyFit filtered_fit_zonal_sinc(const SkyFit& fit, int bands) {
    return with_rows_filtered(fit, bands, [&](std::span<glm::dvec3> c) { filter_zonal_sinc(bands, c); });
}

} // namespace alpenglow::sky
