#pragma once

#include <alpenglow/prt/transfer_table.hpp>
#include <alpenglow/sh/basis.hpp>

#include <cmath>
#include <random>
#include <span>
#include <vector>

namespace alpenglow::prt::test {

inline double norm(std::span<const float> v) {
    double sum = 0.0;
    for (const float x : v) {
        sum += static_cast<double>(x) * static_cast<double>(x);
    }
    return std::sqrt(sum);
}

inline double distance(std::span<const float> a, std::span<const float> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
        sum += d * d;
    }
    return std::sqrt(sum);
}

// RMS over points of |a - b| / |unoccluded|.
inline double rms(const TransferField& a, const TransferField& b, double unoccluded_norm) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.count; ++i) {
        const double d = distance(a.point(i), b.point(i)) / unoccluded_norm;
        sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(a.count));
}

// Response to light 1 from everywhere.
inline double white(std::span<const float> m) {
    return static_cast<double>(m[0]) * std::sqrt(4.0 * 3.14159265358979);
}

inline std::vector<glm::vec3> random_light(int order, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<float> value;
    std::vector<glm::vec3> light(static_cast<std::size_t>(order * order));
    for (glm::vec3& c : light) {
        c = {value(generator), value(generator), value(generator)};
    }
    return light;
}

inline TransferField random_field(int order, int out_order, int channels, std::size_t count, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<float> value(0.0F, 0.3F);
    TransferField field;
    field.kind = out_order == 0 ? TransferKind::mesh : TransferKind::glossy;
    field.order = order;
    field.out_order = out_order;
    field.channels = channels;
    field.count = count;
    field.values.resize(count * field.width());
    for (float& x : field.values) {
        x = value(generator);
    }
    return field;
}

} // namespace alpenglow::prt::test
