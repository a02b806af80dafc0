#include <alpenglow/probes/receive.hpp>

#include <alpenglow/probes/grid.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace alpenglow::probes {

namespace {

constexpr std::size_t batch_size = 512; // receivers blended together: their light stays in the cache

// Whether the light stands; if not, notes what it is going to be made from.
bool stands(ReceiverSh& light, ReceiverSh::Source source, std::size_t id, std::uint32_t revision,
            const glm::vec3& position_m) {
    if (light.source == source && light.source_id == id && light.source_revision == revision &&
        light.made_from_position_m == position_m) {
        return true;
    }
    light.source = source;
    light.source_id = static_cast<std::uint32_t>(id);
    light.source_revision = revision;
    light.made_from_position_m = position_m;
    ++light.revision;
    return false;
}

template <std::size_t N>
void set(ReceiverSh& light, int order, const std::array<glm::vec3, N>& coefficients) {
    light.order = order;
    std::copy_n(coefficients.begin(), light.coefficients.size(), light.coefficients.begin());
}

} // namespace

void LightSources::add(const ProbeGrid& grid, const ProbeGridSh& light) {
    // A grid that was changed since its update, or is refused, has light of another shape.
    if (light.pass == 0 || light.grid_revision != grid.revision || light.order != grid.order ||
        light.made_pass.size() != probe_count(grid)) {
        return;
    }
    const glm::dvec3 spacing =
        (glm::dvec3(grid.max_m) - glm::dvec3(grid.min_m)) / glm::dvec3(glm::max(grid.count - 1, glm::ivec3(1)));
    grids_.push_back({&grid, &light, spacing.x * spacing.y * spacing.z});
}

void LightSources::add(const LightProbe& probe, const LightProbeSh& light) {
    if (light.order != 0) {
        probes_.push_back({&probe, &light});
    }
}

void LightSources::add(const EnvironmentMapSh& light) {
    if (environment_ == nullptr && light.order != 0) {
        environment_ = &light;
    }
}

Receiving::Receiving(const LightSources& lights) : lights_(lights), batches_(lights.grids_.size()) {}

bool Receiving::add(const ProbeReceiver& receiver, ReceiverSh& light) {
    const glm::vec3& p = receiver.position_m;
    constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
    std::size_t best = none;
    for (std::size_t g = 0; g < lights_.grids_.size(); ++g) {
        if (contains(*lights_.grids_[g].grid, p) &&
            (best == none || lights_.grids_[g].cell_m3 < lights_.grids_[best].cell_m3)) {
            best = g;
        }
    }
    if (best != none) {
        if (stands(light, ReceiverSh::Source::grid, best, lights_.grids_[best].light->revision, p)) {
            return false;
        }
        Batch& batch = batches_[best];
        batch.positions.push_back(p);
        batch.out.push_back(&light);
        if (batch.positions.size() == batch_size) {
            blend_batch(best);
        }
        return true;
    }
    float nearest = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < lights_.probes_.size(); ++i) {
        const LightProbe& probe = *lights_.probes_[i].probe;
        const float distance = glm::distance(probe.position_m, p);
        if (std::islessequal(distance, probe.radius_m) && std::isless(distance, nearest)) {
            nearest = distance;
            best = i;
        }
    }
    if (best != none) {
        const LightProbeSh& source = *lights_.probes_[best].light;
        if (stands(light, ReceiverSh::Source::probe, best, source.revision, p)) {
            return false;
        }
        set(light, source.order, source.coefficients);
        return true;
    }
    if (lights_.environment_ != nullptr) {
        const EnvironmentMapSh& source = *lights_.environment_;
        if (stands(light, ReceiverSh::Source::environment, 0, source.revision, p)) {
            return false;
        }
        set(light, source.order, source.deringed);
        return true;
    }
    if (stands(light, ReceiverSh::Source::none, 0, 0, p)) {
        return false;
    }
    light.order = 0;
    light.coefficients = {};
    return true;
}

void Receiving::blend_batch(std::size_t grid) {
    Batch& batch = batches_[grid];
    const ProbeGridSh& light = *lights_.grids_[grid].light;
    lines_.resize(batch.positions.size() * light.lines);
    (light.packed.empty() ? blend : blend_packed)(*lights_.grids_[grid].grid, light, batch.positions, lines_);
    const auto floats = static_cast<std::size_t>(3 * light.order * light.order);
    for (std::size_t r = 0; r < batch.out.size(); ++r) {
        ReceiverSh& out = *batch.out[r];
        const float* const from = lines_[r * light.lines].values.data();
        if (out.order != light.order) {
            out.coefficients = {};
            out.order = light.order;
        }
        std::copy_n(from, floats, &out.coefficients[0].x);
    }
    batch.positions.clear();
    batch.out.clear();
}

void Receiving::finish() {
    for (std::size_t g = 0; g < batches_.size(); ++g) {
        if (!batches_[g].positions.empty()) {
            blend_batch(g);
        }
    }
}

} // namespace alpenglow::probes
