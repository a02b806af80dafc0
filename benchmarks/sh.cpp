// Spherical harmonics: the scalar references and the batches on each instruction set, time against error, by order.
#include "bench.hpp"

#include <alpenglow/sh/batch.hpp>
#include <alpenglow/sh/dering_batch.hpp>
#include <alpenglow/sh/image.hpp>
#include <alpenglow/sh/irradiance.hpp>
#include <alpenglow/sh/product.hpp>
#include <alpenglow/sh/project.hpp>
#include <alpenglow/sh/zonal.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

using sh::Batch;
using sh::BatchBuffer;
using sh::ConstBatch;

constexpr std::size_t count = 256; // one batch: stays in the second-level cache at every order

struct Random {
    std::mt19937 engine{1};
    std::normal_distribution<double> gauss;
    double normal() { return gauss(engine); }
    double uniform() { return static_cast<double>(engine()) / 4294967296.0; }
    glm::dvec3 direction() { return glm::normalize(glm::dvec3(normal(), normal(), normal())); }
    void fill(BatchBuffer& b) {
        for (std::size_t i = 0; i < b.rows(); ++i) {
            std::generate_n(b.row(i), b.count(), [this] { return static_cast<float>(normal()); });
        }
    }
    BatchBuffer directions(std::size_t n) {
        BatchBuffer b(3, n);
        for (std::size_t k = 0; k < n; ++k) {
            const glm::vec3 d(direction());
            b.row(0)[k] = d.x;
            b.row(1)[k] = d.y;
            b.row(2)[k] = d.z;
        }
        return b;
    }
};

std::vector<double> item(const BatchBuffer& b, std::size_t k) {
    std::vector<double> v(b.rows());
    for (std::size_t i = 0; i < v.size(); ++i) {
        v[i] = static_cast<double>(b.row(i)[k]);
    }
    return v;
}

double norm(const std::vector<double>& v) {
    double sum = 0.0;
    for (const double x : v) {
        sum += x * x;
    }
    return std::sqrt(sum);
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> d(a);
    for (std::size_t i = 0; i < d.size(); ++i) {
        d[i] -= b[i];
    }
    return norm(d);
}

// Adds a row for each instruction set that the machine has. `error` is evaluated after a run on that set. `one_lane`:
// the same code in plain scalar float too, which is the like-for-like scalar of the batch.
void run_batches(const Context& context, Row row, const std::function<void()>& call,
                 const std::function<double()>& error, bool one_lane = false) {
    for (const auto& [target, name] :
         {std::pair{sh::BatchTarget::scalar, "batch, one lane"}, std::pair{sh::BatchTarget::sse4, "batch SSE4"},
          std::pair{sh::BatchTarget::avx2, "batch AVX2"}, std::pair{sh::BatchTarget::avx512, "batch AVX-512"}}) {
        if ((one_lane || target != sh::BatchTarget::scalar) && sh::limit_batch_target(target)) {
            row.method = name;
            call();
            row.error = error();
            context.run(row, call);
        }
    }
    sh::limit_batch_target(sh::BatchTarget::best);
}

Row make_row(const std::string& name, int order, const std::string& metric) {
    Row row;
    row.module = "sh";
    row.name = name + ", order " + std::to_string(order);
    row.method = "scalar double";
    row.error_metric = metric;
    row.reference = "scalar double";
    row.items = static_cast<double>(count);
    return row;
}

void evaluate_basis(const Context& context) {
    Random random;
    const BatchBuffer d = random.directions(count);
    for (const int order : {2, 3, 4, 5, 6}) {
        BatchBuffer y(static_cast<std::size_t>(order * order), count);
        Row row = make_row("evaluate basis", order, "max absolute, 256 random directions, all coefficients");
        const auto direction = [&](std::size_t k) { return glm::vec3(d.row(0)[k], d.row(1)[k], d.row(2)[k]); };
        context.run(row, [&] {
            std::array<double, sh::max_coefficients> out;
            for (std::size_t k = 0; k < count; ++k) {
                sh::evaluate_basis(order, glm::dvec3(direction(k)), out);
                keep(out);
            }
        });
        const auto worst = [&](auto&& value) {
            double w = 0.0;
            std::array<double, sh::max_coefficients> expected{};
            for (std::size_t k = 0; k < count; ++k) {
                sh::evaluate_basis(order, glm::dvec3(direction(k)), expected);
                for (std::size_t i = 0; i < y.rows(); ++i) {
                    w = std::max(w, std::abs(value(k, i) - expected[i]));
                }
            }
            return w;
        };
        row.method = "scalar float";
        row.error = worst([&](std::size_t k, std::size_t i) {
            std::array<float, sh::max_coefficients> out{};
            sh::evaluate_basis(order, direction(k), out);
            return static_cast<double>(out[i]);
        });
        context.run(row, [&] {
            std::array<float, sh::max_coefficients> out;
            for (std::size_t k = 0; k < count; ++k) {
                sh::evaluate_basis(order, direction(k), out);
                keep(out);
            }
        });
        run_batches(
            context, row, [&] { sh::evaluate_basis(order, d, y); },
            [&] { return worst([&](std::size_t k, std::size_t i) { return static_cast<double>(y.row(i)[k]); }); });
    }
}

void evaluate_dot(const Context& context) {
    Random random;
    const BatchBuffer d = random.directions(count);
    for (const int order : {3, 5, 6}) {
        BatchBuffer f(static_cast<std::size_t>(order * order), count), values(1, count);
        random.fill(f);
        const std::vector<double> first = item(f, 0);
        const std::vector<float> single(first.begin(), first.end());
        const auto direction = [&](std::size_t k) { return glm::dvec3(d.row(0)[k], d.row(1)[k], d.row(2)[k]); };
        Row row =
            make_row("evaluate and dot, one probe", order, "max over 256 random directions, relative to the norm");
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                keep(sh::evaluate(order, first, direction(k)));
            }
        });
        run_batches(
            context, row, [&] { sh::evaluate(order, single, d, values); },
            [&] {
                double w = 0.0;
                for (std::size_t k = 0; k < count; ++k) {
                    w = std::max(
                        w, std::abs(static_cast<double>(values.row(0)[k]) - sh::evaluate(order, first, direction(k))));
                }
                return w / norm(first);
            });
        row = make_row("evaluate and dot, own probes", order, "max over 256 random pairs, relative to the norm");
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                keep(sh::evaluate(order, item(f, k), direction(k)));
            }
        });
        run_batches(
            context, row, [&] { sh::evaluate(order, f.view(), d.view(), values.view()); },
            [&] {
                double w = 0.0;
                for (std::size_t k = 0; k < count; ++k) {
                    const std::vector<double> c = item(f, k);
                    w = std::max(
                        w, std::abs(static_cast<double>(values.row(0)[k]) - sh::evaluate(order, c, direction(k))) /
                               norm(c));
                }
                return w;
            });
    }
}

void products(const Context& context) {
    Random random;
    for (const int order : {2, 3, 4, 5, 6}) {
        BatchBuffer f(static_cast<std::size_t>(order * order), count), g(f.rows(), count), h(f.rows(), count);
        random.fill(f);
        random.fill(g);
        std::vector<std::vector<double>> fs, gs, expected;
        for (std::size_t k = 0; k < count; ++k) {
            fs.push_back(item(f, k));
            gs.push_back(item(g, k));
            expected.emplace_back(f.rows());
            sh::product(order, fs[k], gs[k], expected[k]);
        }
        Row row = make_row("product", order, "max L2 over 256 random pairs, relative to the norms");
        std::vector<double> out(f.rows());
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                sh::product(order, fs[k], gs[k], out);
                keep(out.front());
            }
        });
        run_batches(
            context, row, [&] { sh::product(order, f.view(), g.view(), h.view()); },
            [&] {
                double w = 0.0;
                for (std::size_t k = 0; k < count; ++k) {
                    w = std::max(w, distance(item(h, k), expected[k]) / (norm(fs[k]) * norm(gs[k])));
                }
                return w;
            });
    }
}

void triple_products(const Context& context) {
    Random random;
    for (const int order : {3, 4, 5, 6}) {
        BatchBuffer f(static_cast<std::size_t>(order * order), count), g(f.rows(), count), h(f.rows(), count);
        random.fill(f);
        random.fill(g);
        random.fill(h);
        BatchBuffer out(1, count), matrix(f.rows() * f.rows(), count);
        std::vector<std::vector<double>> fs, gs, hs, matrices;
        for (std::size_t k = 0; k < count; ++k) {
            fs.push_back(item(f, k));
            gs.push_back(item(g, k));
            hs.push_back(item(h, k));
        }
        Row row = make_row("triple product", order, "max over 256 random triples, relative to the norms");
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                keep(sh::triple_product(order, fs[k], gs[k], hs[k]));
            }
        });
        run_batches(
            context, row, [&] { sh::triple_product(order, f.view(), g.view(), h.view(), out.view()); },
            [&] {
                double w = 0.0;
                for (std::size_t k = 0; k < count; ++k) {
                    w = std::max(w, std::abs(static_cast<double>(out.row(0)[k]) -
                                             sh::triple_product(order, fs[k], gs[k], hs[k])) /
                                        (norm(fs[k]) * norm(gs[k]) * norm(hs[k])));
                }
                return w;
            });
        row = make_row("product matrix", order, "max L2 over 16 of 256 random vectors, relative to the norm");
        std::vector<double> expected(matrix.rows());
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                sh::product_matrix(order, fs[k], expected);
                keep(expected.front());
            }
        });
        run_batches(
            context, row, [&] { sh::product_matrix(order, f.view(), matrix.view()); },
            [&] {
                double w = 0.0;
                for (std::size_t k = 0; k < count; k += 16) {
                    sh::product_matrix(order, fs[k], expected);
                    w = std::max(w, distance(item(matrix, k), expected) / norm(fs[k]));
                }
                return w;
            });
    }
}

void project_samples(const Context& context) {
    constexpr std::size_t samples = 4096;
    Random random;
    const BatchBuffer d = random.directions(samples);
    BatchBuffer values(3, samples);
    random.fill(values);
    std::vector<float> weights(samples);
    std::vector<double> double_weights;
    std::vector<glm::dvec3> directions, colours;
    double total = 0.0;
    for (std::size_t k = 0; k < samples; ++k) {
        weights[k] = static_cast<float>(random.uniform());
        double_weights.push_back(static_cast<double>(weights[k]));
        directions.emplace_back(d.row(0)[k], d.row(1)[k], d.row(2)[k]);
        colours.emplace_back(values.row(0)[k], values.row(1)[k], values.row(2)[k]);
        total += double_weights[k] * glm::length(colours[k]);
    }
    for (const int order : {3, 5, 6}) {
        const auto n = static_cast<std::size_t>(order * order);
        std::vector<glm::dvec3> expected(n);
        std::vector<double> out(3 * n);
        Row row =
            make_row("project a sample, RGB", order, "max of a coefficient, relative to the sum of |weights values|");
        row.items = static_cast<double>(samples);
        context.run(row, [&] {
            sh::project_samples(order, directions, std::span<const glm::dvec3>(colours), double_weights,
                                std::span<glm::dvec3>(expected));
        });
        run_batches(
            context, row, [&] { sh::project_samples(order, d.view(), values.view(), 3, weights, out); },
            [&] {
                double w = 0.0;
                for (std::size_t i = 0; i < n; ++i) {
                    w = std::max(w, glm::length(glm::dvec3(out[i], out[n + i], out[2 * n + i]) - expected[i]));
                }
                return w / total;
            });
    }
}

void rotations(const Context& context) {
    Random random;
    for (const int order : {3, 5, 6}) {
        BatchBuffer f(static_cast<std::size_t>(order * order), count), g(f.rows(), count), q(4, count), turn(2, count);
        random.fill(f);
        random.fill(q);
        std::vector<std::vector<double>> fs;
        std::vector<glm::dquat> quaternions;
        for (std::size_t k = 0; k < count; ++k) {
            double length = 0.0;
            for (std::size_t i = 0; i < 4; ++i) {
                length = std::hypot(length, static_cast<double>(q.row(i)[k]));
            }
            // Half of them tiny tilts, 1e-7 to 1e-2 rad.
            if (k % 2 == 0) {
                const double tilt = 0.5 * std::pow(10.0, -7.0 + 5.0 * random.uniform());
                q.row(0)[k] = static_cast<float>(tilt * 0.8);
                q.row(1)[k] = static_cast<float>(tilt * -0.6);
                q.row(2)[k] = 0.0F;
                q.row(3)[k] = static_cast<float>(std::cos(tilt));
            } else {
                for (std::size_t i = 0; i < 4; ++i) {
                    q.row(i)[k] = static_cast<float>(static_cast<double>(q.row(i)[k]) / length);
                }
            }
            const std::vector<double> v = item(q, k);
            quaternions.emplace_back(v[3], v[0], v[1], v[2]);
            fs.push_back(item(f, k));
            turn.row(0)[k] = static_cast<float>(std::cos(static_cast<double>(k)));
            turn.row(1)[k] = static_cast<float>(std::sin(static_cast<double>(k)));
        }
        std::vector<double> out(f.rows());
        const auto worst = [&](auto&& reference) {
            double w = 0.0;
            for (std::size_t k = 0; k < count; ++k) {
                std::vector<double> expected(f.rows());
                reference(k, expected);
                w = std::max(w, distance(item(g, k), expected) / norm(fs[k]));
            }
            return w;
        };
        const sh::Rotation rotation(order, quaternions[1]);
        Row row = make_row("rotate, one rotation", order, "max L2 over 256 random vectors, relative to the norm");
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                rotation.apply(fs[k], out);
                keep(out.front());
            }
        });
        run_batches(
            context, row, [&] { sh::rotate(rotation, f, g); },
            [&] { return worst([&](std::size_t k, std::vector<double>& e) { rotation.apply(fs[k], e); }); });
        row = make_row("rotate, own rotations", order,
                       "max L2 over 256 rotations, half of them tilts of 1e-7 .. 1e-2, relative to the norm");
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                sh::Rotation(order, quaternions[k]).apply(fs[k], out);
                keep(out.front());
            }
        });
        run_batches(
            context, row, [&] { sh::rotate(order, q.view(), f.view(), g.view()); },
            [&] {
                return worst([&](std::size_t k, std::vector<double>& e) {
                    sh::Rotation(order, quaternions[k]).apply(fs[k], e);
                });
            });
        row = make_row("rotate about z", order, "max L2 over 256 angles, relative to the norm");
        context.run(row, [&] {
            for (std::size_t k = 0; k < count; ++k) {
                sh::rotate_z(order, static_cast<double>(k), fs[k], out);
                keep(out.front());
            }
        });
        run_batches(
            context, row, [&] { sh::rotate_z(order, turn.view(), f.view(), g.view()); },
            [&] {
                return worst([&](std::size_t k, std::vector<double>& e) {
                    sh::rotate_z(order, static_cast<double>(k), fs[k], e);
                });
            });
    }
}

void cube_maps(const Context& context) {
    for (const int size : {16, 64, 256}) {
        Random random;
        std::array<std::vector<float>, 6> pixels;
        sh::CubeMap map;
        map.size = size;
        for (std::size_t face = 0; face < 6; ++face) {
            pixels[face].resize(static_cast<std::size_t>(3 * size * size));
            std::generate(pixels[face].begin(), pixels[face].end(),
                          [&] { return static_cast<float>(random.uniform()); });
            map.faces[face] = pixels[face];
        }
        for (const int order : {3, 5}) {
            std::vector<glm::dvec3> expected(static_cast<std::size_t>(order * order));
            std::vector<glm::vec3> out(expected.size());
            Row row = make_row("project a cube map " + std::to_string(size) + "^2, RGB, a pixel", order,
                               "max absolute of a coefficient, relative to the mean's");
            row.items = 6.0 * size * size;
            context.run(row,
                        [&] { static_cast<void>(sh::project_reference(map, order, std::span<glm::dvec3>(expected))); });
            const sh::CubeProjector projector = *sh::CubeProjector::make(size, order);
            run_batches(
                context, row, [&] { static_cast<void>(projector.project(map, out)); },
                [&] {
                    double w = 0.0;
                    for (std::size_t i = 0; i < out.size(); ++i) {
                        w = std::max(w, glm::length(glm::dvec3(out[i]) - expected[i]));
                    }
                    return w / glm::length(expected[0]);
                });
        }
    }
}

// Lights that ring: suns over a sky, soft lobes, and near-degenerate ones.
BatchBuffer ringing_lights(std::size_t n, int channels) {
    Random random;
    BatchBuffer b(static_cast<std::size_t>(9 * channels), n);
    std::array<double, 3> z{};
    for (std::size_t k = 0; k < n; ++k) {
        const glm::dvec3 sun = random.direction(), other = random.direction();
        for (int c = 0; c < channels; ++c) {
            std::array<double, 9> f{};
            sh::zonal_hemisphere(3, 1.0, 0.2, z);
            sh::add_zonal(3, z, glm::dvec3(0.0, 0.0, 1.0), 1.0, f);
            sh::zonal_delta(3, z);
            sh::add_zonal(3, z, sun, std::exp(4.0 * random.uniform()), f);
            sh::zonal_cone(3, 0.2 + 2.0 * random.uniform(), z);
            sh::add_zonal(3, z, k % 3 == 0 ? -sun : other, 3.0 * random.uniform(), f);
            for (std::size_t i = 0; i < 9; ++i) {
                b.row(static_cast<std::size_t>(9 * c) + i)[k] = static_cast<float>(f[i]);
            }
        }
    }
    return b;
}

void deringing(const Context& context) {
    const std::size_t n = context.quick() ? 1024 : 4096;
    const BatchBuffer in = ringing_lights(n, 1);
    BatchBuffer out(9, n), factors(2, n);
    std::vector<sh::DeringOutcome> outcomes(n);
    const auto run = [&](const sh::DeringOptions& options) {
        for (std::size_t k = 0; k < n; k += count) {
            const std::size_t end = std::min(n, k + count);
            sh::dering(1, in.view().items(k, end), out.view().items(k, end), options, {}, factors.view().items(k, end));
        }
    };
    // The most negative irradiance left, as a fraction of its average.
    const auto worst = [&] {
        double w = 0.0;
        for (std::size_t k = 0; k < n; ++k) {
            std::vector<double> f = item(out, k);
            sh::irradiance(3, f, std::span<double>(f));
            w = std::max(w, -sh::quadratic_minimum(f).value / (0.28209479177387814 * f[0]));
        }
        return w;
    };
    struct Method {
        const char* name;
        sh::DeringMethod method;
        sh::WindowFamily family;
    };
    for (const Method& m : {Method{"paper", sh::DeringMethod::paper, sh::WindowFamily::sloan},
                            Method{"exact, blend", sh::DeringMethod::exact, sh::WindowFamily::blend},
                            Method{"exact, gauss", sh::DeringMethod::exact, sh::WindowFamily::gauss},
                            Method{"exact, table", sh::DeringMethod::exact, sh::WindowFamily::sloan}}) {
        sh::DeringOptions options;
        options.method = m.method;
        options.family = m.family;
        Row row = make_row(std::string("dering a channel, ") + m.name, 3,
                           "largest negative irradiance left / average, 4096 lights");
        row.reference = "exact minimum in double";
        row.items = static_cast<double>(n);
        context.run(row, [&] {
            for (std::size_t k = 0; k < n; ++k) {
                keep(sh::find_window(3, item(in, k), options).strength);
            }
        });
        run_batches(
            context, row, [&] { run(options); }, worst, true);
    }
}

// Orders 4 to 6: a certified bound and the window from it.
void deringing_of_higher_orders(const Context& context) {
    constexpr std::size_t n = 64;
    Random random;
    for (const int order : {4, 5, 6}) {
        BatchBuffer in(static_cast<std::size_t>(order * order), n), out(in.rows(), n);
        std::vector<std::vector<double>> lights;
        for (std::size_t k = 0; k < n; ++k) {
            std::vector<double> f(in.rows());
            std::array<double, 6> z{};
            sh::zonal_hemisphere(order, 1.0, 0.2, z);
            sh::add_zonal(order, z, glm::dvec3(0.0, 0.0, 1.0), 1.0, std::span<double>(f));
            sh::zonal_delta(order, z);
            sh::add_zonal(order, z, random.direction(), std::exp(4.0 * random.uniform()), std::span<double>(f));
            sh::zonal_cone(order, 0.2 + 2.0 * random.uniform(), z);
            sh::add_zonal(order, z, random.direction(), 3.0 * random.uniform(), std::span<double>(f));
            for (std::size_t i = 0; i < f.size(); ++i) {
                in.row(i)[k] = static_cast<float>(f[i]);
                f[i] = static_cast<double>(in.row(i)[k]);
            }
            lights.push_back(f);
        }
        for (const auto& [signal, name] :
             {std::pair{sh::Signal::irradiance, "irradiance"}, std::pair{sh::Signal::radiance, "radiance"}}) {
            sh::DeringOptions options;
            options.signal = signal;
            Row row = make_row(std::string("dering a channel, exact, blend, ") + name, order,
                               "largest negative value left / average, bound certified to 1e-5, 16 of 64 lights");
            row.reference = "branch and bound in double";
            row.items = 8.0;
            context.run(row, [&] {
                for (std::size_t k = 0; k < 8; ++k) {
                    keep(sh::find_window(order, lights[k], options).strength);
                }
            });
            row.items = static_cast<double>(n);
            run_batches(
                context, row, [&] { sh::dering(order, 1, in, out, options); },
                [&] {
                    double w = 0.0;
                    for (std::size_t k = 0; k < n; k += 4) {
                        std::vector<double> f = item(out, k);
                        if (signal == sh::Signal::irradiance) {
                            sh::irradiance(order, f, std::span<double>(f));
                        }
                        const double mean = 0.28209479177387814 * f[0];
                        w = std::max(w, -sh::certified_minimum(order, f, 1e-5 * mean).value / mean);
                    }
                    return w;
                });
        }
    }
}

// 10^5 probes, all of a frame: the sky seen by each, the sun where it is seen, one window for the three channels.
void probe_update(const Context& context) {
    const std::size_t n = context.quick() ? 10'000 : 100'000;
    Random random;
    BatchBuffer seen(2, n), probes(27, n); // fractions of sky and sun
    for (std::size_t k = 0; k < n; ++k) {
        seen.row(0)[k] = static_cast<float>(0.2 + 0.8 * random.uniform());
        seen.row(1)[k] = random.uniform() < 0.3 ? 0.0F : static_cast<float>(random.uniform());
    }
    std::array<double, 3> z{};
    std::array<double, 9> sky{}, sun{};
    sh::zonal_hemisphere(3, 1.0, 0.2, z);
    sh::add_zonal(3, z, glm::dvec3(0.0, 0.0, 1.0), 1.0, sky);
    sh::zonal_delta(3, z);
    sh::add_zonal(3, z, glm::normalize(glm::dvec3(1.0, 2.0, 1.5)), 1.0, sun);
    const float sky_colour[] = {3000.0F, 5000.0F, 9000.0F}, sun_colour[] = {80000.0F, 75000.0F, 60000.0F};
    Row row = make_row("update a probe: sky, sun, exact deringing, RGB", 3, "not an approximation");
    row.reference = "none";
    row.items = static_cast<double>(n);
    row.bytes = 29.0 * 4.0;
    run_batches(
        context, row,
        [&] {
            for (std::size_t begin = 0; begin < n; begin += count) {
                const std::size_t end = std::min(n, begin + count);
                for (std::size_t c = 0; c < 3; ++c) {
                    for (std::size_t i = 0; i < 9; ++i) {
                        const float a = sky_colour[c] * static_cast<float>(sky[i]);
                        const float b = sun_colour[c] * static_cast<float>(sun[i]);
                        float* out = probes.row(9 * c + i);
                        const float *s = seen.row(0), *t = seen.row(1);
                        for (std::size_t k = begin; k < end; ++k) {
                            out[k] = a * s[k] + b * t[k];
                        }
                    }
                }
                const Batch chunk = probes.view().items(begin, end);
                sh::dering(3, chunk, chunk);
            }
        },
        [] { return 0.0; });
}

void blending(const Context& context) {
    // 1e5 receivers in a grid of 32 x 32 x 8 probes.
    const std::size_t n = context.quick() ? 10'000 : 100'000;
    constexpr std::size_t stride = 32;
    Random random;
    std::vector<float> probes(32 * 32 * 8 * stride, 1.0F), out(n * stride), weights;
    std::vector<std::uint32_t> corners;
    for (std::size_t k = 0; k < n; ++k) {
        const double x = 30.9 * random.uniform(), y = 30.9 * random.uniform(), h = 6.9 * random.uniform();
        const auto ix = static_cast<std::uint32_t>(x), iy = static_cast<std::uint32_t>(y),
                   ih = static_cast<std::uint32_t>(h);
        for (std::uint32_t c = 0; c < 8; ++c) {
            corners.push_back(((ih + (c >> 2)) * 32 + iy + (c >> 1 & 1)) * 32 + ix + (c & 1));
            weights.push_back(static_cast<float>((c & 1 ? x - ix : 1.0 - x + ix) * (c & 2 ? y - iy : 1.0 - y + iy) *
                                                 (c & 4 ? h - ih : 1.0 - h + ih)));
        }
    }
    Row row = make_row("blend a receiver out of a grid, RGB", 3, "sum of weights, of a constant grid");
    row.reference = "1";
    row.items = static_cast<double>(n);
    run_batches(
        context, row, [&] { sh::blend(27, probes.data(), stride, corners, weights, out.data()); },
        [&] {
            double w = 0.0;
            for (std::size_t k = 0; k < n; ++k) {
                w = std::max(w, std::abs(static_cast<double>(out[k * stride + 5]) - 1.0));
            }
            return w;
        });
}

const Case cases[] = {{"sh/evaluate-basis", evaluate_basis},
                      {"sh/evaluate-dot", evaluate_dot},
                      {"sh/product", products},
                      {"sh/triple-product", triple_products},
                      {"sh/project-samples", project_samples},
                      {"sh/rotate", rotations},
                      {"sh/cube-map", cube_maps},
                      {"sh/dering", deringing},
                      {"sh/dering-orders", deringing_of_higher_orders},
                      {"sh/probe-update", probe_update},
                      {"sh/blend", blending}};

} // namespace
} // namespace alpenglow::bench
