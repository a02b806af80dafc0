// A costly thing by impostor: docs/impostors.md, "In ten lines".
#include <alpenglow/impostors/store.hpp>

#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include <glm/geometric.hpp>

using namespace alpenglow;
using namespace alpenglow::impostors;

// A ball of fog: what a renderer of its own would draw.
Status draw_fog(const CaptureRequest& request, std::span<SlabImage> slabs) {
    const Frustum& view = request.view;
    for (int i = 0; i < view.width * view.height; ++i) {
        const glm::dvec3 ray = view.direction(i % view.width + 0.5, i / view.width + 0.5); // 1 along the axis
        const double middle = -glm::dot(view.eye_m, ray) / glm::dot(ray, ray);
        const glm::dvec3 closest = view.eye_m + middle * ray;
        const double half = std::sqrt(std::max(0.0, (1.0 - glm::dot(closest, closest)) / glm::dot(ray, ray)));
        for (std::size_t k = 0; k < slabs.size(); ++k) {
            const double from = std::max(middle - half, request.edges_m[k]);
            const double to = std::min(middle + half, request.edges_m[k + 1]);
            if (to <= from) {
                continue;
            }
            const auto alpha = static_cast<float>(1.0 - std::exp(-2.0 * (to - from) * glm::length(ray)));
            const auto s = static_cast<float>((0.5 * (from + to) - request.depth_origin_m) / request.depth_scale_m);
            slabs[k].colour[static_cast<std::size_t>(i)] = alpha * glm::vec4(request.lights.key, 1.0F);
            slabs[k].depth[static_cast<std::size_t>(i)] = alpha * glm::vec2(s, s * s);
        }
    }
    return Ok{};
}

int main() {
    Scheduler scheduler = Scheduler::create().value();
    CaptureStore pictures;
    Plan plan;
    Lights lights;
    const Drawable fog = draw_fog;
    std::vector<SceneObject> objects(1);
    objects[0].id = 1;
    objects[0].bounds = {{0.0, 0.0, 0.0}, 1.0};
    std::vector<glm::vec4> image(160 * 90);
    unsigned captured = 0;
    for (int frame = 0; frame < 120; ++frame) {
        const std::vector<SceneView> views{{1, look_at({0.01 * frame, -5.0, 1.0}, {0, 0, 0}, {0, 0, 1}, 0.8, 160, 90)}};
        scheduler.plan(objects, views, lights, frame / 60.0, plan);
        if (!pictures.carry_out(plan, objects, views, lights, scheduler, [&](std::uint64_t) { return &fog; })) {
            return 1;
        }
        pictures.draw_view(plan, 0, objects, views, lights, {}, image);
        captured += plan.report.captured;
    }
    const float alpha = image[45 * 160 + 80].w;
    std::printf("%u pictures in 120 frames, alpha %.3f in the middle\n", captured, static_cast<double>(alpha));
    return captured < 12 && std::abs(alpha - (1.0F - std::exp(-4.0F))) < 0.01F ? 0 : 1;
}
