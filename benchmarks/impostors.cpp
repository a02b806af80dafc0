// Impostors: image error against angle for each representation, with what a drawn pixel costs; the metrics against what
// they predict; captures and plans.
#include "bench.hpp"

#include "../tests/modules/impostors/blob_cloud.hpp"

#include <alpenglow/core/timing.hpp>
#include <alpenglow/impostors/error.hpp>
#include <alpenglow/impostors/reproject.hpp>
#include <alpenglow/impostors/scheduler.hpp>
#include <alpenglow/impostors/store.hpp>

#if __has_include(<alpenglow/clouds/march.hpp>) && __has_include(<alpenglow/systems/cloud_impostors.hpp>)
#define ALPENGLOW_BENCH_REAL_CLOUDS
#include "../tests/modules/impostors/real_cloud.hpp"
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>

namespace alpenglow::bench {
namespace {

using namespace impostors;

constexpr double degree = std::numbers::pi / 180.0;
constexpr double distance_m = 4.0; // in radii
constexpr int pixels = 96;

struct Method {
    const char* name;
    Representation representation;
    int layers;
    Filter filter;
};
constexpr std::array methods{
    Method{"plane", Representation::plane, 1, Filter::bilinear},
    Method{"depth warp", Representation::depth_warp, 1, Filter::bilinear},
    Method{"4 layers", Representation::layers, 4, Filter::bilinear},
    Method{"8 layers", Representation::layers, 8, Filter::bilinear},
    Method{"16 layers", Representation::layers, 16, Filter::bilinear},
    Method{"4 warped layers", Representation::warped_layers, 4, Filter::bilinear},
    Method{"8 warped layers", Representation::warped_layers, 8, Filter::bilinear},
    Method{"8 warped layers, cubic", Representation::warped_layers, 8, Filter::cubic},
    Method{"2 warped layers", Representation::warped_layers, 2, Filter::bilinear},
};

Frustum orbit(double angle) {
    const glm::dvec3 eye = distance_m * glm::dvec3(0.8 * std::sin(angle), -std::cos(angle), 0.6 * std::sin(angle));
    return look_at(eye, {0, 0, 0}, {0, 0, 1}, 2.0 * std::atan(1.0 / std::sqrt(distance_m * distance_m - 1.0)), pixels,
                   pixels);
}

Capture take(const test::BlobCloud& cloud, const Method& method) {
    CaptureSettings settings;
    settings.representation = method.representation;
    settings.layers = method.layers;
    const auto frustum = fit_frustum(cloud.bounds, orbit(0.0).eye_m, {0, 0, 1}, pixels * 5 / 4);
    return std::move(capture(cloud.bounds, *frustum, settings, test::drawable(cloud)).value());
}

double megabytes(const Capture& picture) {
    double bytes = 0.0;
    for (const Layer& layer : picture.layers) {
        for (const MipLevel& mip : layer.mips) {
            bytes += static_cast<double>(mip.colour.size() * sizeof(glm::vec4) + mip.fill.size() * sizeof(glm::vec4) +
                                         mip.depth.size() * sizeof(glm::vec2));
        }
        bytes += static_cast<double>(layer.warp.size() * sizeof(float));
    }
    return bytes;
}

test::BlobCloud detailed_cloud() {
    test::BlobCloud cloud = test::make_blob_cloud(600, 1, {0.3, 0.4, 0.866}, 30.0, 2.5);
    cloud.steps = 32;
    return cloud;
}

const Case orbit_case("impostors/orbit", [](const Context& context) {
    const test::BlobCloud cloud = detailed_cloud();
    const std::vector<double> angles =
        context.quick() ? std::vector<double>{0.15, 1.0, 5.0} : std::vector<double>{0.15, 0.5, 1.0, 2.0, 5.0, 10.0};
    std::vector<std::vector<glm::vec4>> exact;
    for (const double angle : angles) {
        exact.push_back(test::draw_directly(cloud, orbit(angle * degree)));
    }
    const double count = static_cast<double>(pixels) * pixels;
    const Time direct = context.time(count, [&] { keep(test::draw_directly(cloud, orbit(0.01))); });
    std::vector<glm::vec4> image(exact[0].size());
    std::vector<double> held(methods.size(), 0.0);
    for (std::size_t m = 0; m < methods.size(); ++m) {
        const Method& method = methods[m];
        const Capture picture = take(cloud, method);
        DrawSettings settings;
        settings.filter = method.filter;
        settings.threads = 1;
        const Frustum typical = orbit(degree);
        const Time time = context.time(count, [&] {
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, typical, settings, image);
            keep(image);
        });
        for (std::size_t a = 0; a < angles.size(); ++a) {
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, orbit(angles[a] * degree), settings, image);
            char name[64];
            std::snprintf(name, sizeof name, "orbit by %.4g degrees", angles[a]);
            Row row{"impostors",
                    name,
                    method.name,
                    time.ns,
                    time.spread,
                    test::relative_rmse(image, exact[a]),
                    "relative RMSE, 600 blobs at 4 radii",
                    "direct march",
                    megabytes(picture),
                    count};
            context.add(row);
            row.name += ", tone mapped";
            row.error = test::tone_mapped_psnr(image, exact[a]);
            row.error_metric = "PSNR in dB, larger is better";
            context.add(row);
        }
        // How far 40 dB hold: bisection, to 20 degrees.
        double low = 0.0;
        double high = 20.0;
        for (int step = 0; step < (context.quick() ? 4 : 7); ++step) {
            const double angle = 0.5 * (low + high);
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, orbit(angle * degree), settings, image);
            const bool holds = test::tone_mapped_psnr(image, test::draw_directly(cloud, orbit(angle * degree))) >= 40.0;
            (holds ? low : high) = angle;
        }
        held[m] = low;
        context.add({"impostors", "degrees of orbit at 40 dB", method.name, time.ns, time.spread, low,
                     "degrees held (20 is where the search ends), larger is better", "direct march", megabytes(picture),
                     count});
    }
    for (std::size_t a = 0; a < angles.size(); ++a) {
        char name[64];
        std::snprintf(name, sizeof name, "orbit by %.4g degrees", angles[a]);
        context.add({"impostors", name, "direct march", direct.ns, direct.spread, 0.0,
                     "relative RMSE, 600 blobs at 4 radii", "itself", 0.0, count});
    }
});

const Case zoom_case("impostors/zoom", [](const Context& context) {
    const test::BlobCloud cloud = detailed_cloud();
    const Frustum view = orbit(0.0);
    for (const double closer : {0.01, 0.05, 0.2}) {
        Frustum nearer = view;
        nearer.eye_m *= 1.0 - closer;
        const auto exact = test::draw_directly(cloud, nearer);
        for (const Method& method : methods) {
            const Capture picture = take(cloud, method);
            std::vector<glm::vec4> image(exact.size(), glm::vec4(0.0F));
            DrawSettings settings;
            settings.filter = method.filter;
            draw(picture, nearer, settings, image);
            char name[64];
            std::snprintf(name, sizeof name, "nearer by %.0f %%", 100.0 * closer);
            context.add({"impostors", name, method.name, 0.0, 0.0, test::relative_rmse(image, exact),
                         "relative RMSE, 600 blobs at 4 radii", "direct march", megabytes(picture), 1.0});
        }
        if (context.quick()) {
            break;
        }
    }
});

const Case metric_case("impostors/metrics", [](const Context& context) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    std::vector<glm::dvec3> eyes;
    for (int i = 0; i < 256; ++i) {
        eyes.emplace_back(0.1 * normal(random), -4.0 + 0.1 * normal(random), 0.1 * normal(random));
    }
    const Sphere bounds{{0, 0, 0}, 1.0};
    const glm::dvec3 from(0, -4, 0);
    // Against the worst of 2000 points spread over the ball.
    std::vector<double> ratio;
    for (const glm::dvec3& eye : eyes) {
        double worst = 0.0;
        for (int k = 0; k < 2000; ++k) {
            glm::dvec3 p(normal(random), normal(random), normal(random));
            p = glm::normalize(p);
            const glm::dvec3 q = from + (p - from) * (4.0 / (p.y + 4.0));
            worst = std::max(worst, angle_between(p - eye, q - eye));
        }
        const double bound = translation_angle(bounds, from, eye);
        ratio.push_back(bound / worst);
    }
    std::sort(ratio.begin(), ratio.end());
    Row row{"impostors",
            "translation angle",
            "search over rays",
            0.0,
            0.0,
            ratio[ratio.size() / 2] - 1.0,
            "median of bound / worst point - 1, at 4 radii",
            "2000 points of the sphere",
            0.0,
            256.0};
    context.run(row, [&] {
        double sum = 0.0;
        for (const glm::dvec3& eye : eyes) {
            sum += translation_angle(bounds, from, eye);
        }
        keep(sum);
    });
    const test::BlobCloud cloud = test::make_blob_cloud(120, 7);
    for (std::size_t m : {0UL, 1UL, 3UL, 6UL}) {
        const Capture picture = take(cloud, methods[m]);
        std::vector<double> over_measured;
        std::vector<glm::vec4> image(static_cast<std::size_t>(pixels) * pixels);
        for (const double angle : {0.5, 1.0, 2.0, 4.0}) {
            const Frustum view = orbit(angle * degree);
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, view, {}, image);
            over_measured.push_back(predicted_error(picture, view.eye_m) /
                                    test::relative_rmse(image, test::draw_directly(cloud, view)));
        }
        Row predicted{"impostors",
                      "predicted image error",
                      methods[m].name,
                      0.0,
                      0.0,
                      0.0,
                      "mean of |log2(predicted / measured)|, 0.5 to 4 degrees",
                      "direct march",
                      0.0,
                      256.0};
        for (const double r : over_measured) {
            predicted.error += std::abs(std::log2(r)) / static_cast<double>(over_measured.size());
        }
        context.run(predicted, [&] {
            double sum = 0.0;
            for (const glm::dvec3& eye : eyes) {
                sum += predicted_error(picture, eye);
            }
            keep(sum);
        });
    }
});

const Case capture_case("impostors/capture", [](const Context& context) {
    const test::BlobCloud cloud = test::make_blob_cloud(40, 3);
    const Frustum frustum = *fit_frustum(cloud.bounds, {0, -4, 0}, {0, 0, 1}, 128);
    // Until a large block has been freed once, glibc gives all memory back and faults it in anew with every call.
    keep(std::vector<float>(6 << 20));
    for (std::size_t m : {0UL, 1UL, 3UL, 6UL}) {
        CaptureSettings settings;
        settings.representation = methods[m].representation;
        settings.layers = methods[m].layers;
        std::vector<SlabImage> kept;
        const Drawable once = [&](const CaptureRequest& request, std::span<SlabImage> slabs) -> Status {
            test::draw_blobs(cloud, request, slabs);
            kept.assign(slabs.begin(), slabs.end());
            return Ok{};
        };
        (void)capture(cloud.bounds, frustum, settings, once);
        const Drawable again = [&](const CaptureRequest&, std::span<SlabImage> slabs) -> Status {
            std::copy(kept.begin(), kept.end(), slabs.begin());
            return Ok{};
        };
        // The images alone, zeroed and filled: a part of all rows.
        const std::string name = std::string("keeping a picture, ") + methods[m].name;
        const double texels = 128.0 * 128.0;
        context.run({"impostors", name, "images alone", 0.0, 0.0, 0.0, "per texel, without drawing", "", 0.0, texels},
                    [&] {
                        std::vector<SlabImage> images(kept.size());
                        for (SlabImage& image : images) {
                            image.colour.assign(kept[0].colour.size(), glm::vec4(0.0F));
                            image.depth.assign(kept[0].depth.size(), glm::vec2(0.0F));
                        }
                        std::copy(kept.begin(), kept.end(), images.begin());
                        keep(images);
                    });
        context.run({"impostors", name, "scalar", 0.0, 0.0, 0.0, "per texel, without drawing", "", 0.0, texels},
                    [&] { keep(capture_scalar(cloud.bounds, frustum, settings, again)); });
        context.run({"impostors", name, "vectors", 0.0, 0.0, 0.0, "per texel, without drawing", "", 0.0, texels},
                    [&] { keep(capture(cloud.bounds, frustum, settings, again)); });
        settings.mips = false;
        context.run(
            {"impostors", name, "vectors, without mips", 0.0, 0.0, 0.0, "per texel, without drawing", "", 0.0, texels},
            [&] { keep(capture(cloud.bounds, frustum, settings, again)); });
    }
});

const Case plan_case("impostors/plan", [](const Context& context) {
    for (const int count : {100, 10000}) {
        std::mt19937 random(2);
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        std::vector<SceneObject> objects(static_cast<std::size_t>(count));
        for (std::size_t i = 0; i < objects.size(); ++i) {
            objects[i].id = i + 1;
            objects[i].bounds = {{5000.0 * uniform(random), 6000.0 + 5000.0 * uniform(random), 500.0 * uniform(random)},
                                 60.0};
        }
        Scheduler scheduler = std::move(Scheduler::create().value());
        std::vector<SceneView> views{{1, look_at({0, 0, 0}, {0, 5000, 0}, {0, 0, 1}, 1.0, 960, 540)}};
        Plan plan;
        double now = 0.0;
        double seen = 0.0;
        double reused = 0.0;
        const auto step = [&] {
            views[0].frustum.eye_m.y += 1.0;
            if (views[0].frustum.eye_m.y > 3000.0) {
                views[0].frustum.eye_m.y = 0.0;
            }
            now += 1.0 / 60.0;
            scheduler.plan(objects, views, {}, now, plan);
            seen += plan.report.seen;
            reused += plan.report.reused;
        };
        for (int k = 0; k < (context.quick() ? 20 : 100); ++k) {
            step();
        }
        seen = reused = 0.0;
        const Time time = context.time(count, step);
        context.add({"impostors", "plan a frame at 60 m/s, " + std::to_string(count) + " objects", "scheduler", time.ns,
                     time.spread, 1.0 - reused / seen, "share of objects captured a frame", "", 0.0,
                     static_cast<double>(count)});
    }
});

#ifdef ALPENGLOW_BENCH_REAL_CLOUDS
// The clouds module's own clouds, lit by its own light: what a game shows.
Frustum around(const Sphere& bounds, const glm::dvec3& eye, int side) {
    const double d = glm::length(bounds.centre_m - eye);
    const double tangent = bounds.radius_m / std::sqrt(d * d - bounds.radius_m * bounds.radius_m);
    return look_at(eye, bounds.centre_m, {0, 0, 1}, 2.0 * std::atan(tangent), side, side);
}

const Case real_orbit_case("impostors/real-orbit", [](const Context& context) {
    const test::RealCloud cloud(1, 0);
    const auto view = [&](double angle) {
        return around(cloud.bounds,
                      cloud.bounds.centre_m +
                          4.0 * cloud.bounds.radius_m * glm::dvec3(std::sin(angle), -std::cos(angle), 0.0),
                      pixels);
    };
    const std::vector<double> angles =
        context.quick() ? std::vector<double>{1.0, 5.0} : std::vector<double>{0.15, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0};
    std::vector<std::vector<glm::vec4>> exact;
    for (const double angle : angles) {
        exact.push_back(cloud.directly(view(angle * degree)));
    }
    const double count = static_cast<double>(pixels) * pixels;
    const Time direct = context.time(count, [&] { keep(cloud.directly(view(0.01), nullptr, 1)); });
    std::vector<glm::vec4> image(exact[0].size());
    for (const Method& method : methods) {
        CaptureSettings settings;
        settings.representation = method.representation;
        settings.layers = method.layers;
        const Frustum from = *fit_frustum(cloud.bounds, view(0.0).eye_m, {0, 0, 1}, pixels * 5 / 4);
        const Capture picture = std::move(capture(cloud.bounds, from, settings, cloud.drawable()).value());
        DrawSettings draw_settings;
        draw_settings.filter = method.filter;
        draw_settings.threads = 1;
        const Time time = context.time(count, [&] {
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, view(degree), draw_settings, image);
            keep(image);
        });
        for (std::size_t a = 0; a < angles.size(); ++a) {
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, view(angles[a] * degree), draw_settings, image);
            char name[64];
            std::snprintf(name, sizeof name, "cumulus, orbit by %.4g degrees", angles[a]);
            Row row{"impostors",
                    name,
                    method.name,
                    time.ns,
                    time.spread,
                    test::relative_rmse(image, exact[a]),
                    "relative RMSE, cumulus at 4 radii",
                    "direct march",
                    megabytes(picture),
                    count};
            context.add(row);
            row.name += ", tone mapped";
            row.error = test::tone_mapped_psnr(image, exact[a]);
            row.error_metric = "PSNR in dB, larger is better";
            context.add(row);
        }
        // How far 40 dB hold: bisection, to 40 degrees.
        double low = 0.0;
        double high = 40.0;
        for (int step = 0; step < (context.quick() ? 4 : 8); ++step) {
            const double angle = 0.5 * (low + high);
            std::fill(image.begin(), image.end(), glm::vec4(0.0F));
            draw(picture, view(angle * degree), draw_settings, image);
            (test::tone_mapped_psnr(image, cloud.directly(view(angle * degree))) >= 40.0 ? low : high) = angle;
        }
        context.add({"impostors", "cumulus, degrees of orbit at 40 dB", method.name, time.ns, time.spread, low,
                     "degrees held (40 is where the search ends), larger is better", "direct march", megabytes(picture),
                     count});
    }
    context.add({"impostors", "cumulus, one picture", "direct march", direct.ns, direct.spread, 0.0,
                 "relative RMSE, cumulus at 4 radii", "itself", 0.0, count});
});

// A flight past three cumuli, with all tolerances a multiple of the defaults: what a frame costs, what it shows, and
// how many pictures are used again.
const Case flight_case("impostors/flight", [](const Context& context) {
    const test::RealCloud cloud(1, 0);
    const double radius = cloud.bounds.radius_m;
    const glm::dvec3 places[] = {radius * glm::dvec3(-2.5, 4.0, 0.3), radius * glm::dvec3(2.0, 6.0, 0.0),
                                 radius * glm::dvec3(0.5, 9.0, -0.5)};
    std::vector<Drawable> drawables;
    for (const glm::dvec3& place : places) {
        CloudSubject subject{&cloud.volume, &cloud.lighting, place - cloud.bounds.centre_m, {}, 1.0F};
        subject.march.step_voxels = cloud.step_voxels;
        subject.march.threads = 1;
        drawables.push_back(cloud_drawable(subject));
    }
    constexpr int width = 320;
    constexpr int height = 180;
    const int frames = context.quick() ? 20 : 90;
    const auto view_at = [&](int frame) {
        const glm::dvec3 eye = radius * glm::dvec3(0.0, 0.04 * frame, 0.2); // two and a half radii a second
        return look_at(eye, eye + glm::dvec3(0.0, 1.0, 0.0), {0, 0, 1}, 0.9, width, height);
    };
    const auto direct = [&](int frame) {
        std::vector<glm::vec4> image(static_cast<std::size_t>(width) * height, glm::vec4(0.0F));
        for (const std::size_t i : {2UL, 1UL, 0UL}) {
            Frustum view = view_at(frame);
            view.eye_m -= places[i] - cloud.bounds.centre_m;
            over(cloud.directly(view, nullptr, 1), image);
        }
        return image;
    };
    std::vector<std::vector<glm::vec4>> exact;
    const double start = thread_cpu_seconds();
    for (int frame = 9; frame < frames; frame += 10) {
        exact.push_back(direct(frame));
    }
    const double direct_s = (thread_cpu_seconds() - start) / static_cast<double>(exact.size());
    const std::string name = "flight past three cumuli, 320 x 180";
    for (const double scale : {0.25, 0.5, 1.0, 2.0, 4.0, 16.0}) {
        std::vector<SceneObject> objects(3);
        for (std::size_t i = 0; i < objects.size(); ++i) {
            objects[i].id = i + 1;
            objects[i].bounds = {places[i], radius};
            Tolerance& t = objects[i].tolerance;
            t = {scale * t.angle_rad, scale * t.pixels, scale * t.image, scale * t.light, scale * t.content};
        }
        Scheduler scheduler = std::move(Scheduler::create().value());
        CaptureStore store;
        Plan plan;
        std::vector<glm::vec4> image(static_cast<std::size_t>(width) * height);
        DrawSettings settings;
        settings.threads = 1;
        double seen = 0.0;
        double reused = 0.0;
        double least = 1e9;
        double cpu_s = 0.0;
        for (int frame = 0; frame < frames; ++frame) {
            const double before = thread_cpu_seconds();
            const std::vector<SceneView> views{{1, view_at(frame)}};
            scheduler.plan(objects, views, {}, frame / 60.0, plan);
            (void)store.carry_out(plan, objects, views, {}, scheduler,
                                  [&](std::uint64_t id) { return &drawables[static_cast<std::size_t>(id - 1)]; });
            store.draw_view(plan, 0, objects, views, {}, settings, image);
            cpu_s += thread_cpu_seconds() - before;
            if (frame > 0) { // the first has nothing to use again
                seen += plan.report.seen;
                reused += plan.report.reused;
            }
            if (frame % 10 == 9) {
                least = std::min(least, test::tone_mapped_psnr(image, exact[static_cast<std::size_t>(frame / 10)]));
            }
        }
        char method[32];
        std::snprintf(method, sizeof method, "tolerance x %g", scale);
        context.add({"impostors", name, method, 1e9 * cpu_s / frames, 0.0, least,
                     "least PSNR in dB of any tenth frame, larger is better", "direct march", 0.0, 1.0});
        context.add({"impostors", name + ", pictures used again", method, 1e9 * cpu_s / frames, 0.0, reused / seen,
                     "share of the clouds in a frame", "", 0.0, 1.0});
    }
    context.add({"impostors", name, "direct march", 1e9 * direct_s, 0.0, 0.0, "least PSNR", "itself", 0.0, 1.0});
});

const Case real_metric_case("impostors/real-metric", [](const Context& context) {
    constexpr int side = 36; // as fine as the voxels
    const int captures = context.quick() ? 10 : 100;
    const int changes = context.quick() ? 25 : 250; // of view, for each of four representations: 10^5
    std::mt19937 random(23);
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const auto direction = [&] { return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))); };
    std::array<std::vector<double>, 4> ratio;
    for (int n = 0; n < captures; ++n) {
        const test::RealCloud cloud(static_cast<std::uint32_t>(n) + 100U, 16, 0.0F,
                                    static_cast<float>(std::exp(3.0 * uniform(random) - 2.0)));
        const double distance = cloud.bounds.radius_m * (1.8 + std::exp(3.0 * uniform(random) - 1.0));
        const glm::dvec3 c = cloud.bounds.centre_m + distance * direction();
        const clouds::CloudLighting::ViewFields fields =
            cloud.lighting.contract(cloud.volume.transform().index_from_world(c));
        for (std::size_t kind = 0; kind < 4; ++kind) {
            CaptureSettings settings;
            settings.representation = static_cast<Representation>(kind);
            settings.layers = 4;
            const Capture picture = std::move(
                capture(cloud.bounds, *fit_frustum(cloud.bounds, c, {0, 0, 1}, side), settings, cloud.drawable(&fields))
                    .value());
            std::vector<glm::vec4> drawn;
            DrawSettings one_thread;
            one_thread.threads = 1;
            for (int k = 0; k < changes; ++k) {
                const glm::dvec3 e = c + distance * 0.0017 * std::exp(3.9 * uniform(random)) * direction();
                const Frustum view = around(cloud.bounds, e, side);
                const auto exact = cloud.directly(view, &fields, 1);
                drawn.assign(exact.size(), glm::vec4(0.0F));
                draw(picture, view, one_thread, drawn);
                ratio[kind].push_back(predicted_error(picture, e, 2.0) / test::relative_rmse(drawn, exact));
            }
        }
    }
    constexpr std::array names{"plane", "4 layers", "depth warp", "4 warped layers"};
    for (std::size_t kind = 0; kind < 4; ++kind) {
        std::sort(ratio[kind].begin(), ratio[kind].end());
        const auto count = static_cast<double>(ratio[kind].size());
        const auto beyond =
            static_cast<double>(std::lower_bound(ratio[kind].begin(), ratio[kind].end(), 1.0) - ratio[kind].begin());
        context.add({"impostors", "bound of the image error, real clouds", names[kind], 0.0, 0.0, beyond / count,
                     "share of views beyond the bound", "direct march", 0.0, count});
        context.add({"impostors", "bound over measured image error, real clouds", names[kind], 0.0, 0.0,
                     ratio[kind][ratio[kind].size() / 2], "median", "direct march", 0.0, count});
    }
});
#endif

} // namespace
} // namespace alpenglow::bench
