// Transfer: bake time against error, run time against compression error, glossy, a frame of many objects.
#include "bench.hpp"

#include <alpenglow/core/constants.hpp>
#include <alpenglow/core/timing.hpp>
#include <alpenglow/ecs/registry.hpp>
#include <alpenglow/prt/bake_cubemap.hpp>
#include <alpenglow/prt/bake_glossy.hpp>
#include <alpenglow/prt/bake_neighbourhood.hpp>
#include <alpenglow/prt/bake_volume.hpp>
#include <alpenglow/prt/compress.hpp>
#include <alpenglow/prt/evaluate.hpp>
#include <alpenglow/prt/lobe.hpp>
#include <alpenglow/prt/shapes.hpp>
#include <alpenglow/sh/basis.hpp>
#include <alpenglow/systems/transfer.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>

namespace alpenglow::bench {
namespace {

using namespace alpenglow::prt;

constexpr std::size_t coefficients = 25;

double unoccluded_norm(int order) {
    std::vector<float> m(static_cast<std::size_t>(order * order));
    unshadowed(order, glm::vec3(0.0F, 0.0F, 1.0F), m);
    double sum = 0.0;
    for (const float x : m) {
        sum += static_cast<double>(x) * static_cast<double>(x);
    }
    return std::sqrt(sum);
}

double rms(const TransferField& a, const TransferField& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.values.size(); ++i) {
        const double d = static_cast<double>(a.values[i]) - static_cast<double>(b.values[i]);
        sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(a.count)) / unoccluded_norm(a.order);
}

std::vector<glm::vec3> sun_and_sky(int order) {
    std::vector<glm::vec3> light(static_cast<std::size_t>(order * order));
    std::array<float, 36> y{};
    sh::evaluate_basis(order, glm::normalize(glm::vec3(0.5F, 0.3F, 0.6F)), y);
    for (int l = 0; l < order; ++l) {
        const float window = std::cos(0.5F * 3.14159265F * static_cast<float>(l) / static_cast<float>(order));
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            light[static_cast<std::size_t>(i)] = y[static_cast<std::size_t>(i)] * window * glm::vec3(3.0F, 2.7F, 2.2F);
        }
    }
    light[0] += glm::vec3(1.0F, 1.2F, 1.6F);
    return light;
}

// Every n-th vertex of a mesh.
BakePoints some_points(const Mesh& mesh, std::size_t count) {
    BakePoints points;
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = (2 * k + 1) * mesh.positions.size() / (2 * count);
        points.positions_m.push_back(mesh.positions[i]);
        points.normals.push_back(mesh.normals[i]);
    }
    return points;
}

const char* name_of(Sampling sampling) {
    switch (sampling) {
    case Sampling::random:
        return "random";
    case Sampling::stratified:
        return "stratified";
    case Sampling::fibonacci:
        return "Fibonacci";
    case Sampling::adaptive:
        return "adaptive";
    }
    return "";
}

// CPU seconds of one bake, with its result.
struct Timed {
    double cpu_s = 0.0;
    Bake bake;
};

Timed timed_bake(const Mesh& mesh, const BakePoints& points, const BakeSettings& settings) {
    Result<Bake> baked = bake_points(mesh, points, settings);
    return {baked->report.rays_cpu_s, std::move(*baked)};
}

void bake_sampling(const Context& context) {
    const std::pair<const char*, Mesh> scenes[] = {{"figure", figure(20000)}, {"torus", torus(1.0F, 0.45F, 160, 100)}};
    for (const auto& [scene, mesh] : scenes) {
        const std::size_t count = context.quick() ? 60 : 240;
        const BakePoints points = some_points(mesh, count);
        BakeSettings settings;
        settings.threads = 1;
        settings.sampling = Sampling::fibonacci;
        settings.rays = context.quick() ? 16384 : 65536;
        const std::string name = std::string("bake, shadowed order 5, ") + scene;
        const Timed reference = timed_bake(mesh, points, settings);
        const auto row = [&](const std::string& method, const Timed& timed, double error) {
            context.add({.module = "prt",
                         .name = name,
                         .method = method,
                         .time_ns = timed.cpu_s * 1e9 / static_cast<double>(count),
                         .error = error,
                         .error_metric = "RMS over points of |dM| / |M unoccluded|",
                         .reference = "Fibonacci, " + std::to_string(settings.rays) + " rays",
                         .items = static_cast<double>(count)});
        };
        row("reference", reference, 0.0);
        for (const Sampling sampling : {Sampling::random, Sampling::stratified, Sampling::fibonacci}) {
            for (const std::size_t rays : {256U, 1024U, 4096U, 16384U}) {
                if (context.quick() && rays > 4096) {
                    continue;
                }
                BakeSettings s = settings;
                s.sampling = sampling;
                s.rays = rays;
                s.seed = 7;
                const Timed timed = timed_bake(mesh, points, s);
                row(std::string(name_of(sampling)) + " " + std::to_string(rays), timed,
                    rms(timed.bake.field, reference.bake.field));
            }
        }
        for (const std::size_t rays : {1024U, 4096U, 16384U}) {
            for (const double wanted : {2e-2, 5e-3, 0.0}) {
                BakeSettings s = settings;
                s.sampling = Sampling::adaptive;
                s.rays = rays;
                s.max_error = wanted;
                s.seed = 7;
                const Timed timed = timed_bake(mesh, points, s);
                char method[96];
                std::snprintf(method, sizeof method, "adaptive %zu, asked %g (%.0f rays, estimate %.4f)", rays, wanted,
                              static_cast<double>(timed.bake.report.shadow_rays) / static_cast<double>(count),
                              timed.bake.report.estimated_rms);
                row(method, timed, rms(timed.bake.field, reference.bake.field));
            }
        }
    }
}

void bake_speed(const Context& context) {
    const Mesh mesh = figure(context.quick() ? 5000 : 50000);
    for (const Sampling sampling : {Sampling::fibonacci, Sampling::adaptive}) {
        BakeSettings settings;
        settings.threads = 1;
        settings.sampling = sampling;
        settings.rays = sampling == Sampling::fibonacci ? 1024 : 4096;
        const Result<Bake> baked = bake(mesh, settings);
        BakeReport report = baked->report;
        settings.measure_tracer = true; // a bake of its own: reading the clock is not free
        report.tracing_cpu_s = bake(mesh, settings)->report.tracing_cpu_s;
        const auto rays = static_cast<double>(report.shadow_rays);
        const std::string name = "bake a ray, figure, " + std::string(name_of(sampling));
        context.add({.module = "prt",
                     .name = name,
                     .method = "rtcOccluded1 alone",
                     .time_ns = report.tracing_cpu_s * 1e9 / rays,
                     .error_metric = "none",
                     .reference = "itself",
                     .items = rays});
        context.add({.module = "prt",
                     .name = name,
                     .method = "bake, SH and all",
                     .time_ns = report.rays_cpu_s * 1e9 / rays,
                     .error = report.estimated_rms,
                     .error_metric = "estimated RMS of |dM| / |M unoccluded|",
                     .reference = "the bake's own estimate",
                     .items = rays});
    }
}

void bake_cube(const Context& context) {
    const Mesh mesh = figure(context.quick() ? 600 : 1500);
    BakeSettings settings;
    settings.threads = 1;
    settings.sampling = Sampling::fibonacci;
    settings.rays = 16384;
    const Result<Bake> reference = bake(mesh, settings);
    const auto points = static_cast<double>(mesh.positions.size());
    const auto row = [&](const std::string& method, const Bake& baked) {
        context.add({.module = "prt",
                     .name = "bake by cube maps, figure of " + std::to_string(mesh.positions.size()) + " vertices",
                     .method = method,
                     .time_ns = baked.report.rays_cpu_s * 1e9 / points,
                     .error = rms(baked.field, reference->field),
                     .error_metric = "RMS over points of |dM| / |M unoccluded|",
                     .reference = "Fibonacci, 16384 rays",
                     .items = points});
    };
    row("rays, reference", *reference);
    settings.sampling = Sampling::adaptive;
    settings.rays = 4096;
    row("rays, adaptive", *bake(mesh, settings));
    for (const std::size_t resolution : {8U, 16U, 32U}) {
        row("cube map, " + std::to_string(resolution) + "^2 a face", *bake_cubemap(mesh, settings, resolution));
    }
}

// A field like a bake's, made quickly: occluded cosine lobes that vary smoothly over a surface.
TransferField large_field(std::size_t count) {
    TransferField field;
    field.order = 5;
    field.count = count;
    field.values.resize(count * coefficients);
    std::array<float, coefficients> m{};
    std::array<float, coefficients> shade{};
    for (std::size_t p = 0; p < count; ++p) {
        const double t = static_cast<double>(p) / static_cast<double>(count);
        const double phi = 700.0 * t;
        const double z = 1.0 - 2.0 * t;
        const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
        unshadowed(5, glm::vec3(glm::dvec3(r * std::cos(phi), r * std::sin(phi), z)), m);
        unshadowed(5, glm::vec3(glm::dvec3(std::sin(40.0 * t), 0.0, std::cos(40.0 * t))), shade);
        for (std::size_t i = 0; i < coefficients; ++i) {
            field.values[p * coefficients + i] = m[i] - 0.3F * shade[i];
        }
    }
    return field;
}

// One vector a vertex, three dot products, as one would write it.
__attribute__((noinline)) void naive(const std::vector<float>& transfer, const std::vector<glm::vec3>& light,
                                     std::vector<glm::vec3>& out) {
    for (std::size_t p = 0; p < out.size(); ++p) {
        glm::vec3 sum(0.0F);
        for (std::size_t i = 0; i < coefficients; ++i) {
            sum += transfer[p * coefficients + i] * light[i];
        }
        out[p] = sum;
    }
}

__attribute__((noinline)) float read_all(const std::vector<float>& data) {
    float sum[64] = {};
    for (std::size_t i = 0; i + 64 <= data.size(); i += 64) {
        for (std::size_t k = 0; k < 64; ++k) {
            sum[k] += data[i + k];
        }
    }
    return sum[0] + sum[17] + sum[63];
}

double result_error(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const glm::dvec3 d = glm::dvec3(a[i]) - glm::dvec3(b[i]);
        error += glm::dot(d, d);
        norm += glm::dot(glm::dvec3(b[i]), glm::dvec3(b[i]));
    }
    return std::sqrt(error / norm);
}

void run_time(const Context& context) {
    for (const bool cache : {true, false}) {
        const std::size_t count = cache ? 2048 : context.quick() ? 200000 : 1000000;
        const TransferField field = large_field(count);
        const std::vector<glm::vec3> light = sun_and_sky(5);
        const auto points = static_cast<double>(count);
        const std::string name =
            cache ? "evaluate 25 coefficients, in cache" : "evaluate 25 coefficients, 1e6 vertices";
        std::vector<glm::vec3> reference(count);
        std::vector<glm::vec3> out(count);
        Row row{.module = "prt",
                .name = name,
                .method = "",
                .error_metric = "relative RMS of radiance under sun and sky",
                .reference = "naive float",
                .bytes = points * (coefficients * 4.0 + 12.0),
                .items = points};
        row.method = "naive";
        context.run(row, [&] { naive(field.values, light, reference); });
        if (!cache) {
            Row memory = row;
            memory.method = "memory read alone (the table's bytes)";
            memory.bytes = points * coefficients * 4.0;
            context.run(memory, [&] { keep(read_all(field.values)); });
        }
        const auto measure = [&](const std::string& method, const TransferTable& table) {
            Row r = row;
            r.method = method;
            r.bytes = static_cast<double>(table.bytes()) + points * 12.0;
            evaluate(table, light, out);
            r.error = result_error(out, reference);
            context.run(r, [&] { evaluate(table, light, out); });
        };
        measure("SIMD float", *encode(field, Encoding::f32));
        measure("SIMD half", *encode(field, Encoding::f16));
        measure("SIMD 8-bit", *encode(field, Encoding::s8));
        const Result<TransferTable> cpca = encode_cpca(
            field, {.clusters = cache ? 4U : 64U, .components = 8, .iterations = context.quick() || !cache ? 2 : 6});
        measure("CPCA, 8 components", *cpca);
    }
}

void compression(const Context& context) {
    const Mesh mesh = figure(context.quick() ? 4000 : 20000);
    BakeSettings settings;
    settings.rays = 4096;
    const Result<Bake> baked = bake(mesh, settings);
    const TransferField& field = baked->field;
    const std::vector<glm::vec3> light = sun_and_sky(5);
    std::vector<glm::vec3> reference(field.count);
    std::vector<glm::vec3> out(field.count);
    const auto points = static_cast<double>(field.count);
    evaluate(*encode(field, Encoding::f32), light, reference);
    const auto measure = [&](const std::string& method, const TransferTable& table) {
        evaluate(table, light, out);
        Row r{.module = "prt",
              .name = "compression of a baked figure",
              .method = method,
              .error = static_cast<double>(table.info.encoding_rms),
              .error_metric = "relative RMS of transfer; radiance under sun and sky " +
                              std::to_string(result_error(out, reference)),
              .reference = "the bake in float",
              .bytes = static_cast<double>(table.bytes()),
              .items = points};
        context.run(r, [&] { evaluate(table, light, out); });
    };
    measure("float", *encode(field, Encoding::f32));
    measure("half", *encode(field, Encoding::f16));
    measure("8-bit", *encode(field, Encoding::s8));
    for (const std::size_t components : {4U, 8U, 12U, 16U}) {
        const std::size_t clusters = std::max<std::size_t>(4, field.count / 400);
        measure("CPCA, " + std::to_string(clusters) + " clusters, " + std::to_string(components) + " components",
                *encode_cpca(field, {.clusters = clusters, .components = components}));
    }
    if (const Result<TransferTable> within = encode_cpca_within(field, 0.01)) {
        measure("CPCA within 1 %: " + std::to_string(within->info.clusters) + " clusters, " +
                    std::to_string(within->info.components) + " components",
                *within);
    }
}

__attribute__((noinline)) void naive_glossy(const TransferField& field, const std::vector<glm::vec3>& light,
                                            const std::vector<float>& kernel, const std::vector<glm::vec3>& directions,
                                            std::vector<glm::vec3>& out) {
    std::array<float, 25> y{};
    for (std::size_t p = 0; p < field.count; ++p) {
        const float* m = field.values.data() + p * 625;
        sh::evaluate_basis(5, directions[p], y);
        glm::vec3 sum(0.0F);
        for (std::size_t l = 0; l < 5; ++l) {
            for (std::size_t i = l * l; i < (l + 1) * (l + 1); ++i) {
                glm::vec3 transferred(0.0F);
                for (std::size_t j = 0; j < 25; ++j) {
                    transferred += m[i * 25 + j] * light[j];
                }
                sum += kernel[l] * y[i] * transferred;
            }
        }
        out[p] = sum;
    }
}

void glossy(const Context& context) {
    constexpr std::size_t count = 2000;
    TransferField field;
    field.kind = TransferKind::glossy;
    field.order = 5;
    field.out_order = 5;
    field.count = count;
    field.values.resize(count * 625);
    std::mt19937 generator(1);
    std::normal_distribution<float> value(0.0F, 0.05F);
    for (float& x : field.values) {
        x = value(generator);
    }
    std::vector<glm::vec3> directions;
    for (std::size_t i = 0; i < count; ++i) {
        directions.push_back(glm::normalize(glm::vec3(value(generator), value(generator), value(generator) + 0.001F)));
    }
    const std::vector<glm::vec3> light = sun_and_sky(5);
    std::vector<float> kernel(5);
    phong_kernel(20.0, kernel);
    std::vector<glm::vec3> reference(count);
    std::vector<glm::vec3> out(count);
    Row row{.module = "prt",
            .name = "glossy 25 x 25",
            .method = "naive",
            .error_metric = "relative RMS of radiance",
            .reference = "naive float",
            .bytes = count * 2500.0,
            .items = count};
    context.run(row, [&] { naive_glossy(field, light, kernel, directions, reference); });
    for (const Encoding encoding : {Encoding::f32, Encoding::f16, Encoding::s8}) {
        const Result<TransferTable> table = encode(field, encoding);
        Row r = row;
        r.method = encoding == Encoding::f32 ? "SIMD float" : encoding == Encoding::f16 ? "SIMD half" : "SIMD 8-bit";
        r.bytes = static_cast<double>(table->bytes());
        evaluate_glossy(*table, light, kernel, directions, out);
        r.error = result_error(out, reference);
        context.run(r, [&] { evaluate_glossy(*table, light, kernel, directions, out); });
    }
}

// 100 objects of 10k vertices under a sun that moves at real speed: CPU time of update_transfer a frame.
void frames(const Context& context) {
    const auto table = std::make_shared<const TransferTable>(*encode(large_field(10000), Encoding::f16));
    for (const double rate : {1.0, 60.0}) {
        BasicRegistry registry;
        std::vector<BasicRegistry::entity_type> objects;
        std::mt19937 generator(2);
        std::uniform_real_distribution<float> angle(0.0F, 6.28F);
        for (int i = 0; i < 100; ++i) {
            const auto entity = registry.create();
            TransferMesh mesh;
            mesh.table = table;
            mesh.scene_from_object = glm::angleAxis(angle(generator), glm::vec3(0.0F, 0.0F, 1.0F));
            registry.emplace<TransferMesh>(entity, mesh);
            registry.emplace<ObjectLight>(entity);
            objects.push_back(entity);
        }
        const auto light_at = [&](double seconds) {
            const double a = 0.6 + 7.2722e-5 * rate * seconds;
            std::vector<glm::vec3> light(25);
            std::array<float, 25> y{};
            sh::evaluate_basis(5, glm::vec3(glm::dvec3(std::cos(a), 0.0, std::sin(a))), y);
            for (std::size_t l = 0; l < 5; ++l) {
                const float window = 1.0F / (1.0F + 0.2F * static_cast<float>(l * l));
                for (std::size_t i = l * l; i < (l + 1) * (l + 1); ++i) {
                    light[i] = y[i] * window * glm::vec3(3.0F, 2.7F, 2.2F);
                }
            }
            light[0] += glm::vec3(1.0F);
            return light;
        };
        double total_ms = 0.0;
        double worst_ms = 0.0;
        double updated = 0.0;
        double error = 0.0;
        int measured = 0;
        const int count = context.quick() ? 600 : 3600;
        for (int step = 0; step < count; ++step) {
            const std::vector<glm::vec3> light = light_at(step / 60.0);
            for (const auto entity : objects) {
                ObjectLight& to = registry.get<ObjectLight>(entity);
                to.coefficients = light;
                to.bands = 5;
                ++to.revision;
            }
            const SystemReport report = update_transfer(registry, Frame{});
            if (step > 0) {
                total_ms += report.cpu_ms;
                worst_ms = std::max(worst_ms, report.cpu_ms);
                updated += report.updated;
                error = std::max(error, report.error_bound);
                ++measured;
            }
        }
        char method[120];
        std::snprintf(method, sizeof method, "sun at %gx: worst frame %.2f ms, %.2f objects a frame", rate, worst_ms,
                      updated / measured);
        context.add({.module = "prt",
                     .name = "update_transfer, 100 objects of 10k vertices",
                     .method = method,
                     .time_ns = total_ms * 1e6 / measured,
                     .error = error,
                     .error_metric = "bound of the skipped results, budget 0.01",
                     .reference = "evaluated every frame",
                     .items = 1.0});
        context.run({.module = "prt",
                     .name = "update_transfer, 100 objects of 10k vertices",
                     .method = "static",
                     .error_metric = "bound of the skipped results, budget 0.01",
                     .reference = "evaluated every frame"},
                    [&] { keep(update_transfer(registry, Frame{}).updated); });
    }
}

// ---- Accuracy of shading
// ----------------------------------------------------------------------------------------------

// A room of rectangles, open at the top, with a block in it: the mesh that is baked, and the same rectangles for a path
// tracer that knows nothing of meshes.
struct Rectangle {
    glm::dvec3 corner, a, b; // normal a x b
};

std::vector<Rectangle> room() {
    const auto box_faces = [](const glm::dvec3& low, const glm::dvec3& high, bool inwards, bool bottom, bool top) {
        std::vector<Rectangle> faces;
        const glm::dvec3 d = high - low;
        const glm::dvec3 x(d.x, 0.0, 0.0);
        const glm::dvec3 y(0.0, d.y, 0.0);
        const glm::dvec3 z(0.0, 0.0, d.z);
        const auto add = [&](const glm::dvec3& corner, const glm::dvec3& a, const glm::dvec3& b) {
            faces.push_back(inwards ? Rectangle{corner, b, a} : Rectangle{corner, a, b});
        };
        add(low, z, y);     // -x
        add(low + x, y, z); // +x
        add(low, x, z);     // -y
        add(low + y, z, x); // +y
        if (bottom) {
            add(low, y, x);
        }
        if (top) {
            add(low + z, x, y);
        }
        return faces;
    };
    std::vector<Rectangle> all = box_faces({-1.0, -1.0, 0.0}, {1.0, 1.0, 1.2}, true, true, false);
    const std::vector<Rectangle> block = box_faces({-0.3, -0.5, 0.25}, {0.4, 0.2, 0.6}, false, true, true);
    all.insert(all.end(), block.begin(), block.end());
    return all;
}

Mesh mesh_of(const std::vector<Rectangle>& rectangles, int cells) {
    Mesh mesh;
    for (const Rectangle& r : rectangles) {
        const auto first = static_cast<unsigned>(mesh.positions.size());
        const auto n = static_cast<unsigned>(cells) + 1;
        for (unsigned j = 0; j < n; ++j) {
            for (unsigned i = 0; i < n; ++i) {
                mesh.positions.emplace_back(r.corner + r.a * (static_cast<double>(i) / cells) +
                                            r.b * (static_cast<double>(j) / cells));
            }
        }
        for (unsigned j = 0; j + 1 < n; ++j) {
            for (unsigned i = 0; i + 1 < n; ++i) {
                const unsigned v = first + j * n + i;
                mesh.triangles.emplace_back(v, v + 1, v + n + 1);
                mesh.triangles.emplace_back(v, v + n + 1, v + n);
            }
        }
    }
    compute_normals(mesh);
    return mesh;
}

// Radiance over albedo at a point, one path: Lambert walls of `albedo`, light from outside by `sky`.
template <class Sky, class Random>
double path(const std::vector<Rectangle>& room, glm::dvec3 at, glm::dvec3 normal, double albedo, int bounces,
            const Sky& sky, Random& random) {
    double throughput = 1.0;
    for (int bounce = 0;; ++bounce) {
        const double r2 = random();
        const double phi = two_pi * random();
        const glm::dvec3 side = glm::normalize(std::abs(normal.z) < 0.9 ? glm::cross(normal, glm::dvec3(0, 0, 1))
                                                                        : glm::cross(normal, glm::dvec3(1, 0, 0)));
        const glm::dvec3 d = side * (std::sqrt(r2) * std::cos(phi)) +
                             glm::cross(normal, side) * (std::sqrt(r2) * std::sin(phi)) + normal * std::sqrt(1.0 - r2);
        double nearest = 1e30;
        glm::dvec3 hit_normal(0.0);
        for (const Rectangle& r : room) {
            const glm::dvec3 n = glm::cross(r.a, r.b);
            const double facing = glm::dot(n, d);
            const double t = glm::dot(n, r.corner - at) / facing;
            if (!(t > 1e-7) || t >= nearest) {
                continue;
            }
            const glm::dvec3 p = at + t * d - r.corner;
            const double u = glm::dot(p, r.a) / glm::dot(r.a, r.a);
            const double v = glm::dot(p, r.b) / glm::dot(r.b, r.b);
            if (u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0) {
                nearest = t;
                hit_normal = facing < 0.0 ? glm::normalize(n) : glm::dvec3(0.0);
            }
        }
        if (nearest == 1e30) {
            return throughput * sky(d);
        }
        if (hit_normal == glm::dvec3(0.0) || bounce >= bounces) {
            return 0.0; // a back is black
        }
        throughput *= albedo;
        at += nearest * d;
        normal = hit_normal;
    }
}

void accuracy(const Context& context) {
    const std::vector<Rectangle> rectangles = room();
    const int cells = context.quick() ? 16 : 24;
    const Mesh mesh = mesh_of(rectangles, cells);
    const auto n = static_cast<std::size_t>(cells) + 1;
    constexpr double albedo = 0.6;
    std::vector<std::size_t> chosen;
    for (std::size_t face = 0; face < rectangles.size(); ++face) {
        if (face == 9) {
            continue; // the block's top sees the sky alone, and is chosen below
        }
        for (const std::size_t at : {n * (n / 3) + n / 4, n * (n / 2) + n / 2, n * (2 * n / 3) + 3 * n / 4}) {
            chosen.push_back(face * n * n + at);
        }
    }
    chosen.push_back(9 * n * n + n * (n / 2) + n / 2);
    const std::vector<glm::vec3> light = sun_and_sky(5);
    std::vector<double> green(25);
    for (std::size_t i = 0; i < 25; ++i) {
        green[i] = static_cast<double>(light[i].y);
    }
    const auto sky = [&](const glm::dvec3& d) { return sh::evaluate(5, green, d); };
    const std::size_t paths = context.quick() ? 20000 : 200000;
    for (const int bounces : {0, 64}) {
        std::vector<double> truth;
        double noise = 0.0;
        const double start = thread_cpu_seconds();
        for (const std::size_t v : chosen) {
            std::mt19937_64 generator(v + 1);
            const auto random = [&] { return static_cast<double>(generator() >> 11U) * 0x1.0p-53; };
            double sum = 0.0;
            double squares = 0.0;
            for (std::size_t k = 0; k < paths; ++k) {
                const double value = path(rectangles, glm::dvec3(mesh.positions[v]), glm::dvec3(mesh.normals[v]),
                                          albedo, bounces, sky, random);
                sum += value;
                squares += value * value;
            }
            const double mean = sum / static_cast<double>(paths);
            truth.push_back(mean);
            noise += (squares / static_cast<double>(paths) - mean * mean) / static_cast<double>(paths);
        }
        const double path_s = thread_cpu_seconds() - start;
        double norm = 0.0;
        for (const double t : truth) {
            norm += t * t;
        }
        const std::string name =
            bounces == 0 ? "shading, shadowed, order 5, one light" : "shading, interreflected, order 5, one light";
        const std::string metric = "relative RMS of radiance over points; the path tracer's own noise is " +
                                   std::to_string(std::sqrt(noise / norm));
        context.add({.module = "prt",
                     .name = name,
                     .method = "path tracer, " + std::to_string(paths) + " paths a point",
                     .time_ns = path_s * 1e9 / static_cast<double>(chosen.size()),
                     .error_metric = metric,
                     .reference = "path tracer on the exact rectangles",
                     .items = static_cast<double>(chosen.size())});
        BakeSettings settings;
        settings.transport = bounces == 0 ? Transport::shadowed : Transport::interreflected;
        settings.default_albedo = static_cast<float>(albedo);
        settings.rays = 4096;
        settings.max_error = 1e-3;
        settings.gather_rays = 1024;
        settings.stop_energy = 1e-6;
        settings.max_bounces = 64;
        const Result<Bake> baked = bake(mesh, settings);
        double error = 0.0;
        for (std::size_t k = 0; k < chosen.size(); ++k) {
            const std::span<const float> m = baked->field.point(chosen[k]);
            double radiance = 0.0;
            for (std::size_t i = 0; i < 25; ++i) {
                radiance += static_cast<double>(m[i]) * green[i];
            }
            error += (radiance - truth[k]) * (radiance - truth[k]);
        }
        context.add({.module = "prt",
                     .name = name,
                     .method = "transfer (bake per vertex)",
                     .time_ns = (baked->report.rays_cpu_s + baked->report.bounces_cpu_s) * 1e9 /
                                static_cast<double>(mesh.positions.size()),
                     .error = std::sqrt(error / norm),
                     .error_metric = metric,
                     .reference = "path tracer on the exact rectangles",
                     .items = static_cast<double>(mesh.positions.size())});
    }
}

// The paper's figure 10: a polygon's shadow on the ground under a round light, by order and the light's radius.
void orders(const Context& context) {
    Mesh mesh = plane(2.0F, context.quick() ? 12 : 20);
    Mesh card = box(glm::vec3(0.45F, 0.3F, 0.01F), 1);
    mesh = merged(mesh, card, glm::vec3(0.0F, 0.0F, 0.8F));
    const std::size_t ground = (context.quick() ? 13U * 13U : 21U * 21U);
    BakePoints points;
    points.positions_m.assign(mesh.positions.begin(), mesh.positions.begin() + static_cast<std::ptrdiff_t>(ground));
    points.normals.assign(ground, glm::vec3(0.0F, 0.0F, 1.0F));
    const glm::dvec3 centre = glm::normalize(glm::dvec3(0.4, 0.2, 1.0));
    for (const double radius_deg : {2.0, 10.0, 20.0, 40.0}) {
        const double radius = radius_deg * degree_rad;
        // The truth: directions over the disc, each blocked where it passes through the card.
        std::vector<double> truth(ground, 0.0);
        constexpr int steps = 48;
        double open = 0.0;
        const glm::dvec3 side = glm::normalize(glm::cross(centre, glm::dvec3(0.0, 1.0, 0.0)));
        const glm::dvec3 up = glm::cross(centre, side);
        for (int a = 0; a < steps; ++a) {
            for (int b = 0; b < steps; ++b) {
                const double z = 1.0 - (1.0 - std::cos(radius)) * (a + 0.5) / steps;
                const double phi = two_pi * (b + 0.5) / steps;
                const double r = std::sqrt(1.0 - z * z);
                const glm::dvec3 d = centre * z + side * (r * std::cos(phi)) + up * (r * std::sin(phi));
                if (d.z <= 0.0) {
                    continue;
                }
                open += d.z;
                for (std::size_t p = 0; p < ground; ++p) {
                    const double t = 0.79 / d.z;
                    const glm::dvec3 at = glm::dvec3(points.positions_m[p]) + t * d;
                    const glm::dvec3 out = at + d * (0.02 / d.z);
                    const auto beside = [](double from, double to, double half) {
                        return (from > half && to > half) || (from < -half && to < -half);
                    };
                    if (beside(at.x, out.x, 0.45) || beside(at.y, out.y, 0.3)) {
                        truth[p] += d.z;
                    }
                }
            }
        }
        for (double& t : truth) {
            t /= open;
        }
        for (const int order : {2, 3, 4, 5, 6}) {
            BakeSettings settings;
            settings.order = order;
            settings.max_error = 1e-3;
            const Result<Bake> baked = bake_points(mesh, points, settings);
            // The disc's projection: zonal, turned to its centre; scaled so that open ground has 1.
            std::array<double, 36> y{};
            sh::evaluate_basis(order, centre, y);
            std::vector<double> light(static_cast<std::size_t>(order * order));
            for (int l = 0; l < order; ++l) {
                double zonal = 0.0;
                for (int k = 0; k < 400; ++k) {
                    const double z = 1.0 - (1.0 - std::cos(radius)) * (k + 0.5) / 400.0;
                    zonal += std::legendre(static_cast<unsigned>(l), z) / 400.0;
                }
                for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
                    light[static_cast<std::size_t>(i)] = zonal * y[static_cast<std::size_t>(i)];
                }
            }
            const double scale = pi / centre.z; // a disc of any size sends pi L cos: close enough for a ratio
            double mean_cosine = open / (steps * steps);
            double error = 0.0;
            for (std::size_t p = 0; p < ground; ++p) {
                double radiance = 0.0;
                for (std::size_t i = 0; i < light.size(); ++i) {
                    radiance += static_cast<double>(baked->field.point(p)[i]) * light[i];
                }
                const double shown = radiance * scale * centre.z / mean_cosine;
                error += (shown - truth[p]) * (shown - truth[p]);
            }
            char name[80];
            std::snprintf(name, sizeof name, "figure 10: shadow of a card, light of radius %g degrees", radius_deg);
            context.add({.module = "prt",
                         .name = name,
                         .method = "order " + std::to_string(order),
                         .time_ns = 0.0,
                         .error = std::sqrt(error / static_cast<double>(ground)),
                         .error_metric = "RMS over the ground, open ground = 1",
                         .reference = "true light, ray by ray",
                         .items = static_cast<double>(ground)});
        }
    }
}

// The paper's table 1, at a size that a benchmark can bear; docs/prt.md scales it.
void table_1(const Context& context) {
    const double scale = context.quick() ? 0.02 : 0.1;
    // `steps`: how much more a point of the full size costs than one of the size that was baked.
    const auto add = [&](const char* what, const char* paper, const Bake& baked, double full_points,
                         double steps = 1.0) {
        char method[160];
        std::snprintf(method, sizeof method, "%s; the paper: %s; here %.1f s a core for %.0f points", what, paper,
                      (baked.report.rays_cpu_s + baked.report.bounces_cpu_s) * steps * full_points /
                          static_cast<double>(baked.report.points),
                      full_points);
        context.add({.module = "prt",
                     .name = "the paper's table 1",
                     .method = method,
                     .time_ns = (baked.report.rays_cpu_s + baked.report.bounces_cpu_s) * 1e9 /
                                static_cast<double>(baked.report.points),
                     .error = baked.report.estimated_rms,
                     .error_metric = "the bake's own estimate where it has one",
                     .reference = "none",
                     .items = static_cast<double>(baked.report.points)});
    };
    BakeSettings diffuse;
    diffuse.transport = Transport::interreflected;
    const Mesh body = figure(static_cast<int>(50000 * scale));
    add("diffuse, 50k vertices", "1.1 h to 2.5 h", *bake(body, diffuse), 50000.0);
    GlossySettings matrices;
    matrices.rays = 4096;
    add("glossy 25 x 25, 50k vertices", "2.5 h", *bake_glossy(figure(static_cast<int>(5000 * scale)), matrices),
        50000.0);
    NeighbourhoodSettings around;
    const Mesh wing = glider(1.0F);
    const auto side = static_cast<unsigned>(64.0 * std::sqrt(scale));
    add("neighbourhood 9 x 25, 64 x 64 x 8", "3 h",
        *bake_neighbourhood(wing, grid_around(wing, {side, side, 8}, 1.0F, 0.2F, 2.0F), around), 32768.0);
    VolumeDensity cloud;
    const unsigned size = context.quick() ? 8 : 16;
    cloud.grid = {glm::uvec3(size), glm::vec3(-1.0F), glm::vec3(2.0F / static_cast<float>(size - 1))};
    for (unsigned k = 0; k < size * size * size; ++k) {
        const glm::vec3 p = glm::vec3(k % size, k / size % size, k / size / size) * cloud.grid.step_m - 1.0F;
        cloud.extinction_per_m.push_back(glm::length(p) < 0.9F ? 3.0F : 0.0F);
    }
    add("volume, 32 x 32 x 32", "15 min", *bake_volume(cloud, {}), 32768.0, 32.0 / size); // rays cross twice the voxels
}

const Case cases[] = {
    {"prt/bake sampling", bake_sampling},
    {"prt/bake speed", bake_speed},
    {"prt/bake cube map", bake_cube},
    {"prt/run time", run_time},
    {"prt/compression", compression},
    {"prt/glossy", glossy},
    {"prt/frames", frames},
    {"prt/accuracy", accuracy},
    {"prt/orders", orders},
    {"prt/table 1", table_1},
};

} // namespace
} // namespace alpenglow::bench
