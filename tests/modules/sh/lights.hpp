// Random order 3 lights that ring: suns, lobes, skies, discs, and near-degenerate ones.
#pragma once

#include "support.hpp"

#include <alpenglow/sh/zonal.hpp>

#include <array>

namespace alpenglow::sh::test {

inline std::vector<double> random_light(Random& random, int order = 3) {
    std::vector<double> f(static_cast<std::size_t>(coefficient_count(order)), 0.0);
    std::array<double, max_order> z{};
    switch (static_cast<int>(random.uniform(0.0, 6.999))) {
    case 0: // one to four suns
        for (int i = 0, n = 1 + static_cast<int>(random.uniform(0.0, 3.999)); i < n; ++i) {
            zonal_delta(order, z);
            add_zonal(order, z, random.direction(), std::exp(random.uniform(-3.0, 3.0)), f);
        }
        break;
    case 1: // a sky and a sun
        zonal_hemisphere(order, 1.0, random.uniform(0.0, 0.5), z);
        add_zonal(order, z, glm::dvec3(0.0, 0.0, 1.0), 1.0, f);
        zonal_delta(order, z);
        add_zonal(order, z, random.direction(), std::exp(random.uniform(-4.0, 3.0)), f);
        break;
    case 2: // discs and soft lobes
        for (int i = 0; i < 3; ++i) {
            random.uniform(0.0, 1.0) < 0.5 ? zonal_disc(order, random.uniform(0.01, 2.0), z)
                                           : zonal_cone(order, random.uniform(0.1, 3.0), z);
            add_zonal(order, z, random.direction(), 1.0, f);
        }
        break;
    case 3: { // anything with a positive mean
        f = random.coefficients(order);
        f[0] = std::exp(random.uniform(-6.0, 2.0));
        break;
    }
    case 4: { // a zero linear band, or one along an axis
        f = random.coefficients(order);
        f[0] = std::exp(random.uniform(-2.0, 1.0));
        f[1] = f[2] = f[3] = 0.0;
        if (const int axis = static_cast<int>(random.uniform(0.0, 3.999)); axis > 0) {
            f[static_cast<std::size_t>(axis)] = random.normal();
        }
        break;
    }
    case 5: { // zonal about a coordinate axis, to a hair: equal eigenvalues
        zonal_delta(order, z);
        glm::dvec3 axis(0.0);
        axis[static_cast<int>(random.uniform(0.0, 2.999))] = random.uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
        add_zonal(order, z, axis, 1.0, f);
        for (double& c : f) {
            c *= 1.0 + 1e-7 * random.normal();
        }
        f[0] *= random.uniform(0.5, 3.0);
        break;
    }
    default: { // two opposite suns: no linear band, a ring of minima
        const glm::dvec3 d = random.direction();
        zonal_delta(order, z);
        add_zonal(order, z, d, 1.0, f);
        add_zonal(order, z, -d, random.uniform(0.9, 1.1), f);
        break;
    }
    }
    const double scale = std::exp(random.uniform(-5.0, 20.0));
    for (double& c : f) {
        c *= scale;
    }
    return f;
}

} // namespace alpenglow::sh::test
