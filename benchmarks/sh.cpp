// Spherical harmonics: scalar reference in double, scalar float, and the batches, by order.
#include "bench.hpp"

#include <alpenglow/sh/basis.hpp>
#include <alpenglow/sh/rotate.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

constexpr std::size_t count = 1024;

std::vector<glm::vec3> random_directions(std::size_t n) {
    std::mt19937 engine(1);
    std::normal_distribution<float> normal;
    std::vector<glm::vec3> directions(n);
    for (glm::vec3& d : directions) {
        d = glm::normalize(glm::vec3(normal(engine), normal(engine), normal(engine)));
    }
    return directions;
}

void evaluate_basis(const Context& context) {
    const std::vector<glm::vec3> directions = random_directions(count);
    for (const int order : {3, 5, 6}) {
        double worst = 0.0;
        for (const glm::vec3& d : directions) {
            std::array<float, sh::max_coefficients> f{};
            std::array<double, sh::max_coefficients> y{};
            sh::evaluate_basis(order, d, f);
            sh::evaluate_basis(order, glm::dvec3(d), y);
            for (std::size_t i = 0; i < y.size(); ++i) {
                worst = std::max(worst, std::abs(static_cast<double>(f[i]) - y[i]));
            }
        }
        Row row;
        row.module = "sh";
        row.name = "evaluate basis, order " + std::to_string(order);
        row.error_metric = "max absolute over 1024 random directions and all coefficients";
        row.reference = "scalar double";
        row.items = static_cast<double>(count);
        row.method = "scalar double";
        context.run(row, [&] {
            std::array<double, sh::max_coefficients> y;
            for (const glm::vec3& d : directions) {
                sh::evaluate_basis(order, glm::dvec3(d), y);
                keep(y);
            }
        });
        row.method = "scalar float";
        row.error = worst;
        context.run(row, [&] {
            std::array<float, sh::max_coefficients> y;
            for (const glm::vec3& d : directions) {
                sh::evaluate_basis(order, d, y);
                keep(y);
            }
        });
    }
}

const Case evaluate_basis_case("sh/evaluate-basis", evaluate_basis);

} // namespace
} // namespace alpenglow::bench
