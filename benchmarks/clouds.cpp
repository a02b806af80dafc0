#include "bench.hpp"

#include <alpenglow/clouds/compact.hpp>
#include <alpenglow/clouds/library.hpp>
#include <alpenglow/clouds/march.hpp>
#include <alpenglow/clouds/modelling.hpp>
#include <alpenglow/clouds/reference.hpp>
#include <alpenglow/clouds/vdb.hpp>
#include <alpenglow/core/timing.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

namespace alpenglow::bench {
namespace {

using namespace clouds;

// The benchmarks' cloud, made once.
struct Study {
    SparseGrid grid = cumulus_of_study();
    BrickVolume volume{grid};
    VdbGrid vdb = vdb_from_sparse(grid, "density");
    Medium medium{1.0F, 0.99F, {}};
    DirectionalLight sun{{0.0F, 0.8660254F, 0.5F}, glm::vec3(1.0F), 0.0F};
    glm::dvec3 centre = glm::dvec3(volume.active_low() + volume.active_high()) * 0.5;
};

const Study& study() {
    static const Study value;
    return value;
}

Camera camera(int width, int height) {
    const Study& s = study();
    return look_at(s.centre + glm::dvec3(260.0, -120.0, -60.0), s.centre, 0.26F, width, height);
}

// CPU time of all threads: bakes and marches use helpers, which Context::time would not see.
Time cpu_time(const Context& context, const std::function<void()>& call) {
    std::vector<double> ns;
    const int repetitions = context.quick() ? 2 : 5;
    call();
    for (int i = 0; i < repetitions; ++i) {
        const double start = process_cpu_seconds();
        call();
        ns.push_back((process_cpu_seconds() - start) * 1e9);
    }
    std::sort(ns.begin(), ns.end());
    return {ns[ns.size() / 2], (ns[3 * ns.size() / 4] - ns[ns.size() / 4]) / ns[ns.size() / 2]};
}

void add(const Context& context, Row row, const std::function<void()>& call) {
    const Time time = cpu_time(context, call);
    row.module = "clouds";
    row.time_ns = time.ns / row.items;
    row.time_spread = time.spread;
    context.add(std::move(row));
}

double relative_rmse(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
    double error = 0.0;
    double norm = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double x = luminance(glm::dvec3(a[i]));
        const double y = luminance(glm::dvec3(b[i]));
        error += (x - y) * (x - y);
        norm += y * y;
    }
    return std::sqrt(error / norm);
}

float random_at(std::uint32_t i) {
    i *= 0x9e3779b1U;
    i ^= i >> 15;
    i *= 0x846ca68bU;
    i ^= i >> 13;
    return static_cast<float>(i >> 8) * 0x1p-24F;
}

const Case sampling_case("clouds/sample", [](const Context& context) {
    const Study& s = study();
    // Short straight runs through the cloud, as rays make them.
    const std::size_t count = 1 << 16;
    std::vector<glm::vec3> points;
    const glm::vec3 low(s.volume.active_low());
    const glm::vec3 size(s.volume.active_high() - s.volume.active_low());
    for (std::uint32_t ray = 0; points.size() < count; ++ray) {
        glm::vec3 p = low + size * glm::vec3(random_at(3 * ray), random_at(3 * ray + 1), random_at(3 * ray + 2));
        for (int i = 0; i < 32; ++i) {
            points.push_back(p);
            p += glm::vec3(0.6F, 0.7F, 0.3F);
        }
    }
    std::vector<float> x;
    std::vector<float> y;
    std::vector<float> z;
    for (const glm::vec3& p : points) {
        x.push_back(p.x);
        y.push_back(p.y);
        z.push_back(p.z);
    }
    std::vector<float> exact(points.size());
    std::vector<float> got(points.size());
    const auto worst = [&] {
        double error = 0.0;
        for (std::size_t i = 0; i < got.size(); ++i) {
            error = std::max(error, std::abs(double(got[i]) - double(exact[i])));
        }
        return error;
    };
    Row row{.module = "clouds",
            .name = "sample, trilinear",
            .method = "OpenVDB accessor + BoxSampler",
            .error_metric = "max absolute density (range 0 .. 1), 65536 points on short rays",
            .reference = "OpenVDB BoxSampler",
            .bytes = double(s.vdb.memory_bytes()),
            .items = double(points.size())};
    context.run(row, [&] { sample_vdb(s.vdb, points, exact); });
    row.method = "bricks, 8 bits, scalar";
    row.bytes = double(s.volume.memory_bytes());
    const auto scalar = [&] {
        for (std::size_t i = 0; i < points.size(); ++i) {
            got[i] = s.volume.sample(points[i]);
        }
    };
    scalar();
    row.error = worst();
    context.run(row, scalar);
    row.method = "bricks, 8 bits, batch";
    sample_batch(s.volume, x, y, z, got);
    row.error = worst();
    context.run(row, [&] { sample_batch(s.volume, x, y, z, got); });
});

const Case depth_case("clouds/optical depth", [](const Context& context) {
    const Study& s = study();
    const Lattice lattice = lattice_over(s.volume, 1, 1, std::size_t(8) << 20);
    const std::vector<float> density = s.volume.block_means(lattice.first, lattice.dims, 1);
    std::vector<std::size_t> active;
    for (std::size_t i = 0; i < density.size(); ++i) {
        if (density[i] > 0.0F) {
            active.push_back(i);
        }
    }
    // The march is timed and compared on every 97th active voxel; times are of a whole bake.
    std::vector<std::size_t> tried;
    for (std::size_t i = 0; i < active.size(); i += 97) {
        tried.push_back(active[i]);
    }
    const auto index_of = [&](std::size_t i) {
        const auto nx = std::size_t(lattice.dims.x);
        const auto ny = std::size_t(lattice.dims.y);
        return glm::dvec3(lattice.first + glm::ivec3(static_cast<int>(i % nx), static_cast<int>(i / nx % ny),
                                                     static_cast<int>(i / nx / ny)));
    };
    std::vector<double> exact;
    for (const std::size_t i : tried) {
        exact.push_back(std::exp(-marched_depth(s.volume, index_of(i), s.sun.to_light, 0.25)));
    }
    const auto rms = [&](const std::vector<double>& depth) {
        double sum = 0.0;
        for (std::size_t i = 0; i < tried.size(); ++i) {
            sum += std::pow(std::exp(-depth[i]) - exact[i], 2.0);
        }
        return std::sqrt(sum / double(tried.size()));
    };
    Row row{.module = "clouds",
            .name = "optical depth to the sun, whole cloud",
            .method = "march, full resolution",
            .error_metric = "RMS transmittance, every 97th active voxel",
            .reference = "march with quarter steps"};
    std::vector<double> marched(tried.size());
    const auto march_some = [&] {
        for (std::size_t i = 0; i < tried.size(); ++i) {
            marched[i] = marched_depth(s.volume, index_of(tried[i]), s.sun.to_light, 1.0);
        }
    };
    march_some();
    row.error = rms(marched);
    const Time time = cpu_time(context, march_some);
    row.module = "clouds";
    row.time_ns = time.ns * double(active.size()) / double(tried.size());
    row.time_spread = time.spread;
    context.add(row);
    // The peer's march: OpenVDB, point by point.
    row.method = "march, OpenVDB BoxSampler";
    row.error = rms(marched);
    std::vector<glm::vec3> points;
    std::size_t rays = 0;
    for (; rays < tried.size() && points.size() < 300000; ++rays) {
        glm::vec3 p(index_of(tried[rays]));
        while (p.y < float(s.volume.active_high().y) && p.z < float(s.volume.active_high().z)) {
            points.push_back(p);
            p += s.sun.to_light;
        }
    }
    std::vector<float> values(points.size());
    const Time peer = cpu_time(context, [&] { sample_vdb(s.vdb, points, values); });
    row.time_ns = peer.ns * double(active.size()) / double(rays);
    row.time_spread = peer.spread;
    context.add(row);
    for (const int factor : {1, 2}) {
        const Lattice on = lattice_over(s.volume, factor, 1, std::size_t(8) << 20);
        const std::vector<float> means = s.volume.block_means(on.first, on.dims, on.factor);
        const glm::vec3 block(static_cast<float>(factor));
        const LightDepth columns = light_depth(on, means, block, s.sun.to_light, 1.0F);
        const Field16 field(on, columns.depth);
        std::vector<double> depth;
        for (const std::size_t i : tried) {
            depth.push_back(double(field.sample(glm::vec3(index_of(i)))));
        }
        row.method = factor == 1 ? "sheared columns" : "sheared columns, half resolution";
        row.error = rms(depth);
        row.bytes = double(field.memory_bytes());
        add(context, row, [&] { keep(light_depth(on, means, block, s.sun.to_light, 1.0F).depth.data()); });
    }
});

// The peer's frame: VolumeRayIntersector, BoxSampler, and a shadow march at every sample.
std::vector<glm::vec3> openvdb_frame(const Camera& view, float step, float shadow_step) {
    const Study& s = study();
    struct Sample {
        std::size_t ray;
        float t;
        float density;
    };
    std::vector<glm::vec3> origins;
    std::vector<glm::vec3> directions;
    for (int y = 0; y < view.height; ++y) {
        for (int x = 0; x < view.width; ++x) {
            origins.emplace_back(view.position_m);
            directions.push_back(view.direction(float(x) + 0.5F, float(y) + 0.5F));
        }
    }
    struct State {
        std::vector<Sample> samples;
        std::vector<float> transmittance;
        float step;
    } state{{}, std::vector<float>(origins.size(), 1.0F), step};
    march_vdb(
        s.vdb, origins, directions, step,
        [](void* user, std::size_t ray, float t, float density) {
            auto& st = *static_cast<State*>(user);
            if (density > 0.0F) {
                st.samples.push_back({ray, t, density});
                st.transmittance[ray] *= std::exp(-density * st.step);
            }
            return st.transmittance[ray] > 1e-3F;
        },
        &state);
    std::vector<glm::vec3> image(origins.size(), glm::vec3(0.0F));
    std::vector<float> transmittance(origins.size(), 1.0F);
    std::vector<glm::vec3> points;
    std::vector<float> densities;
    for (const Sample& sample : state.samples) {
        points.clear();
        glm::vec3 p = origins[sample.ray] + directions[sample.ray] * sample.t + s.sun.to_light * (0.5F * shadow_step);
        while (p.y < float(s.volume.active_high().y + 1) && p.z < float(s.volume.active_high().z + 1)) {
            points.push_back(p);
            p += s.sun.to_light * shadow_step;
        }
        densities.resize(points.size());
        sample_vdb(s.vdb, points, densities);
        float depth = 0.0F;
        for (const float d : densities) {
            depth += d * shadow_step;
        }
        const glm::vec3 off = s.sun.to_light - directions[sample.ray];
        const float phase = phase_value(s.medium.phase, 0.5F * (off.x * off.x + off.y * off.y + off.z * off.z));
        const float e = std::exp(-sample.density * step);
        image[sample.ray] +=
            glm::vec3(transmittance[sample.ray] * (1.0F - e) * s.medium.albedo * phase * std::exp(-depth));
        transmittance[sample.ray] *= e;
    }
    return image;
}

const Case frame_case("clouds/frame", [](const Context& context) {
    const Study& s = study();
    const Camera view = camera(context.quick() ? 48 : 96, context.quick() ? 27 : 54);
    const std::vector<glm::vec3> exact = openvdb_frame(view, 0.25F, 0.25F);
    Row row{.module = "clouds",
            .name = "frame, single scattering, 96 x 54",
            .method = "",
            .error_metric = "relative RMSE of luminance",
            .reference = "OpenVDB, quarter-voxel steps for rays and shadows"};
    for (const auto& [step, shadow] :
         {std::pair{0.5F, 1.0F}, {1.0F, 1.0F}, {2.0F, 1.0F}, {2.0F, 2.0F}, {3.0F, 2.0F}, {4.0F, 4.0F}}) {
        row.method = "OpenVDB VolumeRayIntersector, steps " + std::to_string(step).substr(0, 3) + ", " +
                     std::to_string(shadow).substr(0, 3);
        row.error = relative_rmse(openvdb_frame(view, step, shadow), exact);
        add(context, row, [&, s1 = step, s2 = shadow] { keep(openvdb_frame(view, s1, s2).data()); });
    }
    LightingSettings settings;
    settings.method = LightingMethod::single_scattering;
    CloudLighting lighting;
    lighting.reset(s.volume, s.medium, settings);
    lighting.bake_light(0, s.sun);
    for (const float step : {0.25F, 0.5F, 1.0F, 2.0F, 4.0F}) {
        MarchSettings march_settings;
        march_settings.step_voxels = step;
        row.method = "bricks, vectors, step " + std::to_string(step).substr(0, 4);
        row.error = relative_rmse(march(s.volume, lighting, view, march_settings).radiance, exact);
        add(context, row, [&] { keep(march(s.volume, lighting, view, march_settings).radiance.data()); });
    }
    row.method = "bricks, scalar, step 1";
    row.error = relative_rmse(march_scalar(s.volume, lighting, view).radiance, exact);
    add(context, row, [&] { keep(march_scalar(s.volume, lighting, view).radiance.data()); });
});

// What structure finer than a voxel costs, standing and drifting: the error is how far it changes the picture.
const Case detail_case("clouds/detail", [](const Context& context) {
    const Study& s = study();
    const Camera view = camera(context.quick() ? 48 : 96, context.quick() ? 27 : 54);
    CloudLighting lighting;
    lighting.reset(s.volume, s.medium, {});
    lighting.bake_light(0, s.sun);
    const CloudLighting::ViewFields fields = lighting.contract(s.volume.transform().index_from_world(view.position_m));
    const DetailTexture texture;
    MarchSettings settings;
    settings.fields = &fields;
    const Picture plain = march(s.volume, lighting, view, settings);
    Row row{.module = "clouds",
            .name = "detail, 96 x 54",
            .method = "none",
            .error_metric = "relative RMSE of luminance: what detail changes",
            .reference = "without detail"};
    add(context, row, [&] { keep(march(s.volume, lighting, view, settings).radiance.data()); });
    settings.detail = &texture;
    row.method = "standing";
    row.bytes = double(texture.data().size());
    row.error = relative_rmse(march(s.volume, lighting, view, settings).radiance, plain.radiance);
    add(context, row, [&] { keep(march(s.volume, lighting, view, settings).radiance.data()); });
    settings.detail_offsets = detail_drift(1000.0, 60.0);
    row.method = "drifting";
    row.error = relative_rmse(march(s.volume, lighting, view, settings).radiance, plain.radiance);
    add(context, row, [&] { keep(march(s.volume, lighting, view, settings).radiance.data()); });
});

const Case bake_case("clouds/bake", [](const Context& context) {
    const Study& s = study();
    Row row{.module = "clouds",
            .name = "bake, study cloud",
            .method = "",
            .error_metric = "relative change of the scalar flux in the last sweep",
            .reference = "docs/clouds.md has the error against the path tracer"};
    for (const int factor : {3, 2}) {
        LightingSettings settings;
        settings.transport_factor = factor;
        settings.max_transport_cells = std::size_t(1) << 23;
        settings.sweeps = factor == 2 ? 4 : settings.sweeps;
        const std::string grid = factor == 2 ? ", half grid, 4 sweeps" : ", third grid, 6 sweeps";
        CloudLighting lighting;
        row.method = "transport: preparation" + grid;
        add(context, row, [&] { lighting.reset(s.volume, s.medium, settings); });
        row.method = "transport: sun, cold" + grid;
        row.error = double(lighting.bake_light(0, s.sun, false).residual);
        add(context, row, [&] { lighting.bake_light(0, s.sun, false); });
        row.method = "transport: sky, cold" + grid;
        row.error = double(lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)), false).residual);
        add(context, row, [&] { lighting.bake_sky(SkySh::uniform(glm::vec3(1.0F)), false); });
        row.method = "transport: sun and sky side by side, cold" + grid;
        add(context, row, [&] {
            lighting.start_light(0, s.sun, false);
            lighting.start_sky(SkySh::uniform(glm::vec3(1.0F)), false);
            lighting.finish();
        });
        row.method = "transport: turning sun, one warm sweep" + grid;
        row.error = double(lighting.bake_light(0, s.sun).residual);
        add(context, row, [&] { lighting.bake_light(0, s.sun); });
        row.method = "transport: turning sun, what a frame waits for" + grid;
        row.error = 0.0;
        add(context, row, [&] { lighting.start_light(0, s.sun); });
        row.bytes = double(lighting.memory_bytes());
        row.method = "transport: fields for an eye" + grid;
        add(context, row, [&] { keep(lighting.contract(glm::dvec3(300.0, 0.0, 0.0)).fields.size()); });
        row.bytes = 0.0;
    }
    for (const auto& [method, name] :
         {std::pair{LightingMethod::single_scattering, "single scattering"},
          std::pair{LightingMethod::harris, "Harris"}, std::pair{LightingMethod::octaves, "octaves"}}) {
        LightingSettings settings;
        settings.method = method;
        CloudLighting lighting;
        lighting.reset(s.volume, s.medium, settings);
        row.method = std::string(name) + ": sun";
        row.error = 0.0;
        add(context, row, [&] { lighting.bake_light(0, s.sun); });
    }
});

// A small ragged cloud whose reference a benchmark can afford; the study's tables are in docs/clouds.md. What follows
// holds methods, steps, density formats and light grids to it.
struct Truth {
    SparseGrid grid = noise_cloud(42, 48);
    BrickVolume volume{grid};
    Medium medium{1.0F, 0.99F, {PhaseKind::henyey_greenstein, 0.5F, 0.0F, 1.0F}};
    DirectionalLight sun{{0.0F, 0.8660254F, 0.5F}, glm::vec3(1.0F), 0.0F};
    Camera view = look_at(glm::dvec3(124.0, 44.0, 34.0), glm::dvec3(24.0), 0.3F, 32, 24);
    Camera fine = view;
    ReferenceImage image{32, 24};

    Truth() {
        fine.width *= 4;
        fine.height *= 4;
        ReferenceScene scene;
        scene.grid = &grid;
        scene.medium = medium;
        scene.lights = {sun};
        PathTracer(std::move(scene)).render(view, image, 0, 2048);
    }
    // Of a picture by `fine`, over the pixels that the cloud covers; not below what the reference's noise resolves: the
    // spread of the mean over pixels of a product of two halves' errors.
    [[nodiscard]] double error(const Picture& rays) const {
        std::vector<glm::vec3> mean(32 * 24, glm::vec3(0.0F));
        std::vector<float> clear(mean.size(), 0.0F);
        for (std::size_t i = 0; i < rays.radiance.size(); ++i) {
            const std::size_t to = i / 128 / 4 * 32 + i % 128 / 4;
            mean[to] += rays.radiance[i] / 16.0F;
            clear[to] += rays.transmittance[i] / 16.0F;
        }
        std::vector<bool> mask;
        for (const float t : clear) {
            mask.push_back(t < 0.99F);
        }
        const ImageError error = image_error(mean, image, mask);
        const auto pixels = double(std::count(mask.begin(), mask.end(), true));
        return std::max(error.relative_rmse, error.noise * std::sqrt(2.0 / std::sqrt(pixels)));
    }
    static Row row(const char* name) {
        return {.module = "clouds",
                .name = name,
                .method = "",
                .error_metric = "relative RMSE of luminance, 32 x 24 pixels of 4 x 4 rays, side view",
                .reference = "path tracer, 2048 samples a pixel, its noise taken out as far as it goes"};
    }
};

const Truth& truth() {
    static const Truth value;
    return value;
}

const Case lighting_case("clouds/lighting", [](const Context& context) {
    const Truth& t = truth();
    struct Tried {
        const char* name;
        LightingMethod method;
        int factor;
        int sweeps;
    };
    for (const Tried& tried : {Tried{"(a) single scattering", LightingMethod::single_scattering, 2, 4},
                               {"(b) Harris", LightingMethod::harris, 2, 4},
                               {"(c) octaves", LightingMethod::octaves, 2, 4},
                               {"(d) transport, quarter grid, 4 sweeps", LightingMethod::transport, 4, 4},
                               {"(d) transport, third grid, 4 sweeps", LightingMethod::transport, 3, 4},
                               {"(d) transport, third grid, 6 sweeps", LightingMethod::transport, 3, 6},
                               {"(d) transport, half grid, P1 only", LightingMethod::transport, 2, 0},
                               {"(d) transport, half grid, 1 sweep", LightingMethod::transport, 2, 1},
                               {"(d) transport, half grid, 2 sweeps", LightingMethod::transport, 2, 2},
                               {"(d) transport, half grid, 4 sweeps", LightingMethod::transport, 2, 4},
                               {"(d) transport, half grid, 8 sweeps", LightingMethod::transport, 2, 8},
                               {"(d) transport, full grid, 6 sweeps", LightingMethod::transport, 1, 6}}) {
        LightingSettings settings;
        settings.method = tried.method;
        settings.transport_factor = tried.factor;
        settings.max_transport_cells = std::size_t(1) << 23;
        settings.sweeps = tried.sweeps;
        CloudLighting lighting;
        lighting.reset(t.volume, t.medium, settings);
        lighting.bake_light(0, t.sun, false);
        Row row = Truth::row("image error against bake time, noise cloud");
        row.method = tried.name;
        row.error = t.error(march(t.volume, lighting, t.fine));
        row.bytes = double(lighting.memory_bytes());
        add(context, row, [&] { lighting.bake_light(0, t.sun, false); });
    }
});

const Case step_case("clouds/step", [](const Context& context) {
    const Truth& t = truth();
    CloudLighting lighting;
    lighting.reset(t.volume, t.medium, {});
    lighting.bake_light(0, t.sun);
    const CloudLighting::ViewFields fields =
        lighting.contract(t.volume.transform().index_from_world(t.view.position_m));
    MarchSettings settings;
    settings.fields = &fields;
    Row row = Truth::row("image error against march time by step, noise cloud, (d)");
    const auto add_row = [&](const std::string& name) {
        row.method = name;
        row.error = t.error(march(t.volume, lighting, t.fine, settings));
        add(context, row, [&] { keep(march(t.volume, lighting, t.fine, settings).radiance.data()); });
    };
    for (const float step : {0.25F, 0.5F, 1.0F, 2.0F, 4.0F, 8.0F}) {
        settings.step_voxels = step;
        add_row("step " + std::to_string(step).substr(0, 4));
    }
    settings.step_voxels = 1.0F;
    for (const float optical : {0.5F, 1.0F}) {
        settings.optical_step = optical;
        add_row("step 1, up to an optical depth of " + std::to_string(optical).substr(0, 3));
    }
});

const Case format_case("clouds/density format", [](const Context& context) {
    const Truth& t = truth();
    CloudLighting lighting;
    lighting.reset(t.volume, t.medium, {});
    lighting.bake_light(0, t.sun);
    const CloudLighting::ViewFields fields =
        lighting.contract(t.volume.transform().index_from_world(t.view.position_m));
    MarchSettings settings;
    settings.fields = &fields;
    Row row = Truth::row("image error against march time by density format, noise cloud, (d)");
    row.method = "bricks of 8 bits";
    row.bytes = double(t.volume.memory_bytes());
    row.error = t.error(march(t.volume, lighting, t.fine, settings));
    add(context, row, [&] { keep(march(t.volume, lighting, t.fine, settings).radiance.data()); });
    for (const float part : {96.0F, 24.0F, 12.0F, 6.0F, 3.0F}) {
        CompactSettings compact_settings;
        compact_settings.density_error = 1.0F / part;
        const CompactCloud compact(t.volume, lighting, t.view.position_m, compact_settings);
        row.method = "compact, density within 1/" + std::to_string(static_cast<int>(part));
        row.bytes = double(compact.density_bytes());
        row.error = t.error(march(compact, t.fine));
        add(context, row, [&] { keep(march(compact, t.fine).radiance.data()); });
    }
    for (const int level : {1, 2}) {
        const BrickVolume coarse(coarsen(t.grid, level));
        CloudLighting coarse_lighting;
        coarse_lighting.reset(coarse, t.medium, {});
        coarse_lighting.bake_light(0, t.sun);
        row.method = "bricks of 8 bits, voxels x " + std::to_string(1 << level);
        row.bytes = double(coarse.memory_bytes());
        row.error = t.error(march(coarse, coarse_lighting, t.fine));
        add(context, row, [&] { keep(march(coarse, coarse_lighting, t.fine).radiance.data()); });
    }
});

const Case light_grid_case("clouds/light grid", [](const Context& context) {
    const Truth& t = truth();
    Row row = Truth::row("image error against bake time by light grid, noise cloud, (d)");
    for (const auto& [depth, cells] : {std::pair{1, 1}, {1, 2}, {1, 3}, {1, 4}, {1, 6}, {2, 2}, {2, 4}, {4, 4}}) {
        LightingSettings settings;
        settings.depth_factor = depth;
        settings.transport_factor = cells;
        settings.max_transport_cells = std::size_t(1) << 23;
        CloudLighting lighting;
        lighting.reset(t.volume, t.medium, settings);
        lighting.bake_light(0, t.sun, false);
        row.method = "depth every " + std::to_string(depth) + ", cells of " + std::to_string(cells) + " voxels";
        row.bytes = double(lighting.memory_bytes());
        row.error = t.error(march(t.volume, lighting, t.fine));
        add(context, row, [&] { lighting.bake_light(0, t.sun, false); });
    }
});

const Case reference_case("clouds/reference", [](const Context& context) {
    const Study& s = study();
    ReferenceScene scene;
    scene.grid = &s.grid;
    scene.medium = s.medium;
    scene.lights = {s.sun};
    const PathTracer tracer(std::move(scene));
    const Camera view = camera(160, 90);
    ReferenceImage image(160, 90);
    const int samples = context.quick() ? 4 : 16;
    Row row{.module = "clouds",
            .name = "path tracer, 160 x 90",
            .method = "delta and ratio tracking",
            .error_metric = "unbiased",
            .reference = "itself",
            .items = double(samples) * 160.0 * 90.0};
    add(context, row, [&] { tracer.render(view, image, 0, std::uint64_t(samples)); });
});

// Everything that drawing reads, against the float grid in OpenVDB, and the error of the study's pictures (96 x 54
// pixels of 4 x 4 rays) against the plain form. Times are of a frame.
const Case memory_case("clouds/memory", [](const Context& context) {
    const Study& s = study();
    const auto averaged = [](const Picture& rays) {
        std::vector<glm::vec3> image(rays.radiance.size() / 16, glm::vec3(0.0F));
        const auto width = std::size_t(rays.width);
        for (std::size_t i = 0; i < rays.radiance.size(); ++i) {
            image[i / width / 4 * (width / 4) + i % width / 4] += rays.radiance[i] / 16.0F;
        }
        return image;
    };
    struct Tried {
        const char* name;
        LightingMethod method;
        bool sky;
        glm::dvec3 eye;
    };
    const glm::dvec3 side(260.0, -120.0, -60.0);
    const glm::dvec3 back(55.0, -290.0, -110.0);
    for (const Tried& tried :
         {Tried{"memory, (d) transport, sun, side", LightingMethod::transport, false, side},
          {"memory, (d) transport, sun, back", LightingMethod::transport, false, back},
          {"memory, (d) transport, sun and blue sky, side", LightingMethod::transport, true, side},
          {"memory, (a) single scattering, side", LightingMethod::single_scattering, false, side},
          {"memory, (a) single scattering, back", LightingMethod::single_scattering, false, back}}) {
        LightingSettings settings;
        settings.method = tried.method;
        CloudLighting lighting;
        lighting.reset(s.volume, s.medium, settings);
        lighting.bake_light(0, s.sun);
        if (tried.sky) {
            lighting.bake_sky(SkySh::uniform(glm::vec3(0.03F, 0.05F, 0.1F)));
        }
        const Camera view = look_at(s.centre + tried.eye, s.centre, 0.30F, 4 * 96, 4 * 54);
        const CloudLighting::ViewFields fields =
            lighting.contract(s.volume.transform().index_from_world(view.position_m));
        MarchSettings march_settings;
        march_settings.fields = &fields;
        const std::vector<glm::vec3> plain = averaged(march(s.volume, lighting, view, march_settings));
        Row row{.module = "clouds",
                .name = tried.name,
                .method = "OpenVDB's tree alone, floats",
                .error_metric = "relative RMSE of luminance, 96 x 54 pixels of 4 x 4 rays",
                .reference = "bricks of 8 bits, dense fields of 16"};
        row.bytes = double(s.vdb.memory_bytes());
        context.add(row);
        double bytes = double(s.volume.memory_bytes() + lighting.table().values().size() * sizeof(float) +
                              lighting.lights()[0].depth.memory_bytes());
        for (const Field16& field : fields.fields) {
            bytes += double(field.memory_bytes());
        }
        row.method = "plain: bricks, depth, fields for an eye, beam table";
        row.bytes = bytes;
        add(context, row, [&] { keep(march(s.volume, lighting, view, march_settings).radiance.data()); });
        for (const float tighter : {0.5F, 1.0F, 2.0F, 4.0F}) {
            CompactSettings compact_settings;
            compact_settings.density_error /= tighter;
            compact_settings.depth_error /= tighter;
            compact_settings.light_error /= tighter;
            const CompactCloud compact(s.volume, lighting, view.position_m, compact_settings);
            row.method =
                tighter == 1.0F ? "compact" : "compact, errors x " + std::to_string(1.0F / tighter).substr(0, 4);
            row.bytes = double(compact.memory_bytes());
            row.error = relative_rmse(averaged(march(compact, view)), plain);
            add(context, row, [&] { keep(march(compact, view).radiance.data()); });
            if (tighter == 1.0F) {
                row.method = "compact: making density and light";
                add(context, row, [&] { keep(CompactCloud(s.volume, lighting, view.position_m).lights().data()); });
            }
        }
    }
});

} // namespace
} // namespace alpenglow::bench
