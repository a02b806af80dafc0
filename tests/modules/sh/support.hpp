// Seeded random directions, rotations and coefficient vectors for the tests of this module.
#pragma once

#include <alpenglow/sh/basis.hpp>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

namespace alpenglow::sh::test {

class Random {
public:
    explicit Random(unsigned seed) : engine_(seed) {}

    double uniform(double low, double high) {
        return low + (high - low) * (static_cast<double>(engine_()) / 4294967296.0);
    }
    double normal() {
        return std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0))) * std::cos(6.283185307179586 * uniform(0.0, 1.0));
    }
    glm::dvec3 direction() { return glm::normalize(glm::dvec3(normal(), normal(), normal())); }
    glm::dquat rotation() { return glm::normalize(glm::dquat(normal(), normal(), normal(), normal())); }
    std::vector<double> coefficients(int order) {
        std::vector<double> c(static_cast<std::size_t>(coefficient_count(order)));
        std::generate(c.begin(), c.end(), [this] { return normal(); });
        return c;
    }

private:
    std::mt19937 engine_;
};

inline std::vector<float> to_float(const std::vector<double>& values) {
    return std::vector<float>(values.begin(), values.end());
}

template <class A, class B>
double distance(const A& a, const B& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
        sum += d * d;
    }
    return std::sqrt(sum);
}

template <class A>
double norm(const A& a) {
    double sum = 0.0;
    for (const auto v : a) {
        sum += static_cast<double>(v) * static_cast<double>(v);
    }
    return std::sqrt(sum);
}

} // namespace alpenglow::sh::test
